"""Columns of recordings side by side and without holes, and the reference that a controller tracked."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy

from ffgym.core.errors import FFGymError
from ffgym.core.measures import interpolate
from ffgym.core.types import Array
from ffgym.diagnosis.settings import settings
from ffgym.logs.preparation import convert_to_motor_side, read_joint_side, read_motor_side, read_motor_torque
from ffgym.paths import Reference
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription


def pad(arrays: Sequence[Array], n: int, hold: bool) -> Array:
    """Arrays (T_i, ...) side by side, shape (T, M, ...); after its end a motion holds its last row, or is 0."""
    found = []
    for array in arrays:
        width = ((0, n - len(array)), *((0, 0) for _ in array.shape[1:]))
        found.append(np.pad(array, width, mode="edge") if hold else np.pad(array, width))
    return np.stack(found, axis=1)


def read_tool(recording: Recording) -> Array:
    """Tracked position (T, 3), straight between samples that lie close together; else NaN."""
    position, t = recording.vector("tcp.position"), recording.t
    seen = np.flatnonzero(~np.isnan(position).any(axis=1))
    if len(seen) < 2:
        return np.full_like(position, np.nan)
    between = interpolate(t, t[seen], position[seen])
    after = np.minimum(np.searchsorted(seen, np.arange(len(t))), len(seen) - 1)
    before = np.maximum(np.where(seen[after] == np.arange(len(t)), after, after - 1), 0)
    gap = seen[after] - seen[before]
    outside = (np.arange(len(t)) < seen[0]) | (np.arange(len(t)) > seen[-1])
    between[(gap > settings().sampling.tracker_gap * np.median(np.diff(seen))) | outside] = np.nan
    return between


def read_temperatures(recording: Recording) -> Array:
    """Temperatures (T, N), straight between samples, held at either end."""
    columns = recording.joint_array("temperature").copy()
    for j in range(columns.shape[1]):
        seen = ~np.isnan(columns[:, j])
        columns[:, j] = np.interp(recording.t, recording.t[seen], columns[seen, j]) if seen.any() else np.nan
    return columns


def read_feedback(robot: RobotDescription, recordings: Sequence[Recording], n: int) -> Array | None:
    """Feedback torque as recorded, or as what the motor torque has beside its feed-forward; None if neither is."""
    found = []
    for recording in recordings:
        of = "feedback.effort" if recording.has("feedback.effort") else "feedforward.effort"
        if not recording.has(of):
            return None
        torque = recording.joint_array(of)
        if of == "feedforward.effort" and recording.has("compensation.effort"):
            torque = torque + recording.joint_array("compensation.effort")
        torque = convert_to_motor_side(robot.drive, recording.header, torque)
        found.append(torque if of == "feedback.effort" else read_motor_torque(robot, recording) - torque)
    return pad(found, n, hold=True)


def read_set_points(robot: RobotDescription, recordings: Sequence[Recording], n: int) -> tuple[Array, Array] | None:
    """Set-points of the motors and their rate, motor side."""
    if not all(recording.has("reference.position") for recording in recordings):
        return None
    positions, rates = [], []
    for recording in recordings:
        positions.append(read_motor_side(robot, recording, "reference.position"))
        if recording.has("reference.velocity"):
            rates.append(read_motor_side(robot, recording, "reference.velocity"))
        else:
            rates.append(np.gradient(positions[-1], recording.dt, axis=0))
    return pad(positions, n, hold=True), pad(rates, n, hold=False)


_FEWEST = 4
"""Set-points that a smooth curve takes."""


def build_reference(robot: RobotDescription, recording: Recording) -> Reference:
    """Set-points of a recording at the control step, from 0 s on, without phases; they are smooth in between.

    Raises:
        FFGymError: if the recording has no set-points, or the robot cannot make the motion.
    """
    if not recording.has("reference.position"):
        raise FFGymError(
            f"Recording {recording.header.segment!r} has no reference.position, so it cannot be run again."
        )
    dt = robot.servo.control_dt
    q = read_joint_side(robot, recording, "reference.position")
    since = recording.t - recording.t[0]
    t = dt * np.arange(int(np.floor(since[-1] / dt + 1e-6)) + 1, dtype=np.float64)
    curve = scipy.interpolate.CubicSpline(since, q)
    return Reference(
        name=recording.header.segment, robot=robot, t=t, q=curve(t), dq=curve(t, 1), ddq=curve(t, 2), phases=()
    )


def widen_limits(robot: RobotDescription, recordings: Sequence[Recording]) -> RobotDescription:
    """The robot with ranges and speeds that hold all set-points: what a machine has done, it can do.

    The same robot, if they do.
    """
    low, high, fast = _reach(robot, recordings)
    kinematics = robot.kinematics
    margin = settings().sampling.range_margin * (high - low)
    beyond = (low < kinematics.range[:, 0]) | (high > kinematics.range[:, 1])
    ends = np.minimum(low - margin, kinematics.range[:, 0]), np.maximum(high + margin, kinematics.range[:, 1])
    speed = np.where(fast > kinematics.max_speed, (1 + settings().sampling.range_margin) * fast, kinematics.max_speed)
    if not beyond.any() and np.array_equal(speed, kinematics.max_speed):
        return robot
    limits = np.where(beyond[:, None], np.stack(ends, axis=1), kinematics.range)
    return replace(robot, kinematics=replace(kinematics, range=limits, max_speed=speed))


def report_beyond_limits(robot: RobotDescription, recordings: Sequence[Recording]) -> tuple[str, ...]:
    """Set-points that lie beyond the range of their joint or its speed, in words; empty if none do."""
    low, high, fast = _reach(robot, recordings)
    kinematics, found = robot.kinematics, []
    for j, joint in enumerate(robot.joints):
        unit, (least, most) = kinematics.units[j], kinematics.range[j]
        # position at both ends of the range, then speed
        for value, is_out in ((low[j], low[j] < least), (high[j], high[j] > most)):
            if is_out:
                found.append(
                    f"reference.position.{joint} goes to {value:.6g} {unit}, must be within {least:.6g} to {most:.6g} "
                    f"{unit}. The diagnosis goes on as if the joint had room; look at kinematics.range."
                )
        if fast[j] > kinematics.max_speed[j]:
            found.append(
                f"reference.position.{joint} moves at {fast[j]:.6g} {unit}/s, must stay below "
                f"{kinematics.max_speed[j]:.6g} {unit}/s. The diagnosis goes on; look at kinematics.max_speed."
            )
    return tuple(found)


def _reach(robot: RobotDescription, recordings: Sequence[Recording]) -> tuple[Array, Array, Array]:
    """Lowest and highest set-point of each joint, and their highest speed, (N,) each, as they are run again."""
    low, high, fast = np.full(robot.n_joints, np.inf), np.full(robot.n_joints, -np.inf), np.zeros(robot.n_joints)
    for recording in recordings:
        if recording.has("reference.position"):
            q = read_joint_side(robot, recording, "reference.position")
            known = np.isfinite(q).all(axis=1)
            if np.count_nonzero(known) < _FEWEST:
                continue
            q, curve = q[known], scipy.interpolate.CubicSpline(recording.t[known], q[known])
            low, high = np.minimum(low, q.min(axis=0)), np.maximum(high, q.max(axis=0))
            fast = np.maximum(fast, np.abs(curve(curve.x, 1)).max(axis=0))
    return low, high, fast
