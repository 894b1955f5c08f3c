"""Elasticity of joints in other shapes: gaps with round edges, springs in steps, hysteresis by Dahl."""

from dataclasses import dataclass, replace
from typing import ClassVar, final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects import NativeEffect, State, TorqueEffect, Torques
from ffgym.effects.effect import Side
from ffgym.effects.parameters import parameter
from ffgym.robot import RobotDescription
from scripts.exam.equations.dahl import lagging
from scripts.exam.equations.variant import Variant


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class StifferAlone(Variant, NativeEffect):
    """Another stiffness whose damping does not follow."""

    name: ClassVar[str] = "stiffer_alone"
    variant_of: ClassVar[str] = "joint_stiffness"
    title: ClassVar[str] = "joint stiffness without its damping"
    equation: ClassVar[str] = r"k \to (1 + e)\, k, \quad d \to (1 - e / 2)\, d"
    side: ClassVar[Side] = "link"
    way_in: ClassVar[str] = "native: stiffness and damping of MuJoCo's deflection joint"
    needs_elasticity: ClassVar[bool] = True

    change: Array = parameter("e", unit="1", low=-0.3, high=0.3, minimum=-0.9, maximum=1.5, source="as joint_stiffness")

    def in_description(self, robot: RobotDescription) -> RobotDescription:
        """See base class."""
        drive = robot.drive
        other = replace(
            drive,
            joint_stiffness=drive.joint_stiffness * (1 + self.change),
            joint_damping=drive.joint_damping * (1 - self.change / 2),
        )
        return replace(robot, drive=other)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RoundGap(Variant, TorqueEffect):
    r"""A gap whose edges are round, as teeth bend before they bear.

    The spring is wound by :math:`\delta - b \tanh(\delta / b)`, and damped as far as it is wound.
    """

    name: ClassVar[str] = "round_gap"
    variant_of: ClassVar[str] = "backlash"
    title: ClassVar[str] = "backlash with round edges"
    equation: ClassVar[str] = r"\tau_l = -k\, (\delta - b \tanh(\delta / b)) - d\, \dot\delta \tanh^2(\delta / b)"
    side: ClassVar[Side] = "link"
    needs_elasticity: ClassVar[bool] = True

    half_gap: Array = parameter("b, link side", unit="rad", low=0.0, high=3e-4, minimum=0.0, source="as backlash")

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        bent, gap = state.deflection, self.half_gap
        x = np.tanh(np.divide(bent, gap, out=np.full_like(bent, np.inf), where=gap > 0))
        return Torques(
            spring=state.joint_stiffness * gap * x + state.joint_damping * state.deflection_rate * (1 - x * x)
        ), memory


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SteppedSpring(Variant, TorqueEffect):
    """A spring that gets stiffer in one step, as where more teeth begin to bear."""

    name: ClassVar[str] = "stepped_spring"
    variant_of: ClassVar[str] = "hardening"
    title: ClassVar[str] = "stiffness in two steps"
    equation: ClassVar[str] = r"\tau_l \mathrel{-}= k\, g\, (\delta - \mathrm{clip}(\delta, \pm w))"
    side: ClassVar[Side] = "link"
    needs_elasticity: ClassVar[bool] = True

    growth: Array = parameter(
        "g, more stiffness as a share of it", unit="1", low=0.0, high=1.5, minimum=0.0, source="chosen: as hardening"
    )
    width: Array = parameter(
        "w, deflection at which it sets in, link side",
        unit="rad",
        null=None,
        low=1e-4,
        high=4e-4,
        minimum=0.0,
        source="chosen: a tenth to a third of the deflection at rated torque",
    )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        bent = state.deflection
        beyond = bent - np.minimum(np.maximum(bent, -self.width), self.width)
        return Torques(spring=-state.joint_stiffness * self.growth * beyond), memory


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class QuinticSpring(Variant, TorqueEffect):
    """A spring that gets stiffer with the fourth power of its deflection."""

    name: ClassVar[str] = "quintic_spring"
    variant_of: ClassVar[str] = "hardening"
    title: ClassVar[str] = "stiffness that grows with the fourth power"
    equation: ClassVar[str] = r"\tau_l = -k\, \delta\, (1 + h\, (\delta / \mathrm{mrad})^4)"
    side: ClassVar[Side] = "link"
    needs_elasticity: ClassVar[bool] = True

    growth: Array = parameter(
        "h, at a milliradian", unit="1", low=0.0, high=0.5, minimum=0.0, source="chosen: as hardening there"
    )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        square = (state.deflection * 1e3) * (state.deflection * 1e3)
        return Torques(spring=-state.joint_stiffness * self.growth * state.deflection * (square * square)), memory


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class DahlHysteresis(Variant, TorqueEffect):
    """Lost motion whose loop is round."""

    name: ClassVar[str] = "dahl_hysteresis"
    variant_of: ClassVar[str] = "torsional_hysteresis"
    title: ClassVar[str] = "torsional hysteresis by Dahl"
    equation: ClassVar[str] = (
        r"\tau_l = -k\, (\delta + h z), \quad z' = (1 - z\, \mathrm{sgn}\, \dot\delta)\, \dot\delta / w"
    )
    side: ClassVar[Side] = "link"
    needs_elasticity: ClassVar[bool] = True

    lost_motion: Array = parameter(
        "h, link side", unit="rad", low=0.0, high=1.5e-4, minimum=0.0, source="as torsional_hysteresis"
    )
    width: Array = parameter(
        "w, deflection over which it turns round, link side",
        unit="rad",
        null=None,
        low=5e-5,
        high=2e-4,
        minimum=1e-7,
        source="chosen: as torsional_hysteresis",
    )

    def initial_memory(self, state: State) -> Array:
        """Relaxed at rest, shape (..., N, 1)."""
        return np.zeros((*state.deflection.shape, 1))

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        z = memory[..., 0]
        spring = -state.joint_stiffness * self.lost_motion * z
        return Torques(spring=spring), lagging(z, state.deflection_rate * dt, self.width)[..., None]
