"""X6: encoders behind the gearbox that are late."""

from dataclasses import dataclass
from typing import final

from ffgym.core.types import Array
from ffgym.effects.effect import ClockEffect
from ffgym.effects.parameters import parameter


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class LinkClock(ClockEffect):
    """Link positions in rows of a later time than the motor positions beside them, all joints alike.

    Drawn over the motor angle, or over the sign of its speed, it is a loop as of backlash; unlike one, it grows with
    the speed.
    """

    name = "link_clock"
    code = "X6"
    title = "link encoders out of step with motor encoders"
    equation = r"q_{log}(t) = q(t - d)"
    side = "link"
    signature = "link encoder: proportional to the speed of its joint, torque nothing"
    way_in = "recorded link positions and speeds; nothing that acts on the machine changes"
    confusable_with = ("T4",)
    separating_motions = ("speed_ladder", "slow_triangles")
    families = ("link.position", "link.velocity")

    latency: Array = parameter(
        "d",
        unit="s",
        low=0.0,
        high=0.005,
        minimum=0.0,
        per="machine",
        source="chosen: a cycle or two of a drive's bus, 1 to 4 ms each",
    )
