"""M1: a motor that prefers some angles."""

from dataclasses import dataclass
from typing import ClassVar, final

from ffgym.core.types import Array
from ffgym.effects.effect import Side, TorqueEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State, Torques
from ffgym.effects.wave import Wave, cycles_per_turn, phase


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Cogging(Wave, TorqueEffect):
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
    cycles: Array = cycles_per_turn(
        1.0, 72.0, 24.0, "least common multiple of poles and slots, 12 to 72, and 1 to 6 by eccentricity"
    )
    phase: Array = phase()

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        return Torques(motor=self.amplitude * self.wave(state.motor_angle)), memory
