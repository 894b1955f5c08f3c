"""Geometry of an arm: skeleton, reach, and the positions of the work area."""

from dataclasses import dataclass

import mujoco
import numpy as np
import scipy

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.robot import ModelOptions, RigidArm, RobotDescription, compile_model, solve_pose

_BARE = ModelOptions(flexible=False, friction=False, servo=False, looks=False)
"""Options of a model of links and joints alone."""
POSES = 4096
"""Number of poses that sample the ranges: the worst gravity torque of a six-axis arm is found to some percent."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Skeleton:
    """An arm in one pose, in the world."""

    joints: Array
    """A point on each joint's axis [m], shape (N, 3)."""
    axes: Array
    """Unit axes, shape (N, 3)."""
    tip: Array
    """TCP [m], shape (3,); the origin of the last link, if there is no tool."""
    bodies: tuple[str, ...]
    """Links, and the tool if it weighs something."""
    com: Array
    """Centres of mass of the bodies [m], shape (B, 3)."""
    mass: Array
    """Masses of the bodies [kg], shape (B,)."""
    principal_axes: Array
    """Orientation of the principal axes of inertia, columns, shape (B, 3, 3)."""
    half_axes: Array
    """Half axes of ellipsoids of uniform density with the bodies' masses and inertias [m], shape (B, 3)."""


def skeleton(robot: RobotDescription, q: Array) -> Skeleton:
    """Compute the skeleton at joint positions `q` (N,), link side."""
    model = compile_model(robot, _BARE)
    data = mujoco.MjData(model)
    data.qpos[:] = q
    mujoco.mj_kinematics(model, data)
    bodies = (*robot.links, "tool") if robot.tool is not None and robot.tool.mass > 0 else robot.links
    ids = [model.body(name).id for name in bodies]
    mass, inertia = model.body_mass[ids], model.body_inertia[ids]
    squares = 2.5 * (inertia.sum(axis=1, keepdims=True) - 2 * inertia) / mass[:, None]
    return Skeleton(
        joints=data.xanchor.copy(),
        axes=data.xaxis.copy(),
        tip=_tip(model, data),
        bodies=bodies,
        com=data.xipos[ids],
        mass=mass,
        principal_axes=data.ximat[ids].reshape(-1, 3, 3),
        half_axes=np.sqrt(np.maximum(squares, 0.0)),
    )


def tips(robot: RobotDescription, q: Array) -> Array:
    """Compute the TCP, or without a tool the origin of the last link, at positions `q` (T, N); [m], shape (T, 3)."""
    model = compile_model(robot, _BARE)
    data = mujoco.MjData(model)
    points = np.empty((len(q), 3))
    for row, pose in zip(points, q, strict=True):
        data.qpos[:] = pose
        mujoco.mj_kinematics(model, data)
        row[:] = _tip(model, data)
    return points


def poses_in_range(robot: RobotDescription, count: int = POSES) -> Array:
    """Spread joint positions evenly over the ranges, the same at every call, shape (count, N).

    A hinge that can turn further takes one whole turn, which covers all loads of gravity and all geometry.
    """
    low, high = robot.kinematics.range.T
    turn = np.where(robot.kinematics.is_sliding, np.inf, 2 * np.pi)
    spread = scipy.stats.qmc.Halton(robot.n_joints, scramble=False).random(count)
    return low + spread * np.minimum(high - low, turn)


@dataclass(frozen=True, kw_only=True, eq=False)
class Reach:
    """Reach of the tip (TCP, or origin of the last link) over poses spread over the joint ranges, in the world."""

    distance: float
    """Largest distance from the first joint [m]."""
    low: Array
    """Corner of the box around all points [m], shape (3,)."""
    high: Array
    """Corner of the box around all points [m], shape (3,)."""
    points: Array
    """All points [m], shape (T, 3)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CheckedPose:
    """A pose at which loads and resonances are computed."""

    name: str
    q: Array | None
    """Joint positions, link side, shape (N,); None if the place cannot be reached."""
    condition: float | None = None
    """Condition number of the Jacobian of the TCP there; None without a tool."""
    problem: str = ""
    """Reason why it cannot be reached."""


def compute_reach(robot: RobotDescription) -> Reach:
    """Compute the reach of a robot; needs kinematics only."""
    poses = poses_in_range(robot)
    points, first = tips(robot, poses), skeleton(robot, poses[0]).joints[0]
    return Reach(
        distance=float(np.linalg.norm(points - first, axis=1).max()),
        low=points.min(axis=0),
        high=points.max(axis=0),
        points=points,
    )


def solve_poses(robot: RobotDescription) -> list[CheckedPose]:
    """Solve the positions of the work area; without one, return the rest pose."""
    area = robot.work_area
    if area is None or not area.positions or robot.tool is None:
        return [rest_place(robot)]
    arm, places = RigidArm(robot), []
    for name, point in area.positions.items():
        try:
            q = solve_pose(arm, point, area.tool_rotation, area.home)
            places.append(CheckedPose(name=name, q=q, condition=_condition(arm, q)))
        except FFGymError as error:
            places.append(CheckedPose(name=name, q=None, problem=str(error)))
    return places


def rest_place(robot: RobotDescription) -> CheckedPose:
    """Return home of the work area, or the joint positions nearest to 0 within the ranges."""
    q = rest_position(robot)
    nearest = "q nearest to 0" if np.any(q) else "q = 0"
    name = nearest if robot.work_area is None else "home"
    return CheckedPose(name=name, q=q, condition=None if robot.tool is None else _condition(RigidArm(robot), q))


def rest_position(robot: RobotDescription) -> Array:
    """Return joint positions of home, or those nearest to 0 within the ranges, shape (N,)."""
    area = robot.work_area
    return np.clip(0.0, *robot.kinematics.range.T) if area is None else area.home


def _condition(arm: RigidArm, q: Array) -> float:
    return float(np.linalg.cond(arm.jacobian(q[None]))[0])


def _tip(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    site = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, "tcp")
    point = data.xpos[-1] if site < 0 else data.site_xpos[site]
    return np.array(point)
