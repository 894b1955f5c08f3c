"""Where joints, axes and masses of an arm are, from kinematics and masses alone."""

from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.stats import qmc

from ffgym.core.types import Array
from ffgym.robot import ModelOptions, RobotDescription, compile_model

_BARE = ModelOptions(flexible=False, friction=False, servo=False, looks=False)
"""Links on joints, and nothing else."""
POSES = 4096
"""Poses that stand for all: enough that the worst gravity torque of a six-axis arm is found to some percent."""


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
    """Of the bodies [kg], shape (B,)."""
    principal_axes: Array
    """Orientation of the principal axes of inertia, columns, shape (B, 3, 3)."""
    half_axes: Array
    """Of the ellipsoids of uniform density with the bodies' masses and inertias [m], shape (B, 3)."""


def skeleton(robot: RobotDescription, q: Array) -> Skeleton:
    """The arm at joint positions `q` (N,), link side."""
    model = compile_model(robot, _BARE)
    data = mujoco.MjData(model)
    data.qpos[:] = q
    mujoco.mj_kinematics(model, data)
    has_heavy_tool = robot.tool is not None and robot.tool.mass > 0
    bodies = (*robot.links, *(["tool"] if has_heavy_tool else []))
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
    """TCP, or the origin of the last link without a tool, at joint positions `q` (T, N); [m], shape (T, 3)."""
    model = compile_model(robot, _BARE)
    data = mujoco.MjData(model)
    points = np.empty((len(q), 3))
    for row, pose in zip(points, q, strict=True):
        data.qpos[:] = pose
        mujoco.mj_kinematics(model, data)
        row[:] = _tip(model, data)
    return points


def poses_in_range(robot: RobotDescription, count: int = POSES) -> Array:
    """Joint positions spread evenly over the ranges, the same at every call, shape (count, N).

    A hinge that can turn further takes one whole turn, which shows all that gravity and geometry can do.
    """
    low, high = robot.kinematics.range.T
    turn = np.where(robot.kinematics.is_sliding, np.inf, 2 * np.pi)
    spread = qmc.Halton(robot.n_joints, scramble=False).random(count)
    return low + spread * np.minimum(high - low, turn)


def _tip(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    site = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, "tcp")
    point = data.xpos[-1] if site < 0 else data.site_xpos[site]
    return np.array(point)
