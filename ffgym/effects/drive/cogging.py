"""M1: a motor that prefers some angles."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects.effect import Side, TorqueEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State, Torques


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Cogging(TorqueEffect):
    """Torque between magnets and teeth of the motor, without any current."""

    name: ClassVar[str] = "cogging"
    code: ClassVar[str] = "M1"
    title: ClassVar[str] = "cogging"
    equation: ClassVar[str] = r"\tau \mathrel{+}= A \sin(k \theta + \varphi)"
    side: ClassVar[Side] = "motor"
    signature: ClassVar[str] = "torque: periodic in the motor angle, the same at any load, speed and direction"
    way_in: ClassVar[str] = (
        "torque at every physics step; MuJoCo's dcmotor has cogging, but it would hide in the actuator that is the "
        "friction, and a recording is evaluated by the same formula"
    )
    confusable_with: ClassVar[tuple[str, ...]] = ("F9", "M2", "T5")
    separating_motions: ClassVar[tuple[str, ...]] = ("slow_triangles", "holds")
    patterns: ClassVar[tuple[tuple[str, str], ...]] = (("periodic", "motor angle"),)

    amplitude: Array = parameter(
        "A, motor side",
        unit="N m",
        low=0.0,
        high=0.3,
        minimum=0.0,
        source="1 to 5 % of rated torque (MuJoCo's documentation of dcmotor), here of motors of 2 to 8 N m",
    )
    cycles: Array = parameter(
        "k, per motor turn",
        role="cycles",
        unit="1",
        null=None,
        low=1.0,
        high=72.0,
        minimum=0.0,
        default=24.0,
        source="least common multiple of poles and slots, 12 to 72, and 1 to 6 by eccentricity",
    )
    phase: Array = parameter(
        "phi",
        unit="rad",
        null=None,
        low=0.0,
        high=2 * np.pi,
        default=0.0,
        role="phase",
        source="any; where the motor's zero lies",
    )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        return Torques(motor=self.amplitude * np.sin(self.cycles * state.motor_angle + self.phase)), memory
