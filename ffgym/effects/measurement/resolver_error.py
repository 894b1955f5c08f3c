"""M6: the resolver's reading wobbles with the motor angle."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects.effect import ResolverEffect, Side
from ffgym.effects.parameters import parameter
from ffgym.effects.state import ResolverError


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ResolverRipple(ResolverEffect):
    """Periodic error of the measured motor angle, on which the servo acts."""

    name: ClassVar[str] = "resolver_ripple"
    code: ClassVar[str] = "M6"
    title: ClassVar[str] = "periodic resolver error"
    equation: ClassVar[str] = r"\theta_{meas} = \theta + A \sin(k \theta + \varphi)"
    side: ClassVar[Side] = "motor"
    signature: ClassVar[str] = (
        "torque: grows with the speed squared; tool: periodic, the same at any speed; servo error too"
    )
    way_in: ClassVar[str] = "added to what the servo compares with its set-points, and to the recorded motor angle"
    confusable_with: ClassVar[tuple[str, ...]] = ("T5",)
    separating_motions: ClassVar[tuple[str, ...]] = ("slow_triangles", "circles")
    patterns: ClassVar[tuple[tuple[str, str], ...]] = (("periodic", "motor angle"),)

    amplitude: Array = parameter(
        "A, motor side",
        unit="rad",
        low=0.0,
        high=3e-3,
        minimum=0.0,
        source="1 to 10 arcmin, data sheets of resolvers",
    )
    cycles: Array = parameter(
        "k, per motor turn",
        role="cycles",
        unit="1",
        null=None,
        low=1.0,
        high=2.0,
        minimum=0.0,
        default=2.0,
        source="1: eccentricity; 2: unequal windings",
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

    def error(self, motor_angle: Array, motor_speed: Array) -> ResolverError:
        """See base class."""
        angle = self.cycles * motor_angle + self.phase
        slope = self.amplitude * self.cycles * np.cos(angle)
        return ResolverError(angle=self.amplitude * np.sin(angle), speed=slope * motor_speed)
