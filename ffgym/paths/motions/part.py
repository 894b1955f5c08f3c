"""One part of a motion file: a kind, entries with meaning and unit, and what they mean for a robot."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, Field, dataclass, field, fields
from pathlib import Path
from typing import Any, ClassVar, Self

import numpy as np
import scipy

from ffgym.core.errors import FFGymError, check_choice, check_number, check_shape
from ffgym.core.types import Array
from ffgym.paths.moves import Move, check_position
from ffgym.robot import RigidArm, RobotDescription

FIRST = "work_area"
"""Name of the first point of the robot's work area, whatever it is called."""
OF_RANGE = "one for all joints, a list, a table by joint, or '10 %' of each joint's range"
"""Valid positions or amplitudes of joints, for the documentation of entries."""
OF_SPEED = "one for all joints, a list, a table by joint, or '10 %' of each joint's largest speed"
"""Valid speeds of joints."""
UPRIGHT = np.array([0.0, 0.0, 1.0])
"""Normal of planes for a robot without a work area."""
LARGEST = 1e6
"""Largest value for a joint, in SI units; beyond it one surely is in another unit."""
UNIT_NORM = 1e-3
"""Largest deviation from 1 of the norm of a quaternion that is taken for rounding."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PartContext:
    """The robot that a motion is made for, and where its points are counted from."""

    arm: RigidArm
    origin: Array
    """Point that coordinates are counted from, in the world [m], shape (3,)."""
    where: str
    """The part in its file, for messages."""
    folder: Path = Path()
    """Folder of files that a part names."""

    @property
    def robot(self) -> RobotDescription:
        """The robot."""
        return self.arm.robot

    def point(self, name: str, value: Any) -> Array:
        """Point in the world [m], shape (3,): coordinates from the origin, or the name of a point of the work area."""
        if isinstance(value, str):
            return find_point(self.robot, value)
        return self.origin + check_position(name, value)

    def normal(self, value: Any) -> Array:
        """Normal of a plane, shape (3,): as given, or that of the work area; upright for a robot without one."""
        if value is not None:
            return check_shape("normal", value, (3,))
        return UPRIGHT if self.robot.work_area is None else self.robot.work_area.normal

    def joints(self, name: str, value: Any, whole: Array, others: Array | float = 0.0) -> Array:
        """Values for the joints, shape (N,), see `joint_values`."""
        return joint_values(self.robot, name, value, whole, others)

    @property
    def span(self) -> Array:
        """Width of the joints' ranges, link side [rad or m], shape (N,)."""
        return np.diff(self.robot.kinematics.range, axis=1)[:, 0]

    @property
    def rest(self) -> Array:
        """Joint positions (N,) at which a robot begins that has not moved before."""
        return resting_position(self.robot)


def resting_position(robot: RobotDescription) -> Array:
    """Home of a robot's work area, or joint positions as near to zero as they can be, shape (N,)."""
    if robot.work_area is not None:
        return robot.work_area.home
    return np.clip(np.zeros(robot.n_joints), *robot.kinematics.range.T)


def find_point(robot: RobotDescription, name: str) -> Array:
    """Find a point of the robot's work area in the world [m], shape (3,)."""
    points = {} if robot.work_area is None else robot.work_area.positions
    if not points:
        raise FFGymError(
            f"Robot {robot.name!r} has no named points in its work area, so {name!r} is none. Use numbers, or give it "
            f"one: [work_area.positions.{'p1' if name == FIRST else name}] in its description."
        )
    return points[next(iter(points)) if name == FIRST else check_choice("point", name, [*points, FIRST])]


def joint_values(robot: RobotDescription, name: str, value: Any, whole: Array, others: Array | float = 0.0) -> Array:
    """Values for the joints (N,): one for all, a list of N, a table by joint, or a share of `whole` such as '10 %'.

    Joints that a table leaves out have the value `others`; `name` is that of the entry, for messages.
    """
    if isinstance(value, str):
        try:
            share = float(value.removesuffix("%")) if value.strip().endswith("%") else None
        except ValueError:
            share = None
        if share is None:
            raise FFGymError(f"{name} = {value!r} must be numbers, or a share such as '10 %'.")
        return check_number(name, share, unit="%", low=-LARGEST, high=LARGEST) / 100 * whole
    if isinstance(value, dict):
        result = np.array(np.broadcast_to(others, whole.shape), dtype=np.float64)
        for joint, number in value.items():
            index = robot.joints.index(check_choice(f"joint in {name}:", joint, robot.joints))
            result[index] = joint_values(robot, f"{name}.{joint}", number, whole, others)[index]
        return result
    if isinstance(value, list):
        values = check_shape(f"{name} (one entry for each of {', '.join(robot.joints)})", value, whole.shape)
    else:
        values = np.full(whole.shape, check_number(name, value))
    if np.abs(values).max() > LARGEST:
        raise FFGymError(f"{name} = {value} is beyond {LARGEST:g}; is it in another unit?")
    return values


def rotation_of(rpy_deg: Any, quaternion: Any) -> Array | None:
    """Orientation (3, 3) from roll, pitch, yaw about the world's x, y, z [deg], or from a quaternion w, x, y, z."""
    if rpy_deg is not None and quaternion is not None:
        raise FFGymError("rpy_deg and quaternion say the same; give one of them.")
    if rpy_deg is not None:
        return scipy.spatial.transform.Rotation.from_euler(
            "xyz", check_shape("rpy_deg", rpy_deg, (3,)), degrees=True
        ).as_matrix()
    if quaternion is None:
        return None
    values = check_shape("quaternion", quaternion, (4,))
    if abs(np.linalg.norm(values) - 1) > UNIT_NORM:
        raise FFGymError(
            f"quaternion = {values.tolist()} (w, x, y, z) must have norm 1, not {np.linalg.norm(values):.6g}."
        )
    return scipy.spatial.transform.Rotation.from_quat(values, scalar_first=True).as_matrix()


def entry(meaning: str, unit: str = "", **options: Any) -> Any:
    """Field of a part, with what the documentation says about it; `default` makes it optional."""
    return field(metadata={"meaning": meaning, "unit": unit}, **options)


@dataclass(frozen=True, kw_only=True, eq=False)
class MotionPart(ABC):
    """A part of a motion, as it stands in a file."""

    kind: ClassVar[str]
    """Name in a motion file."""

    label: str = entry("name of the part, for phases and messages", default="")

    @abstractmethod
    def moves(self, place: PartContext) -> Sequence[Move]:
        """Moves that carry out the part with a robot."""

    @classmethod
    def parse(cls, table: Mapping[str, Any]) -> Self:
        """Part with the entries of a table."""
        known = {f.name: f for f in entries(cls)}
        unknown = sorted(set(table) - set(known))
        if unknown:
            raise FFGymError(f"Unknown entries {', '.join(unknown)}. A {cls.kind} has {', '.join(known)}.")
        missing = [name for name, f in known.items() if is_required(f) and name not in table]
        if missing:
            raise FFGymError(f"Missing entries: {', '.join(missing)}. A {cls.kind} needs them.")
        if not isinstance(table.get("label", ""), str):
            raise FFGymError(f"label = {table['label']!r} must be text.")
        return cls(**table)


def entries(part: type[MotionPart]) -> tuple[Field[Any], ...]:
    """Entries of a kind of part, those that are required first."""
    return tuple(sorted(fields(part), key=lambda f: not is_required(f)))


def is_required(f: Field[Any]) -> bool:
    """Tell if a file must give the entry."""
    return f.default is MISSING and f.default_factory is MISSING
