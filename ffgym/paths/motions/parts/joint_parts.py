"""Parts that move the joints from one position to another, and rests."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, final

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.paths.motions.parts.part import Part, entry
from ffgym.paths.motions.parts.place import OF_RANGE, Place
from ffgym.paths.moves import Move, MoveJoint, Speed, Wait, Zone


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class JointsPart(Part):
    """Straight line in joint space to joint positions, as fast as the limits allow or at a tool speed."""

    kind: ClassVar[str] = "joints"
    to: Any = entry(f"joint positions: {OF_RANGE}; joints that a table leaves out go home", "rad or m", default=None)
    to_deg: Any = entry("joint positions of an arm with hinges only, instead of `to`", "deg", default=None)
    speed: Any = entry("largest speed of the TCP; absent is as fast as the joints may", "m/s", default=None)
    zone: float = entry("distance of the TCP from the target at which the corner may begin", "m", default=0.0)

    def moves(self, place: Place) -> Sequence[Move]:
        """One move of the joints."""
        speed = None if self.speed is None else Speed(tcp=self.speed)
        zone = Zone(radius=self.zone)
        return [MoveJoint(to=self._target(place), speed=speed, zone=zone, label=self.label, where=place.where)]

    def _target(self, place: Place) -> Array:
        if (self.to is None) == (self.to_deg is None):
            raise FFGymError("A joints part needs either to [rad or m] or to_deg [deg].")
        if self.to is not None:
            return place.joints("to", self.to, place.span, others=place.rest)
        if np.any(place.robot.kinematics.is_sliding):
            raise FFGymError(f"to_deg is for hinges only, but {place.robot.name!r} has sliding joints; use to.")
        target: Array = np.deg2rad(
            place.joints("to_deg", self.to_deg, np.rad2deg(place.span), others=np.rad2deg(place.rest))
        )
        return target


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class WaitPart(Part):
    """Rest where the robot is."""

    kind: ClassVar[str] = "wait"
    duration: float = entry("how long", "s")

    def moves(self, place: Place) -> Sequence[Move]:
        """One wait."""
        return [Wait(duration=self.duration, label=self.label, where=place.where)]
