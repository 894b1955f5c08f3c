"""Outside the library: torques on one joint that another joint, or a place along the joint, brings about."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects import State, Torques
from ffgym.effects.parameters import parameter
from scripts.exam.equations.variant import Clue, Outsider

_ANGLE = ("angle", "position")
_SPEED = ("speed", "velocity")


def _other(share: Array, joints: tuple[str, ...], joint: str) -> str:
    """The joint that brings the torque on `joint` about."""
    return joints[int(np.argmax(np.abs(share[joints.index(joint)])))]


def _of_others(share: Array, of: Array) -> Array:
    """Sum over j of share_ij `of`_j, one by one, so that a row's bits depend on nothing else."""
    total = np.zeros_like(of)
    for j in range(of.shape[-1]):
        total = total + share[..., :, j] * of[..., j : j + 1]
    return total


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RubbingHose(Outsider):
    """A hose along the arm pulls at one joint where another joint bends it."""

    name: ClassVar[str] = "rubbing_hose"
    title: ClassVar[str] = "torque by the angle of another joint"
    equation: ClassVar[str] = r"\tau_i \mathrel{+}= f_{c,i} \sum_j a_{ij} \sin(6 q_j + \varphi_i)"

    share: Array = parameter("a_ij", unit="1", low=-0.3, high=0.3, per="pair", source="chosen")
    phase: Array = parameter("phi", unit="rad", null=None, low=0.0, high=2 * np.pi, source="any", role="phase")

    def clue(self, joints: tuple[str, ...], joint: str) -> Clue:
        """See base class."""
        return Clue(words=_ANGLE, joint=_other(self.share, joints, joint))

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        sine = _of_others(self.share, np.sin(6 * state.joint_angle))
        cosine = _of_others(self.share, np.cos(6 * state.joint_angle))
        return Torques(motor=state.coulomb * (sine * np.cos(self.phase) + cosine * np.sin(self.phase))), memory


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class StirredOil(Outsider):
    """Oil that one gear stirs pushes another one, always the same way."""

    name: ClassVar[str] = "stirred_oil"
    title: ClassVar[str] = "torque by the speed of another joint, whatever its direction"
    equation: ClassVar[str] = r"\tau_i \mathrel{+}= f_{c,i} \sum_j a_{ij} v_j^2 / (v_r^2 + v_j^2)"

    share: Array = parameter("a_ij", unit="1", low=-0.3, high=0.3, per="pair", source="chosen")
    speed: Array = parameter("v_r", unit="rad/s", null=None, low=5.0, high=15.0, minimum=1e-3, source="chosen")

    def clue(self, joints: tuple[str, ...], joint: str) -> Clue:
        """See base class."""
        return Clue(words=_SPEED, joint=_other(self.share, joints, joint))

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        total = np.zeros_like(state.motor_speed)
        for j in range(total.shape[-1]):
            square = state.motor_speed[..., j : j + 1] * state.motor_speed[..., j : j + 1]
            total = total + self.share[..., :, j] * square / (self.speed * self.speed + square)
        return Torques(motor=state.coulomb * total), memory


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SharedSeal(Outsider):
    """A seal between two shafts: friction of one joint that grows with how fast the other turns."""

    name: ClassVar[str] = "shared_seal"
    title: ClassVar[str] = "friction by the speed of another joint"
    equation: ClassVar[str] = r"\tau_{f,i} \mathrel{+}= f_{c,i}\, s(v_i) \sum_j a_{ij} |v_j| / (v_r + |v_j|)"

    share: Array = parameter("a_ij", unit="1", low=0.0, high=0.4, minimum=0.0, per="pair", source="chosen")
    speed: Array = parameter("v_r", unit="rad/s", null=None, low=5.0, high=15.0, minimum=1e-3, source="chosen")

    def clue(self, joints: tuple[str, ...], joint: str) -> Clue:
        """See base class."""
        return Clue(words=_SPEED, joint=_other(self.share, joints, joint))

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        total = np.zeros_like(state.motor_speed)
        for j in range(total.shape[-1]):
            fast = np.abs(state.motor_speed[..., j : j + 1])
            total = total + self.share[..., :, j] * fast / (self.speed + fast)
        return Torques(motor=-state.coulomb * state.friction_sign * total), memory


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class DamagedTooth(Outsider):
    """One place of the gear at which it rubs; no wave along the turn, as position_friction is."""

    name: ClassVar[str] = "damaged_tooth"
    title: ClassVar[str] = "friction at one place of the joint"
    equation: ClassVar[str] = r"\tau_f \mathrel{+}= a f_c\, e^{-((q - q_0) / w)^2}\, s(v)"

    share: Array = parameter("a, of the Coulomb torque", unit="1", low=0.0, high=1.0, minimum=0.0, source="chosen")
    place: Array = parameter("q_0", unit="rad", null=None, low=-np.pi, high=np.pi, source="within the motions")
    width: Array = parameter("w", unit="rad", null=None, low=0.004, high=0.02, minimum=1e-5, source="chosen: a tooth")

    def clue(self, joints: tuple[str, ...], joint: str) -> Clue:
        """See base class."""
        return Clue(words=_ANGLE, joint=joint)

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        off = (state.joint_angle - self.place) / self.width
        return Torques(motor=-self.share * state.coulomb * np.exp(-off * off) * state.friction_sign), memory
