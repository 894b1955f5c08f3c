"""Parts that move the joints: to positions, rests, and the excitations that identification needs."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, final

import numpy as np

from ffgym.core.errors import FFGymError, check_choice, check_number, check_shape
from ffgym.core.types import Array
from ffgym.paths.circles import DWELL
from ffgym.paths.excitations import joint_sine, multisine, schroeder_phases, speed_ladder, triangle
from ffgym.paths.motion import JointPath
from ffgym.paths.motions.part import OF_RANGE, OF_SPEED, MotionPart, PartContext, entry
from ffgym.paths.moves import Move, MoveJoint, MoveTimed, Speed, Wait, Zone


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class JointsPart(MotionPart):
    """Straight line in joint space to joint positions, as fast as the limits allow or at a tool speed."""

    kind: ClassVar[str] = "joints"
    to: Any = entry(f"joint positions: {OF_RANGE}; joints that a table leaves out go home", "rad or m", default=None)
    to_deg: Any = entry("joint positions of an arm with hinges only, instead of `to`", "deg", default=None)
    speed: Any = entry("largest speed of the TCP; absent is as fast as the joints may", "m/s", default=None)
    zone: float = entry("distance of the TCP from the target at which the corner may begin", "m", default=0.0)

    def moves(self, place: PartContext) -> Sequence[Move]:
        """One move of the joints."""
        if (self.to is None) == (self.to_deg is None):
            raise FFGymError("A joints part needs either to [rad or m] or to_deg [deg].")
        if self.to is not None:
            target = place.joints("to", self.to, place.span, others=place.rest)
        elif np.any(place.robot.kinematics.is_sliding):
            raise FFGymError(f"to_deg is for hinges only, but {place.robot.name!r} has sliding joints; use to.")
        else:
            span, rest = np.rad2deg(place.span), np.rad2deg(place.rest)
            target = np.deg2rad(place.joints("to_deg", self.to_deg, span, others=rest))
        speed = None if self.speed is None else Speed(tcp=self.speed)
        return [MoveJoint(to=target, speed=speed, zone=Zone(radius=self.zone), label=self.label, where=place.where)]


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class WaitPart(MotionPart):
    """Rest where the robot is."""

    kind: ClassVar[str] = "wait"
    duration: float = entry("how long", "s")

    def moves(self, place: PartContext) -> Sequence[Move]:
        """One wait."""
        return [Wait(duration=self.duration, label=self.label, where=place.where)]


@dataclass(frozen=True, kw_only=True, eq=False)
class ExcitationPart(MotionPart):
    """A motion of the joints about a position, with its own time law; no limits slow it down."""

    centre: Any = entry(
        "joint positions in the middle; absent is where the robot is, at first its home", "rad or m", default=None
    )

    def _make_timed_move(
        self, place: PartContext, path: Callable[..., JointPath], *args: Any, **settings: Any
    ) -> list[Move]:
        """Make a move along a path that is made from the joint positions in its middle and the sample time."""
        given = None
        if self.centre is not None:
            given = place.joints("centre", self.centre, place.span, others=place.rest)

        def start(q: Array | None, dt: float) -> JointPath:
            middle = given if given is not None else q if q is not None else place.rest
            return path(middle, *args, **settings, dt=dt)

        return [MoveTimed(path=start, label=self.label, where=place.where)]


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SinePart(ExcitationPart):
    """One sine on every joint, thesis (4.7)-(4.8); it starts at full speed, as there, so nothing comes before it."""

    kind: ClassVar[str] = "sine"
    amplitude: Any = entry(f"link side: {OF_RANGE}", "rad or m")
    frequency: float = entry("frequency", "Hz")
    duration: float = entry("how long", "s")

    def moves(self, place: PartContext) -> Sequence[Move]:
        """One excitation."""
        size = place.joints("amplitude", self.amplitude, place.span)
        frequency = check_number("frequency", self.frequency, unit="Hz", low=0.0, open_low=True)

        def path(q: Array, dt: float) -> JointPath:
            return joint_sine(size, frequency, self.duration, centre=q, dt=dt)

        return self._make_timed_move(place, path)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class MultisinePart(ExcitationPart):
    """Sum of sines on every joint, faded in and out."""

    kind: ClassVar[str] = "multisine"
    amplitude: Any = entry(f"of each sine, link side: {OF_RANGE}; or a list of such, one for each sine", "rad or m")
    frequencies: Any = entry("of the sines", "Hz")
    duration: float = entry("of the sines with their fades", "s")
    phases: Any = entry("'schroeder', or one phase for each sine", "rad", default="schroeder")
    ramp: float = entry("time of fading in, and of fading out", "s", default=0.4)
    dwell: float = entry("rest at both ends", "s", default=DWELL)

    def moves(self, place: PartContext) -> Sequence[Move]:
        """One excitation."""
        frequencies = check_shape("frequencies", self.frequencies, (None,))
        if not len(frequencies):
            raise FFGymError("frequencies is empty, must hold at least one frequency in Hz.")
        rows = [self.amplitude] * len(frequencies)
        if isinstance(self.amplitude, list) and any(isinstance(row, list | dict | str) for row in self.amplitude):
            if len(self.amplitude) != len(rows):
                raise FFGymError(
                    f"amplitude has {len(self.amplitude)} entries, must have one for each of {len(rows)} frequencies."
                )
            rows = self.amplitude
        amplitude = np.stack([place.joints(f"amplitude[{i}]", row, place.span) for i, row in enumerate(rows)])
        if isinstance(self.phases, str):
            check_choice("phases", self.phases, ("schroeder",))
            phases = schroeder_phases(*amplitude.shape)
        else:
            phases = np.tile(check_shape("phases", self.phases, (len(rows),))[:, None], amplitude.shape[1])
        return self._make_timed_move(
            place, multisine, amplitude, frequencies, phases, self.duration, ramp=self.ramp, dwell=self.dwell
        )


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class LadderPart(ExcitationPart):
    """One joint after the other at constant speeds, each forwards and back, thesis (6.2)-(6.3)."""

    kind: ClassVar[str] = "ladder"
    speeds: Any = entry(f"a list of steps, link side, each {OF_SPEED}; 0 skips", "rad/s or m/s")
    travel: Any = entry(f"way at constant speed, link side: {OF_RANGE}", "rad or m")
    longest: float = entry("time after which a slow run turns back", "s", default=10.0)
    ramp: float = entry("time of each change of speed", "s", default=0.2)
    dwell: float = entry("rest at both ends and where a joint has come back", "s", default=DWELL)

    def moves(self, place: PartContext) -> Sequence[Move]:
        """One excitation."""
        if not isinstance(self.speeds, list) or not self.speeds:
            raise FFGymError(f"speeds = {self.speeds!r} must be a list of steps.")
        fastest = place.robot.kinematics.max_speed
        speeds = np.stack([place.joints(f"speeds[{i}]", step, fastest) for i, step in enumerate(self.speeds)])
        travel = place.joints("travel", self.travel, place.span, others=place.span)
        return self._make_timed_move(
            place, speed_ladder, speeds, travel, longest=self.longest, ramp=self.ramp, dwell=self.dwell
        )


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TrianglePart(ExcitationPart):
    """Slow to and fro at constant speed with rounded reversals, for presliding and hysteresis."""

    kind: ClassVar[str] = "triangle"
    amplitude: Any = entry(f"largest way from the middle, link side: {OF_RANGE}", "rad or m")
    period: float = entry("time of one to and fro", "s")
    periods: int = entry("how many", default=2)
    ramp: float = entry("time of each reversal", "s", default=0.2)
    dwell: float = entry("rest at both ends", "s", default=DWELL)

    def moves(self, place: PartContext) -> Sequence[Move]:
        """One excitation."""
        size = place.joints("amplitude", self.amplitude, place.span)
        return self._make_timed_move(place, triangle, size, self.period, self.periods, ramp=self.ramp, dwell=self.dwell)
