"""Motion programs, independent of the robot: lists of moves between targets, with speeds and zones."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_rotation, check_shape
from ffgym.core.types import Array
from ffgym.paths.motion import CartesianPath, JointPath

FARTHEST = 1e3
"""Largest coordinate of a position [m]; beyond it one surely is in another unit, and paths are too long to examine."""
FASTEST = 1e3
"""Largest programmed speed [m/s], and [rad/s] of turning; beyond it one surely is in another unit."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Pose:
    """Target of the tool centre point, and of the orientation of the tool."""

    position: Array
    """TCP in the world [m], shape (3,)."""
    rotation: Array | None = None
    """Orientation of tool0 (the flange) in the world, shape (3, 3); None keeps the one before."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", check_position("position", self.position))
        if self.rotation is not None:
            object.__setattr__(self, "rotation", check_rotation("rotation", self.rotation))


@dataclass(frozen=True, kw_only=True)
class Speed:
    """Programmed speed of a move; the robot's own limits hold beside it."""

    tcp: float
    """Speed of the tool centre point [m/s], > 0."""
    turn: float = np.deg2rad(500.0)
    """Speed of the tool's orientation [rad/s], > 0; 500 deg/s is that of RAPID's predefined speeds."""
    acceleration: float = 1.0
    """Share of the limits of acceleration along the path that the move uses, in (0, 1]."""
    jerk: float = 1.0
    """Share of the limits of jerk along the path that it uses, in (0, 1]."""

    def __post_init__(self) -> None:
        check_number("speed", self.tcp, unit="m/s", low=0.0, high=FASTEST, open_low=True)
        check_number("turning speed", self.turn, unit="rad/s", low=0.0, high=FASTEST, open_low=True)
        for name in ("acceleration", "jerk"):
            check_number(f"share of {name}", getattr(self, name), low=0.0, high=1.0, open_low=True)


@dataclass(frozen=True, kw_only=True)
class Zone:
    """Zone around a target, in which the path may turn towards the next one."""

    radius: float = 0.0
    """Distance of the TCP from the target [m] at which the corner may begin; 0 stops at the target (`fine`)."""

    def __post_init__(self) -> None:
        check_number("zone", self.radius, unit="m", low=0.0)

    @property
    def stops(self) -> bool:
        """True if the robot comes to rest at the target."""
        return self.radius == 0


@dataclass(frozen=True, kw_only=True)
class PathEvent:
    """Something that a program does on the way beside moving, such as setting an output."""

    text: str
    """The instruction, e.g. 'SetDO doLaser, 1'."""
    where: str = ""
    """Place in the program, e.g. 'cut.mod:12:5'."""
    distance: float = 0.0
    """Length along the path [m] before the target of its move at which it happens, >= 0."""
    from_start: bool = False
    """True if `distance` counts from the start of the move instead."""
    lead: float = 0.0
    """Time [s] by which it happens before the tool is there."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Move:
    """One instruction. Members differ in what lies between the last target and this one."""

    zone: Zone = field(default_factory=Zone)
    label: str = ""
    """Name of the target, for phases and messages."""
    where: str = ""
    """Place in the program, e.g. 'cut.mod:12:5', that starts error messages; empty if there is none."""
    events: tuple[PathEvent, ...] = ()
    """What happens on the way, or at the target before the next move."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MoveLinear(Move):
    """Straight line of the TCP; the orientation turns evenly along it."""

    to: Pose
    speed: Speed


@dataclass(frozen=True, kw_only=True, eq=False)
class MoveArc(Move):
    """Arc of the TCP through `via`; the orientation turns evenly along it."""

    via: Array
    """Point on the arc, TCP in the world [m], shape (3,)."""
    to: Pose
    speed: Speed

    def __post_init__(self) -> None:
        object.__setattr__(self, "via", check_position("via", self.via))


@dataclass(frozen=True, kw_only=True, eq=False)
class MoveJoint(Move):
    """Straight line in joint space, all joints together; to joint angles or to a pose."""

    to: Pose | Array
    """Pose, or joint positions, link side, shape (N,) [rad, or m for a sliding joint]."""
    speed: Speed | None = None
    """Speed of the tool; None is as fast as the limits of the joints allow."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MoveSpline(Move):
    """Smooth curve of the TCP through poses, which all or none give an orientation; it stops at both ends.

    It begins where the last move ended, or at its first pose if it comes first.
    """

    through: tuple[Pose, ...]
    """At least one pose beside the start."""
    speed: Speed
    closed: bool = False
    """True for a closed curve, smooth at its start too."""

    def __post_init__(self) -> None:
        if not self.through or len({pose.rotation is None for pose in self.through}) > 1:
            raise FFGymError("A spline needs at least one pose, and all or none of them must give an orientation.")


@dataclass(frozen=True, kw_only=True, eq=False)
class MoveJointSpline(Move):
    """Smooth curve in joint space through joint positions, as fast as the limits allow; it stops at both ends.

    It begins where the last move ended, or at its first positions if it comes first.
    """

    through: Array
    """Joint positions, link side [rad, or m for a sliding joint], shape (K, N)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MoveTimed(Move):
    """A motion that brings its own time law, such as an excitation of the joints; no limits slow it down."""

    path: Callable[[Array | None, float], JointPath | CartesianPath]
    """Makes the path from the joint positions at which it is to start, shape (N,), None if it is the first move, and
    the sample time [s]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Wait(Move):
    """Rest where the last move ended; that move must stop."""

    duration: float
    """[s], > 0."""

    def __post_init__(self) -> None:
        check_number("wait", self.duration, unit="s", low=0.0, open_low=True)


ToolMove = MoveLinear | MoveArc | MoveSpline
"""Moves whose path is given in space."""

JointMove = MoveJoint | MoveJointSpline
"""Moves whose path is given in joint space."""


def check_position(name: str, value: Array) -> Array:
    """Return `value` as a position [m], shape (3,)."""
    position = check_shape(name, value, (3,))
    if np.abs(position).max() > FARTHEST:
        raise FFGymError(f"{name} = {position.tolist()} m is beyond {FARTHEST:g} m; is it in another unit?")
    return position


def locate_error(move: Move, message: str) -> FFGymError:
    """Return an error that begins with the move's place in the program, if it has one."""
    return FFGymError(f"{move.where}: {message}" if move.where else message)
