"""Where a robot can go: reach, and the positions of its work area."""

from dataclasses import dataclass

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.robot import RigidArm, RobotDescription, solve_pose
from ffgym.studies.robot_check.draft import poses_in_range, skeleton, tips


@dataclass(frozen=True, kw_only=True, eq=False)
class Reach:
    """Where the tip comes (TCP, or origin of the last link) over poses spread over the joint ranges, in the world."""

    distance: float
    """Largest distance from the first joint [m]."""
    low: Array
    """Corner of the box around all points [m], shape (3,)."""
    high: Array
    """Corner of the box around all points [m], shape (3,)."""
    points: Array
    """All points [m], shape (T, 3)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Place:
    """A pose that loads and resonances are told for."""

    name: str
    q: Array | None
    """Joint positions, link side, shape (N,); None if the place cannot be reached."""
    condition: float | None = None
    """Condition number of the Jacobian of the TCP there; None without a tool."""
    problem: str = ""
    """Why it cannot be reached."""


def reach_of(robot: RobotDescription) -> Reach:
    """Reach of a robot; needs kinematics only."""
    poses = poses_in_range(robot)
    points = tips(robot, poses)
    first = skeleton(robot, poses[0]).joints[0]
    return Reach(
        distance=float(np.linalg.norm(points - first, axis=1).max()),
        low=points.min(axis=0),
        high=points.max(axis=0),
        points=points,
    )


def places_of(robot: RobotDescription) -> list[Place]:
    """Positions of the work area, or else the pose with every joint as near to 0 as it can be."""
    area = robot.work_area
    if area is None or not area.positions or robot.tool is None:
        return [rest_place(robot)]
    arm = RigidArm(robot)
    return [_place(arm, name, point) for name, point in area.positions.items()]


def rest_place(robot: RobotDescription) -> Place:
    """Home of the work area, or the joint positions nearest to 0 within the ranges."""
    area = robot.work_area
    q = np.clip(0.0, *robot.kinematics.range.T) if area is None else area.home
    nearest = "q nearest to 0" if np.any(q) else "q = 0"
    name = nearest if area is None else "home"
    condition = None if robot.tool is None else float(np.linalg.cond(RigidArm(robot).jacobian(q[None]))[0])
    return Place(name=name, q=q, condition=condition)


def _place(arm: RigidArm, name: str, point: Array) -> Place:
    area = arm.robot.work_area
    assert area is not None
    try:
        q = solve_pose(arm, point, area.tool_rotation, area.home)
    except FFGymError as error:
        return Place(name=name, q=None, problem=str(error))
    return Place(name=name, q=q, condition=float(np.linalg.cond(arm.jacobian(q[None]))[0]))
