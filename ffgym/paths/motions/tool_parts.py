"""Parts that move the tool: lines, arcs, circles, splines, and the circle test of the thesis."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, final

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_shape, check_whole
from ffgym.core.types import Array
from ffgym.paths.circles import DWELL, RADII, circle_test, plane_of
from ffgym.paths.curves import arc_about
from ffgym.paths.motions.part import FIRST, MotionPart, PartContext, entry, rotation_of
from ffgym.paths.moves import FARTHEST, Move, MoveArc, MoveLinear, MoveSpline, MoveTimed, Pose, Speed, Zone

TURN_SPEED_DEG = 500.0
"""Default turning speed of the tool [deg/s]: that of RAPID's predefined speeds."""
MOST_TURNS = 1000
"""Most turns of a circle; more are surely a slip."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ToolPart(MotionPart):
    """A part in which the tool moves at a programmed speed."""

    speed: float = entry("of the TCP along the path", "m/s")
    turn_speed_deg: float = entry("largest turning speed of the tool", "deg/s", default=TURN_SPEED_DEG)

    @property
    def _speed(self) -> Speed:
        turn = check_number("turn_speed_deg", self.turn_speed_deg, unit="deg/s", low=0.0, open_low=True)
        return Speed(tcp=self.speed, turn=float(np.deg2rad(turn)))


@dataclass(frozen=True, kw_only=True, eq=False)
class TargetPart(ToolPart):
    """A part with one target pose."""

    to: Any = entry("target of the TCP: a point, or the name of one of the work area", "m")
    zone: float = entry("distance from the target at which the corner may begin; 0 stops there", "m", default=0.0)
    rpy_deg: Any = entry("orientation of tool0: roll, pitch, yaw about x, y, z; absent keeps it", "deg", default=None)
    quaternion: Any = entry("orientation of tool0: w, x, y, z, instead of rpy_deg", "1", default=None)

    def _how(self, place: PartContext) -> dict[str, Any]:
        """Fields of the move to the target."""
        pose = Pose(position=place.point("to", self.to), rotation=rotation_of(self.rpy_deg, self.quaternion))
        zone = Zone(radius=self.zone)
        return {"to": pose, "speed": self._speed, "zone": zone, "label": self.label, "where": place.where}


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class LinePart(TargetPart):
    """Straight line of the TCP."""

    kind: ClassVar[str] = "line"

    def moves(self, place: PartContext) -> Sequence[Move]:
        """One line."""
        return [MoveLinear(**self._how(place))]


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ArcPart(TargetPart):
    """Arc of the TCP through a point."""

    kind: ClassVar[str] = "arc"
    via: Any = entry("a point on the arc", "m")

    def moves(self, place: PartContext) -> Sequence[Move]:
        """One arc."""
        return [MoveArc(via=place.point("via", self.via), **self._how(place))]


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class CirclePart(ToolPart):
    """Full circles of the TCP about a point, from rest to rest; a line leads to their start."""

    kind: ClassVar[str] = "circle"
    centre: Any = entry("centre: a point, or the name of one of the work area", "m")
    radius: float = entry("radius", "m")
    normal: Any = entry(
        "normal of the plane, about which it turns by the right hand; absent is that of the work area",
        "1",
        default=None,
    )
    start_deg: float = entry("where it starts, from the plane's first axis (x where possible)", "deg", default=-90.0)
    turns: int = entry("how many circles", default=1)

    def moves(self, place: PartContext) -> Sequence[Move]:
        """A line to the start, and two arcs for each circle."""
        centre = place.point("centre", self.centre)
        radius = check_number("radius", self.radius, unit="m", low=0.0, high=FARTHEST, open_low=True)
        plane = plane_of(place.normal(self.normal))
        angle = np.deg2rad(check_number("start_deg", self.start_deg, unit="deg"))
        arm = radius * (np.cos(angle) * plane.first + np.sin(angle) * plane.second)
        turns = check_whole("turns", self.turns, low=1, high=MOST_TURNS)
        label = self.label or f"circle {radius * 1e3:g} mm"
        # circle as half circles, each through a quarter point, as robot controllers take them
        circle = arc_about(centre, centre + arm, np.cross(plane.first, plane.second), 2 * np.pi)
        quarters = circle.at(np.linspace(0.0, circle.length, 5))[0]
        start = MoveLinear(to=Pose(position=quarters[0]), speed=self._speed, label=f"to {label}", where=place.where)
        halves = [
            MoveArc(
                via=quarters[via],
                to=Pose(position=quarters[to]),
                speed=self._speed,
                zone=Zone(radius=radius),
                label=label,
                where=place.where,
            )
            for via, to in [(1, 2), (3, 0)] * turns
        ]
        return [start, *halves[:-1], replace(halves[-1], zone=Zone())]


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SplinePart(ToolPart):
    """Smooth curve of the TCP through points, from rest to rest."""

    kind: ClassVar[str] = "spline"
    through: Any = entry("points, each [x, y, z] or a name; it starts where the robot is, or at the first", "m")
    rpy_deg: Any = entry("orientation of tool0 at each point; absent keeps it", "deg", default=None)
    closed: bool = entry("whether it ends where it starts, smoothly; the last point must be the start", default=False)

    def moves(self, place: PartContext) -> Sequence[Move]:
        """One spline."""
        if not isinstance(self.through, list) or not self.through:
            raise FFGymError(f"through = {self.through!r} must be a list of points.")
        points = [place.point(f"through[{i}]", point) for i, point in enumerate(self.through)]
        turns = [None] * len(points) if self.rpy_deg is None else check_shape("rpy_deg", self.rpy_deg, (len(points), 3))
        poses = tuple(Pose(position=p, rotation=rotation_of(turn, None)) for p, turn in zip(points, turns, strict=True))
        if not isinstance(self.closed, bool):
            raise FFGymError(f"closed = {self.closed!r} must be true or false.")
        return [MoveSpline(through=poses, speed=self._speed, closed=self.closed, label=self.label, where=place.where)]


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class CircleTestPart(MotionPart):
    """The test motion of the thesis: circles around a common start point, each led in and out (2.2.5)."""

    kind: ClassVar[str] = "circle_test"
    speed: float = entry("TCP speed on the circles", "m/s")
    centre: Any = entry("common centre and start: a point, or the name of one of the work area", "m", default=FIRST)
    radii: Any = entry("radii, in the order in which they run", "m", default=RADII)
    normal: Any = entry("normal of the plane; absent is that of the work area", "1", default=None)
    start_deg: float = entry("where each circle is joined, from the plane's first axis", "deg", default=-90.0)
    dwell: float = entry("rest before, between and after the circles", "s", default=DWELL)

    def moves(self, place: PartContext) -> Sequence[Move]:
        """One motion with its own time law."""
        centre = place.point("centre", self.centre)
        normal = place.normal(self.normal)
        start_angle = float(np.deg2rad(check_number("start_deg", self.start_deg, unit="deg")))

        def path(_: Array | None, dt: float) -> Any:
            return circle_test(
                centre,
                self.speed,
                radii=self.radii,
                normal=normal,
                start_angle=start_angle,
                dwell=self.dwell,
                dt=dt,
            )

        return [MoveTimed(path=path, label=self.label, where=place.where)]
