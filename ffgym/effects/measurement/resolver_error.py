"""M6: the resolver's reading wobbles with the motor angle."""

from dataclasses import dataclass
from typing import final

from ffgym.core.types import Array
from ffgym.effects.effect import ResolverEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import ResolverError
from ffgym.effects.wave import Wave, cycles_per_turn, phase


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ResolverRipple(Wave, ResolverEffect):
    """Periodic error of the measured motor angle, on which the servo acts."""

    name = "resolver_ripple"
    code = "M6"
    title = "periodic resolver error"
    equation = r"\theta_{meas} = \theta + A \sin(k \theta + \varphi)"
    side = "motor"
    signature = "torque: grows with the speed squared; tool: periodic, the same at any speed; servo error too"
    way_in = "added to what the servo compares with its set-points, and to the recorded motor angle"
    confusable_with = ("T5",)
    separating_motions = ("slow_triangles", "circles")
    patterns = (("periodic", "motor angle"),)

    amplitude: Array = parameter(
        "A, motor side",
        unit="rad",
        low=0.0,
        high=3e-3,
        minimum=0.0,
        source="1 to 10 arcmin, data sheets of resolvers",
    )
    cycles: Array = cycles_per_turn(1.0, 2.0, 2.0, "1: eccentricity; 2: unequal windings")
    phase: Array = phase()

    def error(self, motor_angle: Array, motor_speed: Array) -> ResolverError:
        """Return the wave at the motor angle, and its rate."""
        slope = self.slope(self.amplitude, motor_angle)
        return ResolverError(angle=self.amplitude * self.wave(motor_angle), speed=slope * motor_speed)
