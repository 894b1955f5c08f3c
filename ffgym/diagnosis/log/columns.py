"""What recordings have of each kind of column, side by side and without holes."""

from collections.abc import Sequence

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.identification.signals import motor_effort
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription

_GAP = 5
"""Sample periods of the tracker over which its position is interpolated; chosen: a lost sample or some."""


def padded(arrays: Sequence[Array], n: int, hold: bool) -> Array:
    """Arrays (T_i, ...) side by side, shape (T, M, ...); after its end a motion holds its last row, or is 0."""

    def one(array: Array) -> Array:
        width = ((0, n - len(array)), *((0, 0) for _ in array.shape[1:]))
        return np.pad(array, width, mode="edge") if hold else np.pad(array, width)

    return np.stack([one(array) for array in arrays], axis=1)


def tracked(recording: Recording) -> Array:
    """Tracked position (T, 3), straight between samples that lie close together; else NaN."""
    position, t = recording.vector("tcp.position"), recording.t
    seen = np.flatnonzero(~np.isnan(position).any(axis=1))
    if len(seen) < 2:
        return np.full_like(position, np.nan)
    between = np.stack([np.interp(t, t[seen], position[seen, k]) for k in range(3)], axis=1)
    after = np.minimum(np.searchsorted(seen, np.arange(len(t))), len(seen) - 1)
    before = np.maximum(np.where(seen[after] == np.arange(len(t)), after, after - 1), 0)
    gap = seen[after] - seen[before]
    outside = (np.arange(len(t)) < seen[0]) | (np.arange(len(t)) > seen[-1])
    between[(gap > _GAP * np.median(np.diff(seen))) | outside] = np.nan
    return between


def temperature(recording: Recording) -> Array:
    """Temperatures (T, N), straight between samples, held at either end."""
    columns = recording.joint_array("temperature").copy()
    for j in range(columns.shape[1]):
        seen = ~np.isnan(columns[:, j])
        columns[:, j] = np.interp(recording.t, recording.t[seen], columns[seen, j]) if seen.any() else np.nan
    return columns


def feedback(robot: RobotDescription, recordings: Sequence[Recording], n: int) -> Array | None:
    """Feedback torque as recorded, or as what the motor torque has beside its feed-forward; None if neither is."""
    found = []
    for recording in recordings:
        side = robot.drive.motor_torque if recording.header.torque_semantics == "link_side" else None
        if recording.has("feedback.effort"):
            torque = recording.joint_array("feedback.effort")
            found.append(torque if side is None else side(torque))
        elif recording.has("feedforward.effort"):
            added = recording.joint_array("feedforward.effort")
            if recording.has("compensation.effort"):
                added = added + recording.joint_array("compensation.effort")
            found.append(motor_effort(robot, recording) - (added if side is None else side(added)))
        else:
            return None
    return padded(found, n, hold=True)


def reference(robot: RobotDescription, recordings: Sequence[Recording], n: int) -> tuple[Array, Array] | None:
    """Set-points of the motors and their rate, motor side."""
    if not all(recording.has("reference.position") for recording in recordings):
        return None
    positions, rates = [], []
    for recording in recordings:
        link = recording.header.position_side == "link"
        position = recording.joint_array("reference.position")
        positions.append(robot.drive.motor_angle(position) if link else position)
        if recording.has("reference.velocity"):
            rate = recording.joint_array("reference.velocity")
            rates.append(robot.drive.motor_angle(rate) if link else rate)
        else:
            rates.append(np.gradient(positions[-1], recording.dt, axis=0))
    return padded(positions, n, hold=True), padded(rates, n, hold=False)
