"""Check of the direction in which gravity acts: how the robot is mounted, as its torques say."""

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache

import numpy as np

from ffgym.core.types import Array
from ffgym.logs.quality.check import Check, NotJudgedError, Seen
from ffgym.logs.quality.log import Log
from ffgym.logs.quality.model import model_of, rms
from ffgym.robot import RigidArm, RobotDescription

_SEEN = 0.2
"""Share of the best seen component of gravity below which another one is not seen: small motions turn no link."""

_ROWS = 300
"""Rows that are compared."""


def _direction(log: Log) -> Iterator[Seen]:
    model = model_of(log)
    heavy = [j for j in model.joints if rms(model.gravity[:, j]) > 0.3 * rms(model.measured[:, j])]
    if not heavy or not np.any(model.robot.gravity):
        raise NotJudgedError("gravity is no large part of any torque")
    few = slice(0, None, max(1, len(log.t) // _ROWS))
    weight = 1 / np.array([rms(model.measured[:, j]) for j in heavy])
    q, rest = model.q[few], (model.measured - model.motion - model.friction)[few]
    rest = rest - model.robot.drive.motor_torque(log.arm.spring_torque(q))
    size = float(np.linalg.norm(model.robot.gravity))
    torques = [model.robot.drive.motor_torque(arm.gravity_torque(q)) for arm in _pulled_along_axes(model.robot)]
    columns = np.stack([(torque[:, heavy] * weight).ravel() for torque in torques], axis=1)
    angle = _angle(columns, (rest[:, heavy] * weight).ravel(), model.robot.gravity / size)
    message = (
        f"motor.effort: gravity acts {angle:.0f} deg away from where the description of {model.robot.name} has it, "
        "must be within 45 deg. Give simulation.gravity as the robot is mounted (upside down, at a wall), or look at "
        "the signs."
    )
    yield Seen(value=angle, message=message, columns=tuple(f"motor.effort.{log.joints[j]}" for j in heavy))


@lru_cache(maxsize=1)
def _pulled_along_axes(robot: RobotDescription) -> tuple[RigidArm, ...]:
    """The robot in gravity as strong as its own, along each axis of the world; kept for the next log."""
    size = float(np.linalg.norm(robot.gravity))
    return tuple(RigidArm(replace(robot, gravity=size * axis)) for axis in np.eye(3))


def _angle(columns: Array, torque: Array, expected: Array) -> float:
    """Angle [deg] between the gravity that explains `torque` (R,) by `columns` (R, 3), and the expected one (3,).

    Both are taken in the directions that the torques tell apart.
    """
    u, s, vt = np.linalg.svd(columns, full_matrices=False)
    seen = s > _SEEN * s[0]
    measured = (u[:, seen].T @ torque) / s[seen]
    expected = vt[seen] @ expected
    size = max(float(np.linalg.norm(measured) * np.linalg.norm(expected)), np.finfo(np.float64).tiny)
    return float(np.degrees(np.arccos(np.clip(measured @ expected / size, -1, 1))))


GRAVITY = (
    Check(
        name="gravity_direction",
        figure="Angle between measured and described gravity",
        unit="deg",
        flag=45.0,
        refuse=90.0,
        why="friction and payloads that are not described turn it by up to 25 deg, a wall by 90, a ceiling by 180",
        judge=_direction,
    ),
)
"""Checks of the mounting."""
