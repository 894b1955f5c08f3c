"""Description of a robot: names, geometry, masses, drives, friction, servo and work area; complete once built."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from ffgym.core.errors import FFGymError, check_choice, check_number
from ffgym.core.types import Array
from ffgym.recordings import Header
from ffgym.recordings.header import Hold
from ffgym.robot.drive import Drive
from ffgym.robot.friction import LuGreParameters
from ffgym.robot.parts import (
    Geom,
    Kinematics,
    Links,
    Logs,
    Sensors,
    Servo,
    Spring,
    Tool,
    WorkArea,
    point_mass_inertia,
)
from ffgym.robot.reading.quantity import Quantity, check_numbers
from ffgym.robot.reading.rules import RULES, check_part


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
    springs: tuple[Spring, ...] = ()
    logs: Logs = field(default_factory=Logs)
    quantities: Mapping[str, Quantity] = field(default_factory=dict)

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
        self._check_numbers()
        # springs must join two bodies that there are
        bodies = ["base", *self.links, *(["tool"] if self.tool is not None else [])]
        for spring in self.springs:
            for body in spring.bodies:
                check_choice(f"body of springs.{spring.name}", body, bodies)
            if spring.bodies[0] == spring.bodies[1]:
                raise FFGymError(f"springs.{spring.name} joins {spring.bodies[0]!r} to itself; it needs two bodies.")
        if len({spring.name for spring in self.springs}) < len(self.springs):
            raise FFGymError(f"Springs {[spring.name for spring in self.springs]} must have different names.")
        self._check_home()
        substeps = self.servo.control_dt / self.physics_dt
        if abs(substeps - round(substeps)) > 1e-9 or substeps < 1:
            raise FFGymError(
                f"servo.control_dt = {self.servo.control_dt} s must be a whole multiple of "
                f"simulation.physics_dt = {self.physics_dt} s."
            )
        steps = self.drive.resolver_period / self.physics_dt
        if abs(steps - round(steps)) > 1e-6:
            raise FFGymError(
                f"drive.resolver_period = {self.drive.resolver_period} s must be a whole multiple of "
                f"simulation.physics_dt = {self.physics_dt} s, or 0 for a servo that knows its exact speed."
            )

    def _check_numbers(self) -> None:
        """Check that all parts are of N joints, and the numbers that no part checks by the rules of files."""
        n = self.n_joints
        counts = {
            "kinematics": len(self.kinematics.axis),
            "links": len(self.bodies.mass),
            "drive": len(self.drive.gear_ratio),
            "friction": self.friction.n_joints,
            "work_area": n if self.work_area is None else len(self.work_area.home),
        }
        for table, count in counts.items():
            if count != n:
                raise FFGymError(f"{table} of robot {self.name!r} is of {count} joints, must be of {n}: {self.joints}.")
        check_part("servo", self.servo, n)
        for path in ("base.mass", "base.com", "simulation.physics_dt", "simulation.gravity"):
            name = path.replace(".", "_").removeprefix("simulation_")
            array = check_numbers(path, getattr(self, name), RULES[path], n)
            if array.ndim:
                object.__setattr__(self, name, array)

    def _check_home(self) -> None:
        """Check that home is a pose within the limits."""
        if self.work_area is None:
            return
        for name, q, (low, high) in zip(self.joints, self.work_area.home, self.kinematics.range, strict=True):
            if not low - 1e-9 <= q <= high + 1e-9:
                raise FFGymError(
                    f"work_area.home of {name} = {q:.6g} is outside its range, [{low:.6g}, {high:.6g}] (rad or m). "
                    f"Give a pose near the work, as the controller shows it."
                )

    @property
    def n_joints(self) -> int:
        """Number of joints N."""
        return len(self.joints)

    @property
    def arm_share(self) -> Array:
        """Share of friction behind the elasticity [1], shape (N,); 0 for rigid joints, which have one side alone."""
        share = self.friction.arm_share
        return np.zeros(self.n_joints) if share is None else np.where(self.drive.is_rigid, 0.0, share)

    def with_arm_share(self, share: ArrayLike | None) -> Self:
        """Return the robot with a share of its friction on the arm [1], one or (N,); None and 0 put all on motors.

        Raises:
            FFGymError: if there are not N shares, or one is not from 0 to 1.
        """
        shares = None if share is None else np.asarray(share, dtype=np.float64)
        if shares is not None and shares.ndim == 0:
            shares = np.full(self.n_joints, shares)
        return replace(self, friction=replace(self.friction, arm_share=shares))

    @property
    def n_substeps(self) -> int:
        """Physics steps in one control step."""
        return round(self.servo.control_dt / self.physics_dt)

    def position(self, name: str) -> Array:
        """Return a point of the work area [m], shape (3,).

        Raises:
            FFGymError: if the robot has no work area or no such point.
        """
        if self.work_area is None:
            raise FFGymError(f"Robot {self.name!r} has no work area; its motions are given in joint space.")
        return self.work_area.positions[check_choice("position", name, list(self.work_area.positions))]


def with_payload(
    robot: RobotDescription, mass: float, offset: Array | None = None, radius: float = 0.0
) -> RobotDescription:
    """Return the robot with a load at its TCP; a point mass is a small ball, if the tool itself weighs nothing.

    Args:
        robot: who carries it.
        mass: [kg].
        offset: centre of mass from the TCP, in the axes of tool0 [m], shape (3,); None is none.
        radius: of gyration about any axis through the centre of mass [m].

    Raises:
        FFGymError: if the robot has no tool, or the mass is negative.
    """
    mass = check_number("payload", mass, unit="kg", low=0.0)
    if robot.tool is None:
        raise FFGymError(f"Robot {robot.name!r} has no tool, so it can carry no payload.")
    tool = robot.tool
    total = tool.mass + mass
    if total == 0:
        return robot
    place = tool.tcp if offset is None else tool.tcp + offset
    own = mass * radius**2 * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    if tool.mass == 0:
        inertia = own if radius > 0 else point_mass_inertia(mass)
        return replace(robot, tool=replace(tool, mass=mass, com=place, inertia=inertia))
    com = (tool.mass * tool.com + mass * place) / total
    inertia = tool.inertia + tool.mass * _about(tool.com - com) + mass * _about(place - com) + own
    return replace(robot, tool=replace(tool, mass=total, com=com, inertia=inertia))


def _about(arm: Array) -> Array:
    """Compute the inertia of a unit point mass at `arm` (3,) [m] about the origin, order xx, yy, zz, xy, xz, yz."""
    x, y, z = arm
    return np.array([y * y + z * z, x * x + z * z, x * x + y * y, -x * y, -x * z, -y * z])


def log_header(robot: RobotDescription, segment: str = "", hold: Hold = "sampled") -> Header:
    """Make a header for a log of the robot: joints, gears, sides of position and torque, tool as payload.

    Args:
        robot: the robot; its table [logs] says on which side of the gearbox positions and torques are logged.
        segment: name of the motion.
        hold: when the torque of a row acts (docs/recordings.md).

    Raises:
        FFGymError: if `hold` is unknown.
    """
    drive, tool = robot.drive, robot.tool
    return Header(
        robot=robot.name,
        joints=robot.joints,
        gear_ratio=tuple(drive.gear_ratio.tolist()),
        coupling=None if drive.coupling is None else drive.coupling.tolist(),
        joint_types=robot.kinematics.types,
        position_side=robot.logs.position,
        torque_semantics=robot.logs.torque,
        hold=hold,
        payload=None if tool is None else {"mass": tool.mass, "com": tool.com.tolist()},
        segment=segment,
    )
