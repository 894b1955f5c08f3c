"""M2: a motor whose torque per current depends on its angle."""

from dataclasses import dataclass
from typing import final

from ffgym.core.types import Array
from ffgym.effects.effect import TorqueEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State, Torques
from ffgym.effects.wave import Wave, cycles_per_turn, phase


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TorqueRipple(Wave, TorqueEffect):
    """Torque that is more and less than commanded, by a share that is periodic in the motor angle."""

    name = "torque_ripple"
    code = "M2"
    title = "torque ripple"
    equation = r"\tau \mathrel{+}= r\, u \sin(k \theta + \varphi)"
    side = "motor"
    signature = "torque: periodic in the motor angle, amplitude proportional to the torque"
    way_in = "torque at every physics step, a share of what the servo commands"
    confusable_with = ("M1",)
    separating_motions = ("slow_triangles", "holds")
    patterns = (("periodic", "motor angle"),)

    share: Array = parameter(
        "r", unit="1", low=0.0, high=0.05, minimum=0.0, maximum=1.0, source="1 to 5 %; from memory of the literature"
    )
    cycles: Array = cycles_per_turn(1.0, 36.0, 6.0, "1, 2 and 6 times the electrical angle, with 1 to 6 pole pairs")
    phase: Array = phase()

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """Return the ripple of the torque that the servo commands."""
        return Torques(motor=self.share * state.loop_torque * self.wave(state.motor_angle)), memory
