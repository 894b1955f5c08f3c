"""What the description of the robot says of a recording: the torque of its rigid arm, part by part."""

from dataclasses import dataclass
from functools import lru_cache
from typing import final

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.logs.quality.check import NotJudgedError
from ffgym.logs.quality.log import Log, averaged
from ffgym.robot import RobotDescription

_ROWS = 2500
"""Rows at which the arm is computed: planned motion lies far below their rate, and more would only cost time."""


_ENOUGH = 50
"""Rows in motion that a joint needs to be judged."""


@final
@dataclass(frozen=True, eq=False)
class Model:
    """Motor torques of the description for the recorded motion, motor side [N m], (T, N) each."""

    robot: RobotDescription
    q: Array
    """Joint positions that they are for, link side, averaged."""
    gravity: Array
    """Of links and springs, at rest."""
    motion: Array
    """Of links and rotors in motion."""
    friction: Array
    """At steady speed."""
    measured: Array
    """Recorded torque, motor side, averaged as the motion is."""
    counted: BoolArray
    """Rows and joints that count: the joint moves, and slides."""

    @property
    def joints(self) -> list[int]:
        """Joints that move long enough to be judged, by number."""
        return [int(j) for j in np.flatnonzero(self.counted.sum(axis=0) >= _ENOUGH)]

    @property
    def total(self) -> Array:
        """Sum of all parts."""
        return self.gravity + self.motion + self.friction


@lru_cache(maxsize=4)
def model_of(log: Log) -> Model:
    """The description's torque beside the recorded one.

    Raises:
        NotJudgedError: if robot, motion or torque are not known.
    """
    q, dq, ddq, robot = log.smooth_q, log.dq, log.ddq, log.robot
    if robot is None or q is None or dq is None or ddq is None or robot.n_joints != len(log.joints):
        raise NotJudgedError("it needs the robot and positions")
    few = np.unique(np.linspace(0, len(log.t) - 1, min(len(log.t), _ROWS)).astype(np.int64))
    arm, drive = log.arm, robot.drive

    def everywhere(values: Array) -> Array:
        return np.stack([np.interp(log.t, log.t[few], column) for column in values.T], axis=1)

    links = drive.motor_torque(arm.inverse_dynamics(q[few], dq[few], ddq[few]))
    return Model(
        robot=robot,
        q=q,
        gravity=everywhere(drive.motor_torque(arm.holding_torque(q[few]))),
        motion=everywhere(links + drive.rotor_inertia * drive.motor_angle(ddq[few])),
        friction=robot.friction.steady_torque(drive.motor_angle(dq)),
        measured=_measured(log, robot),
        counted=log.moving,
    )


def _measured(log: Log, robot: RobotDescription) -> Array:
    """Recorded motor torque [N m], averaged as accelerations are, (T, N)."""
    semantics = log.recording.header.torque_semantics
    if not log.recording.has("motor.effort") or semantics == "unspecified":
        raise NotJudgedError("it needs motor.effort, and torque_semantics in the header")
    torque = log.recording.joint_array("motor.effort")
    if semantics == "link_side":
        torque = robot.drive.motor_torque(torque)
    return averaged(averaged(torque, log.rows(log.smoothing)), log.rows(log.smoothing))


def rms(values: Array) -> float:
    """Root mean square of all `values`, no less than the smallest number, so that shares of it are finite."""
    return max(float(np.sqrt(np.mean(values**2))), np.finfo(np.float64).tiny)
