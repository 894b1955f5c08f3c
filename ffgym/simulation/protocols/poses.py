"""Poses near the rest position that load the motors differently."""

import numpy as np
from scipy.stats import qmc

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.simulation.protocols.limits import LARGE_TORQUE
from ffgym.simulation.protocols.stage import Stage

NEARBY = 0.15
"""How far poses are from the rest position, as a share of each joint's range to either side; chosen: the arm stays in
the part of its space where its home is. Nothing here knows what stands around the robot."""

_CANDIDATES = 512
"""Poses examined; chosen: in six dimensions more of them widen the spread of loads by a few percent only."""

LEAST_SPREAD = 0.01
"""Spread of a motor's load over nearby poses, as a share of peak torque, below which gravity does not load it."""


def nearby_poses(stage: Stage, way: Array) -> Array:
    """Poses spread evenly around the rest position, which comes first, shape (P, N).

    Every joint can go `way` (N,) to either side, the tool is near where it rests, and the drives hold the arm with at
    most half of their torque.

    Raises:
        FFGymError: if the drives cannot do so even in the rest position.
    """
    robot = stage.robot
    about = stage.about(stage.rest, way)
    unit = qmc.Halton(d=robot.n_joints, scramble=False).random(_CANDIDATES)
    low, high = robot.kinematics.range.T
    around = np.clip(about + (2 * unit - 1) * NEARBY * stage.span, low + way, high - way)
    poses = np.vstack([about, around])
    light = np.all(np.abs(_loads(stage, poses)) <= LARGE_TORQUE, axis=1)
    if not light[0]:
        raise FFGymError(
            f"holding the arm in its rest position takes more than {LARGE_TORQUE:.0%} of a drive's torque."
        )
    return poses[light & stage.keeps_tool_near(poses)]


def load_ladder(stage: Stage, joint: int, count: int, way: Array) -> Array:
    """Up to `count` poses in which one motor carries evenly spread loads, shape (P, N).

    A motor that gravity cannot load gets one.
    """
    poses = nearby_poses(stage, way)
    load = _loads(stage, poses)[:, joint]
    if count == 1 or np.ptp(load) < LEAST_SPREAD:
        return poses[:1]
    wanted = np.linspace(load.min(), load.max(), count)
    nearest = np.abs(load - wanted[:, None]).argmin(axis=1)
    chosen: Array = poses[list(dict.fromkeys(nearest.tolist()))]
    return chosen


def spread_poses(stage: Stage, count: int, way: Array) -> Array:
    """Up to `count` poses as far from each other as can be, in loads of all motors and positions; shape (P, N).

    Each one is, of the candidates, the farthest from those chosen before.
    """
    poses = nearby_poses(stage, way)
    features = np.hstack([_in_spans(_loads(stage, poses)), _in_spans(poses)])
    chosen = [0]
    while len(chosen) < min(count, len(poses)):
        away = np.linalg.norm(features[:, None] - features[chosen], axis=2).min(axis=1)
        chosen.append(int(away.argmax()))
    return poses[chosen]


def _loads(stage: Stage, poses: Array) -> Array:
    """Torque of each motor that holds the arm, as a share of its peak torque, shape (P, N)."""
    drive = stage.robot.drive
    load: Array = drive.motor_torque(stage.arm.holding_torque(poses)) / drive.peak_torque
    return load


def _in_spans(values: Array) -> Array:
    """Columns in units of their spread; those without spread are zero."""
    spread = np.ptp(values, axis=0)
    return np.divide(values, spread, out=np.zeros_like(values), where=spread > 1e-9 * np.abs(values).max())
