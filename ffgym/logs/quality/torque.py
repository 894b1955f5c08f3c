"""Checks of the recorded torque against the description of the robot: unit, joint, mounting, and whether it fits."""

from collections.abc import Iterator

import numpy as np
from scipy.optimize import linear_sum_assignment

from ffgym.logs.quality.check import Check, NotJudgedError, Seen
from ffgym.logs.quality.log import Log
from ffgym.logs.quality.model import Model, model_of, rms

_FACTOR = 8.0
"""Factor between recorded and predicted torque from which on a unit or a side is wrong: a payload that is not in the
description made 7.7 on a wrist."""


def _units(log: Log) -> Iterator[Seen]:
    model = model_of(log)
    for j in model.joints:
        rows = model.counted[:, j]
        factor = rms(model.measured[rows, j]) / max(rms(model.total[rows, j]), np.finfo(np.float64).tiny)
        ratio = abs(log.recording.header.gear_ratio[j])
        known = {"N m for mN m": 1e-3, "mN m for N m": 1e3, "the link side for the motor side": ratio}
        known["the motor side for the link side"] = 1 / ratio
        text = min(known, key=lambda name: abs(np.log(max(factor, 1e-300) / known[name])))
        name = f"motor.effort.{log.joints[j]}"
        message = (
            f"{name} is {factor:.4g} times what the description of {model.robot.name} needs, must be within a factor "
            f"of {_FACTOR:g}; nearest is {text} ({known[text]:.4g}). Convert it, or correct torque_semantics."
        )
        yield Seen(value=abs(np.log(max(factor, 1e-300))), message=message, columns=(name,), joint=log.joints[j])


def _permutation(log: Log) -> Iterator[Seen]:
    model = model_of(log)
    joints = model.joints
    if len(joints) < 2:
        raise NotJudgedError("fewer than two joints move")
    cost = np.array([[_left(model, i, j) for j in joints] for i in joints])
    chosen = linear_sum_assignment(cost)[1].tolist()
    own = np.diag(cost)
    gains = np.where(own > np.log(_MISFIT), own - cost[np.arange(len(own)), chosen], 0.0)
    for row, column in enumerate(chosen):
        gain = float(gains[_exchanged(chosen, row)].min())  # all of them have changed places, or none
        name, other = (f"motor.effort.{log.joints[joints[k]]}" for k in (row, column))
        message = (
            f"{name} is explained {np.exp(gain):.3g} times as well by the motion of joint {log.joints[joints[column]]} "
            "as by that of its own, must be less than 2. Give the columns the names of their joints."
        )
        yield Seen(value=gain, message=message, columns=(name, other), joint=log.joints[joints[row]])


def _exchanged(chosen: list[int], row: int) -> list[int]:
    """Rows that have changed places with `row`: it, the row it is like, the row that one is like, and so on."""
    found = [row]
    while chosen[found[-1]] != row:
        found.append(chosen[found[-1]])
    return found


_MISFIT = 0.35
"""Share of its torque that a joint's own description leaves from which on another joint is looked for."""


def _left(model: Model, i: int, j: int) -> float:
    """Log of the share of the torque of joint `i` that the description of joint `j` leaves."""
    rows = model.counted[:, i] | model.counted[:, j]
    u, p = model.measured[rows, i], model.total[rows, j]
    return float(np.log(max(rms(u - p) / max(rms(u), 1e-300), 1e-3)))


def _misfit(log: Log) -> Iterator[Seen]:
    model = model_of(log)
    shares = {}
    for j in model.joints:
        rows = model.counted[:, j]
        shares[j] = rms(model.measured[rows, j] - model.total[rows, j]) / max(rms(model.measured[rows, j]), 1e-300)
    if not shares:
        raise NotJudgedError("no joint moves long enough")
    value = float(np.median(list(shares.values())))
    message = (
        f"motor.effort: the description of {model.robot.name} leaves {value:.0%} of the torque of a typical joint, "
        "must leave less than 60 %. Look for another robot, payload, mounting or run, or wrong signs and units."
    )
    yield Seen(value=value, message=message, columns=tuple(f"motor.effort.{log.joints[j]}" for j in shares))


def _saturation(log: Log) -> Iterator[Seen]:
    semantics = log.recording.header.torque_semantics
    if log.robot is None or not log.recording.has("motor.effort") or log.robot.n_joints != len(log.joints):
        raise NotJudgedError("it needs the robot and motor.effort")
    if semantics == "unspecified":
        raise NotJudgedError("torque_semantics of the header is unspecified")
    if log.robot.quantities and "drive.peak_torque" not in log.robot.quantities:
        raise NotJudgedError("the description does not say drive.peak_torque")
    torque = log.recording.joint_array("motor.effort")
    if semantics == "link_side":
        torque = log.robot.drive.motor_torque(torque)
    for j, peak in enumerate(log.robot.drive.peak_torque):
        value = float(np.mean(np.abs(torque[:, j]) > 0.98 * peak))
        name = f"motor.effort.{log.joints[j]}"
        message = (
            f"{name} is within 2 % of the peak torque of {peak:.4g} N m, or beyond, in {value:.1%} of all rows, must "
            "be in less than 0.5 %. Move more gently: a saturated motor follows no model."
        )
        yield Seen(value=value, message=message, columns=(name,), joint=log.joints[j])


TORQUE = (
    Check(
        name="torque_units",
        figure="Recorded over predicted torque, as |ln|",
        unit="1",
        flag=float(np.log(_FACTOR)),
        refuse=float(np.log(_FACTOR)),
        why="a payload that is not described makes 8 on a wrist; a unit or a side makes 50 and more",
        judge=_units,
    ),
    Check(
        name="torque_permutation",
        figure="How much better another joint's motion explains a torque, as ln",
        unit="1",
        flag=float(np.log(2.0)),
        refuse=float(np.log(2.0)),
        why="judged where own descriptions leave more than 35 %, as assignment of all torques to all joints; a payload "
        "that is not described makes one torque like another, but not that one like the first",
        judge=_permutation,
    ),
    Check(
        name="torque_model",
        figure="Share of the torque that the description leaves, median of the joints",
        unit="1",
        flag=0.6,
        why="recorded robots and their descriptions leave 0.06 to 0.3, without payload 0.6; two robots leave more",
        judge=_misfit,
    ),
    Check(
        name="saturation",
        figure="Share of rows at the peak torque",
        unit="1",
        flag=0.005,
        refuse=0.2,
        why="what a motor could not give does not show in its torque",
        judge=_saturation,
    ),
)
"""Checks of the torque that need the robot."""
