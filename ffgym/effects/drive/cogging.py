"""M1: a motor that prefers some angles."""

from dataclasses import dataclass
from typing import final

from ffgym.core.types import Array
from ffgym.effects.effect import TorqueEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State, Torques
from ffgym.effects.wave import Wave, cycles_per_turn, phase


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Cogging(Wave, TorqueEffect):
    """Torque between magnets and teeth of the motor, without any current."""

    name = "cogging"
    code = "M1"
    title = "cogging"
    equation = r"\tau \mathrel{+}= A \sin(k \theta + \varphi)"
    side = "motor"
    signature = "torque: periodic in the motor angle, the same at any load, speed and direction"
    way_in = (
        "torque at every physics step; MuJoCo's dcmotor has cogging, but it would hide in the actuator that is the "
        "friction, and a recording is evaluated by the same formula"
    )
    confusable_with = ("F9", "M2", "T5")
    separating_motions = ("slow_triangles", "holds")
    patterns = (("periodic", "motor angle"),)

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
        """Return the cogging torque at the motor angle."""
        return Torques(motor=self.amplitude * self.wave(state.motor_angle)), memory
