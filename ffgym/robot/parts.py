"""The parts of a robot description: geometry, masses, tool, servo, sensors, work area, springs, logs, looks."""

import copyreg
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from ffgym.core.errors import FFGymError, check_choice, check_rotation
from ffgym.core.types import Array, BoolArray
from ffgym.recordings.header import PositionSide, TorqueSemantics
from ffgym.robot.reading.rules import check_part


@dataclass(frozen=True, kw_only=True, eq=False)
class Mesh:
    """A surface of triangles."""

    vertices: NDArray[np.float32]
    """Corners [m], shape (V, 3)."""
    faces: NDArray[np.int32]
    """Three corners each, counter-clockwise from outside, shape (F, 3)."""


@dataclass(frozen=True, kw_only=True)
class Geom:
    """One shape of the robot's looks, in the frame of its body."""

    body: str
    type: str
    """'box', 'sphere', 'ellipsoid', 'cylinder', 'capsule' or 'mesh'."""
    size: tuple[float, ...]
    """Radius, or half sizes of a box or ellipsoid [m]; empty for a mesh."""
    pos: tuple[float, float, float]
    """Centre, or first end of a cylinder or capsule [m]."""
    end: tuple[float, float, float] | None
    """Second end of a cylinder or capsule [m]."""
    colour: tuple[float, ...]
    """Red, green, blue, opacity."""
    rotation: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    """Unit quaternion, scalar first; of no use to a cylinder or capsule."""
    mesh: Mesh | None = None
    """Surface of a mesh."""


JOINT_TYPES = ("hinge", "slide")
"""Types of joints."""

LIMIT_ROUNDING = 1e-9
"""Tolerance of joint limits [rad or m]: more than computed joint positions are off by, and less than
any drive measures."""

_BALL = 0.01
"""Radius [m] of the ball that stands for a point mass; chosen: small beside any tool."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Kinematics:
    """Serial chain of joints; at q = 0 all link frames are parallel to the world. A sliding joint has m for rad."""

    position: Array
    """Origin of each joint in the previous link frame [m], shape (N, 3)."""
    axis: Array
    """Unit axis of each joint in its link frame, shape (N, 3)."""
    range: Array
    """Lower and upper joint limit, link side [rad], shape (N, 2)."""
    max_speed: Array
    """Joint speed limit, link side [rad/s], shape (N,)."""
    types: tuple[str, ...] = ()
    """'hinge' or 'slide', one per joint; empty is all hinges."""

    def __post_init__(self) -> None:
        check_part("kinematics", self, len(np.atleast_1d(self.axis)))
        if np.any(np.abs(np.hypot.reduce(self.axis, axis=1) - 1) > 1e-6):
            raise FFGymError(f"kinematics.axis = {self.axis.tolist()} must be unit vectors.")
        if np.any(self.range[:, 0] >= self.range[:, 1]):
            raise FFGymError(f"kinematics.range = {self.range.tolist()} must be lower before upper limit.")
        object.__setattr__(self, "types", tuple(self.types) or ("hinge",) * len(self.axis))
        for kind in self.types:
            check_choice("joint type", kind, JOINT_TYPES)
        if len(self.types) != len(self.axis):
            raise FFGymError(f"There are {len(self.types)} joint types, {self.types}, for {len(self.axis)} joints.")

    @property
    def is_sliding(self) -> BoolArray:
        """True for sliding joints, shape (N,)."""
        return np.array([kind == "slide" for kind in self.types])

    def beyond_limits(self, q: Array) -> BoolArray:
        """True where joint positions `q` (..., N), link side, are beyond a limit, same shape."""
        low, high = self.range.T
        beyond: BoolArray = (q < low - LIMIT_ROUNDING) | (q > high + LIMIT_ROUNDING)
        return beyond

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of each joint's position on the link side, 'rad' or 'm'."""
        return tuple("m" if kind == "slide" else "rad" for kind in self.types)


@dataclass(frozen=True, kw_only=True, eq=False)
class Links:
    """Rigid bodies that the joints move."""

    mass: Array
    """Masses [kg], shape (N,)."""
    com: Array
    """Centre of mass in the link frame [m], shape (N, 3)."""
    inertia: Array
    """Inertia about the centre of mass [kg m^2], order xx, yy, zz, xy, xz, yz, shape (N, 6)."""

    def __post_init__(self) -> None:
        check_part("links", self, np.size(self.mass))
        for i, inertia in enumerate(self.inertia):
            _check_inertia(f"links.inertia[{i}]", inertia)


@dataclass(frozen=True, kw_only=True, eq=False)
class Tool:
    """Tool on the flange, given in the tool0 frame."""

    rotation: Array
    """Orientation of tool0 in the last link frame, shape (3, 3)."""
    tcp: Array
    """Tool centre point [m], shape (3,)."""
    position: Array = field(default_factory=lambda: np.zeros(3))
    """Origin of tool0 in the last link frame [m], shape (3,)."""
    mass: float = 0.0
    """Mass [kg]; 0 for a tool that weighs nothing, or is part of the last link."""
    com: Array = field(default_factory=lambda: np.zeros(3))
    """Centre of mass [m], shape (3,)."""
    inertia: Array = field(default_factory=lambda: np.zeros(6))
    """Inertia about the centre of mass [kg m^2], order xx, yy, zz, xy, xz, yz, shape (6,)."""

    def __post_init__(self) -> None:
        check_part("flange", self, 0)
        check_part("tool", self, 0)
        check_rotation("flange.rotation", self.rotation)
        if self.mass > 0:
            _check_inertia("tool.inertia", self.inertia)
        elif np.any(self.inertia):
            raise FFGymError(f"tool.inertia = {self.inertia.tolist()} kg m^2 must be 0, as tool.mass is 0.")


@dataclass(frozen=True, kw_only=True, eq=False)
class Servo:
    """The existing feedback controller of each motor, motor side, one entry per joint."""

    position_gain: Array
    """K_p [N m/rad], shape (N,)."""
    velocity_gain: Array
    """K_v [N m s/rad], shape (N,)."""
    integral_gain: Array
    """K_i [N m/(rad s)], shape (N,)."""
    control_dt: float
    """Sample time of references and torques sent to the drive [s]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Sensors:
    """Sensors of the machine, and the laser tracker."""

    encoder_bits: int
    """Resolution of the motor position [bit/turn]."""
    tracker_noise: float
    """Standard deviation of each TCP coordinate [m]; 0 if there is no tracker."""
    tracker_period: float
    """Sample time of the tracker [s]; 0 if there is no tracker."""

    @property
    def resolver_step(self) -> float:
        """Smallest change of a motor angle that is measured [rad]."""
        return resolver_step(self.encoder_bits)


@dataclass(frozen=True, kw_only=True, eq=False)
class WorkArea:
    """Work area of the tool."""

    positions: Mapping[str, Array]
    """Named points in the world [m], shape (3,) each."""
    home: Array
    """Joint positions that seed the inverse kinematics, link side [rad], shape (N,)."""
    tool_rotation: Array | None = None
    """Orientation of tool0 in the world, shape (3, 3); None leaves it free."""
    normal: Array = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    """Normal of the plane of the test circles, any length, shape (3,)."""

    def __post_init__(self) -> None:
        check_part("work_area", self, np.size(self.home))
        if self.tool_rotation is not None:
            check_rotation("work_area.tool_rotation", self.tool_rotation)
        if not np.any(self.normal):
            raise FFGymError("work_area.normal must not be zero; leave it out for circles parallel to the ground.")
        object.__setattr__(self, "positions", MappingProxyType(dict(self.positions)))


@dataclass(frozen=True, kw_only=True, eq=False)
class Spring:
    r"""A spring between points of two bodies, e.g. the counterbalance of an arm; it pulls them together.

    .. math:: F(x) = k_1 x + k_2 x^2 + k_3 x^3, \quad x = L - L_0
    """

    name: str
    bodies: tuple[str, str]
    """'base', links or 'tool'."""
    start: Array
    """Point on the first body, in its frame [m], shape (3,)."""
    end: Array
    """Point on the second body, in its frame [m], shape (3,)."""
    length: float
    """Length L_0 without force [m]."""
    stiffness: tuple[float, float, float]
    """k_1 [N/m], k_2 [N/m^2], k_3 [N/m^3]."""


@dataclass(frozen=True, kw_only=True)
class Logs:
    """Content of the machine's own logs, in the words of recordings (docs/recordings.md)."""

    torque: TorqueSemantics = "motor_side"
    """Meaning of logged torque."""
    position: PositionSide = "motor"
    """Side of logged positions and speeds."""

    def __post_init__(self) -> None:
        check_choice("logs.torque", self.torque, get_args(TorqueSemantics))
        check_choice("logs.position", self.position, get_args(PositionSide))


def resolver_step(bits: int) -> float:
    """Compute the smallest change of angle [rad] that a resolver of so many bits a turn tells."""
    return float(2 * np.pi / 2**bits)


def point_mass_inertia(mass: float) -> Array:
    """Inertia of a ball of 10 mm radius that stands for a point mass [kg], which a rigid body is not; shape (6,)."""
    moment = 0.4 * mass * _BALL**2
    return np.array([moment, moment, moment, 0.0, 0.0, 0.0])


def _check_inertia(name: str, inertia: Array) -> None:
    """A rigid body has three positive principal moments, none above the sum of the others (to 1e-6, as printed)."""
    xx, yy, zz, xy, xz, yz = inertia
    moments = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if moments[0] <= 0 or moments[2] > (moments[0] + moments[1]) * (1 + 1e-6):
        raise FFGymError(
            f"{name} = {inertia.tolist()} kg m^2 belongs to no body: principal moments {moments.tolist()} must be > 0, "
            f"and none above the sum of the others."
        )


def _read_only(values: dict[str, Any]) -> MappingProxyType[str, Any]:
    return MappingProxyType(values)


copyreg.pickle(MappingProxyType, lambda mapping: (_read_only, (dict(mapping),)))  # so that descriptions can be copied
