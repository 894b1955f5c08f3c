"""F8: viscous friction that grows more, or less, than in proportion to the speed."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects.effect import Side, TorqueEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State, Torques


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class NonlinearViscous(TorqueEffect):
    """Viscous friction with a square term; a negative one is a lubricant that thins when it is sheared."""

    name: ClassVar[str] = "nonlinear_viscous"
    code: ClassVar[str] = "F8"
    title: ClassVar[str] = "nonlinear viscous friction"
    equation: ClassVar[str] = r"\tau_f \mathrel{+}= a f_v\, v\, |v| / v_r"
    side: ClassVar[Side] = "motor"
    signature: ClassVar[str] = "torque: odd in the speed, curved at high speed"
    way_in: ClassVar[str] = (
        "torque at every physics step; MuJoCo's damping polynomial would do, but a recording is evaluated by the same "
        "formula"
    )
    confusable_with: ClassVar[tuple[str, ...]] = ("F2", "F7")
    separating_motions: ClassVar[tuple[str, ...]] = ("speed_ladder",)
    needs_friction: ClassVar[bool] = True
    patterns: ClassVar[tuple[tuple[str, str], ...]] = (
        ("sign-locked function", "size of the motor speed"),
        ("function", "motor speed"),
    )

    share: Array = parameter(
        "a, more viscous friction at speed v_r, as a share of it",
        unit="1",
        low=-0.3,
        high=0.3,
        source="chosen: a third of viscous friction at top speed",
    )
    speed: Array = parameter(
        "v_r, motor side",
        unit="rad/s",
        null=None,
        low=100.0,
        high=600.0,
        minimum=1e-3,
        default=300.0,
        scale="top_speed",
        source="top speed of robot motors, 1000 to 6000 turns per minute",
    )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        v = state.motor_speed
        return Torques(motor=-self.share * state.viscous * v * np.abs(v) / self.speed), memory
