"""Checks of the recorded torque against the description: unit, joint, mounting, saturation, and whether it fits."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import scipy

from ffgym.core.measures import interpolate, rms
from ffgym.core.types import Array, BoolArray
from ffgym.logs.preparation import convert_to_motor_side
from ffgym.logs.quality.check import Seen, check
from ffgym.logs.quality.log import CheckedLog, NotJudgedError
from ffgym.logs.quality.signals import TINY, average
from ffgym.robot import RigidArm, RobotDescription

_MODEL_ROWS = 2500
"""Rows at which the arm is computed: planned motion lies far below their rate, and more would only cost time."""

_ENOUGH = 50
"""Rows in motion that a joint needs to be judged."""

_MISFIT = 0.35
"""Share of its torque that a joint's own description leaves from which on another joint is looked for."""

_SEEN = 0.2
"""Share of the best seen component of gravity below which another one is not seen: small motions turn no link."""

_GRAVITY_ROWS = 300
"""Rows at which directions of gravity are compared."""


@dataclass(frozen=True, eq=False)
class Model:
    """Motor torques of the description for the recorded motion, motor side [N m], (T, N) each."""

    robot: RobotDescription
    q: Array
    """Joint positions that they are for, link side, averaged."""
    gravity: Array
    """Torque of links and springs, at rest."""
    motion: Array
    """Torque of links and rotors in motion."""
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
def model_of(log: CheckedLog) -> Model:
    """The description's torque beside the recorded one."""
    q, dq, ddq, robot = log.smooth_q, log.dq, log.ddq, log.robot
    if robot is None or not log.has_positions or not log.is_described:
        raise NotJudgedError("it needs the robot and positions")
    few = np.unique(np.linspace(0, len(log.t) - 1, min(len(log.t), _MODEL_ROWS)).astype(np.int64))
    arm, drive = log.arm, robot.drive

    def everywhere(values: Array) -> Array:
        return interpolate(log.t, log.t[few], values)

    links = drive.motor_torque(arm.inverse_dynamics(q[few], dq[few], ddq[few]))
    return Model(
        robot=robot,
        q=q,
        gravity=everywhere(drive.motor_torque(arm.holding_torque(q[few]))),
        motion=everywhere(links + drive.rotor_inertia * drive.motor_angle(ddq[few])),
        friction=robot.friction.steady_torque(drive.motor_angle(dq)),
        measured=average(average(_measure(log, robot), log.rows(log.smoothing)), log.rows(log.smoothing)),
        counted=log.moving,
    )


def _measure(log: CheckedLog, robot: RobotDescription) -> Array:
    """Recorded motor torque [N m], (T, N)."""
    header = log.recording.header
    if not log.recording.has("motor.effort") or header.torque_semantics == "unspecified":
        raise NotJudgedError("it needs motor.effort, and torque_semantics in the header")
    return convert_to_motor_side(robot.drive, header, log.recording.joint_array("motor.effort"))


def _size(values: Array) -> float:
    """Root mean square of all `values`, no less than the smallest number, so that shares of it are finite."""
    return max(rms(values), TINY)


@check
def _torque_units(log: CheckedLog) -> Iterator[Seen]:
    model = model_of(log)
    for j in model.joints:
        rows = model.counted[:, j]
        factor = _size(model.measured[rows, j]) / max(_size(model.total[rows, j]), TINY)
        size = abs(np.log(max(factor, 1e-300)))
        ratio = abs(log.recording.header.gear_ratio[j])
        known = {"N m for mN m": 1e-3, "mN m for N m": 1e3, "the link side for the motor side": ratio}
        known["the motor side for the link side"] = 1 / ratio
        text = min(known, key=lambda name: abs(np.log(max(factor, 1e-300) / known[name])))
        words = {"factor": factor, "text": text, "known": known[text]}
        yield Seen(size, (f"motor.effort.{log.joints[j]}",), log.joints[j], words)


@check
def _torque_permutation(log: CheckedLog) -> Iterator[Seen]:
    model = model_of(log)
    joints = model.joints
    if len(joints) < 2:
        raise NotJudgedError("fewer than two joints move")
    cost = np.array([[_left(model, i, j) for j in joints] for i in joints])
    chosen = scipy.optimize.linear_sum_assignment(cost)[1].tolist()
    own = np.diag(cost)
    gains = np.where(own > np.log(_MISFIT), own - cost[np.arange(len(own)), chosen], 0.0)
    for row, column in enumerate(chosen):
        exchanged = [row]  # joints that have changed places with it: the one that it is like, and so on
        while chosen[exchanged[-1]] != row:
            exchanged.append(chosen[exchanged[-1]])
        gain = float(gains[exchanged].min())  # all of them have changed places, or none
        one, other = (log.joints[joints[k]] for k in (row, column))
        words = {"times": np.exp(gain), "other": other}
        yield Seen(gain, (f"motor.effort.{one}", f"motor.effort.{other}"), one, words)


def _left(model: Model, i: int, j: int) -> float:
    """Log of the share of the torque of joint `i` that the description of joint `j` leaves."""
    rows = model.counted[:, i] | model.counted[:, j]
    u, p = model.measured[rows, i], model.total[rows, j]
    return float(np.log(max(_size(u - p) / max(_size(u), 1e-300), 1e-3)))


@check
def _torque_model(log: CheckedLog) -> Iterator[Seen]:
    model, shares = model_of(log), {}
    for j in model.joints:
        rows = model.counted[:, j]
        shares[j] = _size(model.measured[rows, j] - model.total[rows, j]) / max(_size(model.measured[rows, j]), 1e-300)
    if not shares:
        raise NotJudgedError("no joint moves long enough")
    yield Seen(float(np.median([*shares.values()])), tuple(f"motor.effort.{log.joints[j]}" for j in shares))


@check
def _saturation(log: CheckedLog) -> Iterator[Seen]:
    semantics = log.recording.header.torque_semantics
    if log.robot is None or not log.recording.has("motor.effort") or not log.is_described:
        raise NotJudgedError("it needs the robot and motor.effort")
    if semantics == "unspecified":
        raise NotJudgedError("torque_semantics of the header is unspecified")
    if log.robot.quantities and "drive.peak_torque" not in log.robot.quantities:
        raise NotJudgedError("the description does not say drive.peak_torque")
    torque = _measure(log, log.robot)
    for j, peak in enumerate(log.robot.drive.peak_torque):
        value = float(np.mean(np.abs(torque[:, j]) > 0.98 * peak))
        yield Seen(value, (f"motor.effort.{log.joints[j]}",), log.joints[j], {"peak": peak})


@check
def _gravity_direction(log: CheckedLog) -> Iterator[Seen]:
    model = model_of(log)
    heavy = [j for j in model.joints if _size(model.gravity[:, j]) > 0.3 * _size(model.measured[:, j])]
    if not heavy or not np.any(model.robot.gravity):
        raise NotJudgedError("gravity is no large part of any torque")
    few = slice(0, None, max(1, len(log.t) // _GRAVITY_ROWS))
    weight = 1 / np.array([_size(model.measured[:, j]) for j in heavy])
    q, rest = model.q[few], (model.measured - model.motion - model.friction)[few]
    rest = rest - model.robot.drive.motor_torque(log.arm.spring_torque(q))
    size = float(np.linalg.norm(model.robot.gravity))
    torques = [model.robot.drive.motor_torque(arm.gravity_torque(q)) for arm in _pulled_along_axes(model.robot)]
    columns = np.stack([(torque[:, heavy] * weight).ravel() for torque in torques], axis=1)
    # gravity that explains the torques, and the expected one, in the directions that the torques tell apart
    u, s, vt = np.linalg.svd(columns, full_matrices=False)
    seen = s > _SEEN * s[0]
    measured = (u[:, seen].T @ (rest[:, heavy] * weight).ravel()) / s[seen]
    expected = vt[seen] @ (model.robot.gravity / size)
    both = max(float(np.linalg.norm(measured) * np.linalg.norm(expected)), TINY)
    angle = float(np.degrees(np.arccos(np.clip(measured @ expected / both, -1, 1))))
    yield Seen(angle, tuple(f"motor.effort.{log.joints[j]}" for j in heavy))


@lru_cache(maxsize=1)
def _pulled_along_axes(robot: RobotDescription) -> tuple[RigidArm, ...]:
    """The robot in gravity as strong as its own, along each axis of the world; kept for the next log."""
    size = float(np.linalg.norm(robot.gravity))
    return tuple(RigidArm(replace(robot, gravity=size * axis)) for axis in np.eye(3))
