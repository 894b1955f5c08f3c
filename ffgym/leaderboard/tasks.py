"""Circles that every agent is scored on: those of the thesis, and circles held out from learning; in named splits."""

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass, replace
from functools import lru_cache
from typing import Any
from zlib import crc32

import numpy as np

from ffgym.core.errors import check_choice
from ffgym.leaderboard.motions import CIRCLE, SPIRAL, SQUARE, follow_shape
from ffgym.paths import RADII, SPEEDS, CartesianPath, Reference, cartesian_reference, circle_test
from ffgym.robot import RigidArm, RobotDescription
from ffgym.studies.circles import circle_path

SPLITS = ("train", "positions", "radii", "speeds")
"""Split that agents may learn on, and three held out from learning: other positions, radii, speeds."""
HELD_OUT = SPLITS[1:]
"""Splits held out from learning, but for families that practise the very task."""
THESIS = ("train", "positions")
"""Splits that together are the 36 circles of the thesis."""

TRAIN_POSITION = "p1"
"""Training position of the thesis (5.3.2)."""
NEW_RADII = (0.002, 0.004)
"""Radii between those of the thesis [m]; chosen."""
NEW_SPEEDS = (0.020, 0.070)
"""TCP speeds between those of the thesis [m/s]; chosen."""


@dataclass(frozen=True)
class Task:
    """One motion: circles of some radii, one after the other, or another shape, at one position and one speed."""

    position: str
    speed: float
    """Speed of the TCP [m/s]."""
    radii: tuple[float, ...]
    """Radii of the circles [m]; one size of another shape, see `follow_shape`."""
    split: str
    centre: tuple[float, float, float] | None = field(default=None, repr=False)
    """Centre of the circles in the world [m] where it is no position of the work area; None is `position`."""
    kind: str = field(default=CIRCLE, repr=False)
    """Kind of the motion, in KINDS; those other than circles in the plane of the work area have a centre."""
    normal: tuple[float, float, float] | None = field(default=None, repr=False)
    """Normal of the plane of a tilted circle; None is that of the work area."""

    @property
    def place(self) -> str | tuple[float, float, float]:
        """Position as an environment takes it: its name, or the centre."""
        return self.position if self.centre is None else self.centre


def list_tasks(splits: Sequence[str], positions: Sequence[str]) -> list[Task]:
    """List the motions of splits, in the order of SPLITS; `positions` are those of the robot's work area."""
    check_choice("position", TRAIN_POSITION, positions)
    for split in splits:
        check_choice("split", split, SPLITS)
    others = [position for position in positions if position != TRAIN_POSITION]
    every = {
        "train": [Task(TRAIN_POSITION, speed, RADII, "train") for speed in SPEEDS],
        "positions": [Task(position, speed, RADII, "positions") for speed in SPEEDS for position in others],
        "radii": [Task(TRAIN_POSITION, speed, NEW_RADII, "radii") for speed in SPEEDS],
        "speeds": [Task(TRAIN_POSITION, speed, RADII, "speeds") for speed in NEW_SPEEDS],
    }
    return [task for split in SPLITS if split in splits for task in every[split]]


def noise_seed(task: Task, seed: int) -> list[int]:
    """Return the seed of the sensors' noise in a task, the same whatever runs beside it."""
    return [seed, crc32(repr(task).encode())]


def make_references(arm: RigidArm, tasks: Sequence[Task]) -> list[Reference]:
    """Make the references of tasks; those of one arm are made once."""
    return [_reference(arm, task) for task in tasks]


def duration_of(arm: RigidArm, task: Task) -> float:
    """Return the duration of the motion of a task [s]; that of circles without solving for joint angles."""
    if task.kind in (SQUARE, SPIRAL):
        return _reference(arm, task).duration
    return float(_path(arm.robot, task).t[-1])


@lru_cache(maxsize=64)
def _reference(arm: RigidArm, task: Task) -> Reference:
    if task.kind in (SQUARE, SPIRAL):
        assert task.centre is not None  # such motions are drawn about a point
        return follow_shape(arm, task.kind, task.centre, task.radii[0], task.speed, task.position)
    found = _follow(_Mover.of(arm), task)
    return found if found.robot is arm.robot else replace(found, robot=arm.robot)


@lru_cache(maxsize=64)
def _follow(mover: "_Mover", task: Task) -> Reference:
    """Solve the inverse kinematics of circles once for arms that differ in friction, drives and masses alone."""
    return cartesian_reference(mover.arm, _path(mover.arm.robot, task))


@dataclass(frozen=True)
class _Mover:
    """An arm that follows paths; two are the same if they take the same joint angles along every path."""

    key: Hashable
    """All that decides on these angles: kinematics, limits, tool, work area, sample time."""
    arm: RigidArm = field(compare=False)

    @classmethod
    def of(cls, arm: RigidArm) -> "_Mover":
        """Collect what decides on the joint angles of an arm."""
        robot = arm.robot
        parts = (robot.kinematics, robot.tool, robot.work_area, robot.servo.control_dt)
        return cls(tuple(_as_key(part) for part in parts), arm)


def _as_key(value: Any) -> Hashable:
    """Return the numbers of a part of a robot in a form that can be compared."""
    if isinstance(value, np.ndarray):
        return value.shape, value.tobytes()
    if isinstance(value, Mapping):
        return tuple((name, _as_key(each)) for name, each in value.items())
    if is_dataclass(value):
        return tuple(_as_key(getattr(value, f.name)) for f in fields(value))
    known: Hashable = value
    return known


def _path(robot: RobotDescription, task: Task) -> CartesianPath:
    if task.centre is None:
        return circle_path(robot, task.position, task.speed, task.radii)
    assert robot.work_area is not None  # robots of the leaderboard have one
    normal, dt = task.normal or robot.work_area.normal, robot.servo.control_dt
    return circle_test(task.centre, task.speed, radii=task.radii, normal=normal, dt=dt, name=task.position)
