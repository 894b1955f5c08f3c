"""What a robot is: names, geometry, masses, drives, friction, servo and work area, read from one TOML file."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from types import MappingProxyType
from typing import Any

import numpy as np

from ffgym.errors import FFGymError, check_choice
from ffgym.friction import LuGreParameters
from ffgym.robot.quantity import Quantity
from ffgym.types import Array, BoolArray


@dataclass(frozen=True, kw_only=True, eq=False)
class Kinematics:
    """Serial chain of hinges; at q = 0 all link frames are parallel to the world."""

    position: Array
    """Origin of each joint in the previous link frame [m], shape (N, 3)."""
    axis: Array
    """Unit axis of each joint in its link frame, shape (N, 3)."""
    range: Array
    """Lower and upper joint limit, link side [rad], shape (N, 2)."""
    max_speed: Array
    """Joint speed limit, link side [rad/s], shape (N,)."""

    def __post_init__(self) -> None:
        if np.any(np.abs(np.hypot.reduce(self.axis, axis=1) - 1) > 1e-6):
            raise FFGymError(f"kinematics.axis = {self.axis.tolist()} must be unit vectors.")
        if np.any(self.range[:, 0] >= self.range[:, 1]):
            raise FFGymError(f"kinematics.range = {self.range.tolist()} rad must be lower before upper limit.")


@dataclass(frozen=True, kw_only=True, eq=False)
class Links:
    """Rigid bodies that the joints move."""

    mass: Array
    """[kg], shape (N,)."""
    com: Array
    """Centre of mass in the link frame [m], shape (N, 3)."""
    inertia: Array
    """About the centre of mass [kg m^2], order xx, yy, zz, xy, xz, yz, shape (N, 6)."""

    def __post_init__(self) -> None:
        for i, inertia in enumerate(self.inertia):
            _check_inertia(f"links.inertia[{i}]", inertia)


@dataclass(frozen=True, kw_only=True, eq=False)
class Tool:
    """What hangs on the flange, given in the tool0 frame."""

    rotation: Array
    """Orientation of tool0 in the last link frame, shape (3, 3)."""
    mass: float
    """[kg]."""
    com: Array
    """Centre of mass [m], shape (3,)."""
    inertia: Array
    """About the centre of mass [kg m^2], order xx, yy, zz, xy, xz, yz, shape (6,)."""
    tcp: Array
    """Tool centre point [m], shape (3,)."""

    def __post_init__(self) -> None:
        _check_inertia("tool.inertia", self.inertia)


@dataclass(frozen=True, kw_only=True, eq=False)
class Drive:
    """Motor, gearbox and the elasticity behind it, one entry per joint."""

    gear_ratio: Array
    """Motor turns per joint turn n, shape (N,)."""
    rotor_inertia: Array
    """Motor and gear input inertia J_m, motor side [kg m^2], shape (N,)."""
    joint_stiffness: Array
    """Elasticity between gearbox and arm K, link side [N m/rad], shape (N,); inf is a rigid joint."""
    joint_damping: Array
    """Damping of that elasticity d, link side [N m s/rad], shape (N,)."""
    peak_torque: Array
    """Largest torque the drive gives, motor side [N m], shape (N,)."""

    @property
    def is_rigid(self) -> BoolArray:
        """True for joints without elasticity, shape (N,)."""
        return np.isinf(self.joint_stiffness)


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
    """What the machine and the laser tracker can see."""

    encoder_bits: int
    """Resolution of the motor position [bit/turn]."""
    tracker_noise: float
    """Standard deviation of each TCP coordinate [m]; 0 if there is no tracker."""
    tracker_period: float
    """Sample time of the tracker [s]; 0 if there is no tracker."""


@dataclass(frozen=True, kw_only=True, eq=False)
class WorkArea:
    """Where the tool works."""

    positions: Mapping[str, Array]
    """Named points in the world [m], shape (3,) each."""
    tool_rotation: Array
    """Orientation of tool0 in the world, shape (3, 3)."""
    home: Array
    """Joint angles that seed the inverse kinematics, link side [rad], shape (N,)."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "positions", MappingProxyType(dict(self.positions)))

    def __reduce__(self) -> Any:
        return _rebuilt, (type(self), _plain(self))


@dataclass(frozen=True, kw_only=True)
class Geom:
    """One primitive of the robot's looks."""

    body: str
    type: str
    size: tuple[float, ...]
    pos: tuple[float, float, float]
    end: tuple[float, float, float] | None
    colour: tuple[float, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class RobotDescription:
    """A serial robot, complete once built. All numbers SI; `quantities` keeps the origin of each."""

    name: str
    title: str
    joints: tuple[str, ...]
    links: tuple[str, ...]
    kinematics: Kinematics
    base_mass: float
    base_com: Array
    bodies: Links
    tool: Tool | None
    drive: Drive
    friction: LuGreParameters
    servo: Servo
    sensors: Sensors
    physics_dt: float
    gravity: Array
    work_area: WorkArea | None
    geoms: tuple[Geom, ...] = ()
    quantities: Mapping[str, Quantity] = field(default_factory=dict)

    def __reduce__(self) -> Any:
        return _rebuilt, (type(self), _plain(self))

    def __post_init__(self) -> None:
        object.__setattr__(self, "quantities", MappingProxyType(dict(self.quantities)))
        if len(set(self.joints)) != len(self.joints) or len(set(self.links)) != len(self.links):
            raise FFGymError(f"Joint names {self.joints} and link names {self.links} must be unique.")
        if len(self.joints) != len(self.links) or not self.joints:
            raise FFGymError(
                f"{len(self.joints)} joints and {len(self.links)} links: a serial arm has one link a joint."
            )
        bodies = ["world", "base", "tool", *self.links, *(f"{link}_rotor" for link in self.links)]
        if len(set(bodies)) != len(bodies):
            raise FFGymError(f"Link names {self.links} clash with the bodies world, base, tool or <link>_rotor.")
        substeps = self.servo.control_dt / self.physics_dt
        if abs(substeps - round(substeps)) > 1e-9 or substeps < 1:
            raise FFGymError(
                f"servo.control_dt = {self.servo.control_dt} s must be a whole multiple of "
                f"simulation.physics_dt = {self.physics_dt} s."
            )

    @property
    def n_joints(self) -> int:
        """Number of joints N."""
        return len(self.joints)

    @property
    def n_substeps(self) -> int:
        """Physics steps in one control step."""
        return round(self.servo.control_dt / self.physics_dt)

    def position(self, name: str) -> Array:
        """Point of the work area [m], shape (3,).

        Raises:
            FFGymError: if the robot has no work area or no such point.
        """
        if self.work_area is None:
            raise FFGymError(f"Robot {self.name!r} has no work area; its motions are given in joint space.")
        return self.work_area.positions[check_choice("position", name, list(self.work_area.positions))]


def _check_inertia(name: str, inertia: Array) -> None:
    """A rigid body has three positive principal moments, none above the sum of the others (to 1e-6, as printed)."""
    xx, yy, zz, xy, xz, yz = inertia
    moments = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if moments[0] <= 0 or moments[2] > (moments[0] + moments[1]) * (1 + 1e-6):
        raise FFGymError(
            f"{name} = {inertia.tolist()} kg m^2 belongs to no body: principal moments {moments.tolist()} must be > 0, "
            f"and none above the sum of the others."
        )


def _plain(description: Any) -> dict[str, Any]:
    """Fields of a description in a form that can be copied and pickled, which read-only mappings cannot."""
    values = {f.name: getattr(description, f.name) for f in fields(description)}
    return {name: dict(value) if isinstance(value, Mapping) else value for name, value in values.items()}


def _rebuilt(kind: type, values: dict[str, Any]) -> Any:
    return kind(**values)
