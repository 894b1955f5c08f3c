"""X5: a torque column that is late."""

from dataclasses import dataclass
from typing import final

from ffgym.core.types import Array
from ffgym.effects.effect import ClockEffect
from ffgym.effects.parameters import parameter


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TorqueClock(ClockEffect):
    """Motor torques in rows of a later time than the positions beside them, all joints alike.

    The opposite, a torque that acts after its row, is the delay of the drive or of the positions' way into the log.
    """

    name = "torque_clock"
    code = "X5"
    title = "torque out of step with position"
    equation = r"u_{log}(t) = u(t - d)"
    side = "controller"
    signature = "torque of all joints: proportional to its own rate of change, with one and the same time"
    way_in = "recorded motor torques; nothing that acts on the machine changes"
    confusable_with = ("M5",)
    separating_motions = ("excitation",)
    families = ("motor.effort",)

    latency: Array = parameter(
        "d",
        unit="s",
        low=0.0,
        high=0.02,
        minimum=0.0,
        per="machine",
        source="chosen: some rows of a log of 100 to 1000 Hz; at 10 Hz a single row is 0.1 s",
    )
