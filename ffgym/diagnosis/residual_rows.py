"""Computation of residuals: rows that count, measured minus predicted, and what each motor was doing there."""

from collections.abc import Iterator, Mapping

import numpy as np
import scipy

from ffgym.core.errors import FFGymError
from ffgym.core.measures import rms
from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.diagnosis.log import Log
from ffgym.diagnosis.replay import Replay
from ffgym.diagnosis.residual import Channel, MotionResidual, Residual, components
from ffgym.diagnosis.settings import settings
from ffgym.robot import RobotDescription


def describes_low_speed(robot: RobotDescription) -> BoolArray:
    """Find joints whose description has a breakaway peak beside Coulomb and viscous friction, shape (N,)."""
    friction = robot.friction
    knows: BoolArray = friction.static > (1 + settings().replay.stribeck_peak) * friction.coulomb
    return knows


def find_predictable_rows(log: Log) -> BoolArray:
    """Find rows that count for the torque of each motor, shape (R, M, N).

    All of them where the description knows low speeds; else those in whose reach of the low-pass the motor never was
    slow: what it takes to hold still, between plus and minus the breakaway torque, is not determined by its motion.
    """
    sampling, robot = log.sampling, log.robot
    # speed of the motor alone, behind the gearbox: what other joints turn it by counts too
    speed = robot.drive.motor_angle(log.dq) / robot.drive.gear_ratio
    slow = np.abs(speed) < settings().replay.low_speed * robot.kinematics.max_speed
    near = scipy.ndimage.maximum_filter1d(slow.astype(np.int8), 2 * sampling.half_length + 1, axis=0)[sampling.at] > 0
    judged: BoolArray = describes_low_speed(robot) | ~near
    return judged


def filter_measured(log: Log) -> dict[Channel, Array]:
    """Filter measured signals to rows (R, M, C); unknown tool positions are 0 there, and not valid."""
    sampling = log.sampling
    found: dict[Channel, Array] = {"torque": sampling(log.torque)}
    if log.tool is not None:
        found["tool"] = sampling(np.nan_to_num(log.tool))
    if log.link is not None:
        found["link"] = sampling(np.nan_to_num(log.link))
    if log.feedback is not None and log.shows_servo:
        found["servo"] = sampling(log.feedback)
    return found


def check_length(log: Log) -> None:
    """Check that there is something to fit to, and something else to judge by."""
    limits = settings().replay
    lasts = float(np.count_nonzero(find_valid_rows(log))) * log.sampling.row_dt
    if lasts < limits.shortest_log:
        raise FFGymError(
            f"The recordings are too short: {lasts:.2g} s are left between the ends that low-pass filters need, must "
            f"be {limits.shortest_log:g} s or more. Record longer motions."
        )


def find_valid_rows(log: Log) -> BoolArray:
    """Find rows that count in all channels, shape (R, M)."""
    known = log.known
    if log.tool is not None:
        known = known & ~np.isnan(log.tool).any(axis=-1)
    return log.sampling.valid(known)


def find_counting_rows(log: Log) -> dict[tuple[Channel, int], BoolArray]:
    """Find rows that count for each component, (R, M) each.

    All valid ones, but those of torque at low speed where the model knows nothing of it, those whose samples the mask
    of a recording leaves out for the joint, and none of an encoder that is not there.
    """
    # rows of torque: predictable ones that no mask leaves out
    valid, judged = find_valid_rows(log), find_predictable_rows(log)
    masks = [recording.valid for recording in log.recordings]
    if not all(mask.all() for mask in masks):
        within = np.ones((log.sampling.n_samples, len(masks), log.robot.n_joints), dtype=np.bool_)
        for i, mask in enumerate(masks):
            within[: len(mask), i] = mask
        unmasked = [log.sampling.valid(within[:, :, j]) for j in range(log.robot.n_joints)]
        judged = judged & np.stack(unmasked, axis=-1)
    found: dict[tuple[Channel, int], BoolArray] = {}
    for channel, rows in filter_measured(log).items():
        for c in range(rows.shape[2]):
            found[channel, c] = valid & judged[..., c] if channel == "torque" else valid
    # encoders that are not there have no rows
    if log.link is not None:
        for c in np.flatnonzero(np.isnan(log.link).any(axis=(0, 1))).tolist():
            found["link", c] = np.zeros_like(valid)
    return found


def compute_component_rms(log: Log, *residuals: Mapping[Channel, Array]) -> Iterator[tuple[Channel, str, list[float]]]:
    """Compute, over rows that count, RMS of the measured signal less its mean, and of residuals by its side.

    Residuals are (R, M, C) by channel, or (M, C) where all rows of a motion have the same. Components without rows that
    count are left out: an encoder that is not there, or a joint that never moves.
    """
    counting, measured = find_counting_rows(log), filter_measured(log)
    for channel in residuals[0]:
        for c, name in enumerate(components(channel, log.robot)):
            rows = counting[channel, c]
            if rows.any():
                left = [rms(np.broadcast_to(rest[channel][..., c], rows.shape)[rows]) for rest in residuals]
                yield channel, name, [float(np.std(measured[channel][..., c][rows])), *left]


def compute_residuals(log: Log, prediction: dict[Channel, Array]) -> dict[Channel, Array]:
    """Compute measured minus predicted (R, M, C).

    The servo's integral and an encoder begin at an unknown value: their means are taken off. An
    error that is written with rounded angles, off by a part of a step, drifts in the integral: so is its slope.
    """
    valid = find_valid_rows(log)
    found = {}
    for channel, rows in filter_measured(log).items():
        rest = rows - prediction[channel]
        if channel == "link" and log.link is not None:
            rest = np.where(np.isnan(log.link).any(axis=(0, 1)), 0.0, rest)
        if channel in ("servo", "link"):
            rest = _detrend(rest, valid, slope=channel == "servo")
        found[channel] = rest
    return found


def _detrend(rows: Array, valid: BoolArray, *, slope: bool) -> Array:
    """Remove the mean, and the slope over time, of valid rows (R, M) of each motion from rows (R, M, C)."""
    weight = valid.astype(np.float64)
    count = np.maximum(weight.sum(axis=0), 1.0)[:, None]
    rest = rows - np.einsum("rmc,rm->mc", rows, weight) / count
    if not slope:
        return rest
    time = np.arange(len(rows), dtype=np.float64)[:, None]
    time = (time - (weight * time).sum(axis=0) / count[:, 0]) * weight
    energy = np.maximum((time**2).sum(axis=0), 1.0)
    straight: Array = rest - time[..., None] * (np.einsum("rmc,rm->mc", rest, time) / energy[:, None])
    return straight


def measure_moves(angle: Array, speed: Array, dt: float) -> tuple[Array, Array]:
    """Measure the travel since the present move began, and how long the motor had stood before it; shapes of the angle.

    A move begins where a motor turns, and where it starts after `DWELL` or more at rest, in either direction. Shorter
    stops are turns, or none.

    Args:
        angle: of motors [rad], shape (T, ...).
        speed: of motors [rad/s], shape (T, ...).
        dt: time from one sample to the next [s].
    """
    # direction of motion, 0 at rest
    limits = settings().patterns
    moving = np.abs(speed) >= limits.rest
    direction = np.sign(np.where(moving, speed, 0.0))
    samples = np.arange(len(angle)).reshape(-1, *[1] * (angle.ndim - 1))
    # the sample in which the motor last moved, before this one; -1 if it did not
    upto = np.maximum.accumulate(np.where(moving, samples, -1), axis=0)
    before: IntArray = np.concatenate([np.full_like(upto[:1], -1), upto[:-1]])
    standing = dt * (samples - 1 - before)
    came = np.where(before < 0, 0.0, np.take_along_axis(direction, np.maximum(before, 0), axis=0))
    # moves begin at turns, and after rests
    rested = standing >= limits.dwell
    begins = moving & (rested | (direction != came))
    began: IntArray = np.maximum.accumulate(np.where(begins, samples, 0), axis=0)
    stood = np.where(begins & rested, standing, 0.0)
    return np.abs(angle - np.take_along_axis(angle, began, axis=0)), np.take_along_axis(stood, began, axis=0)


def assemble_residual(log: Log, run: Replay, rest: Mapping[Channel, Array], floor: Mapping[Channel, Array]) -> Residual:
    """Assemble residuals of all motions with the states of the motors.

    Args:
        log: what was measured.
        run: replay of the machine whose residuals these are.
        rest: measured minus predicted, (R, M, C) by channel, less what calibration errors explain.
        floor: RMS of noise alone, (M, C).
    """
    # signals and states of all motions side by side
    at, valid, measured = log.sampling.at, find_valid_rows(log), filter_measured(log)
    counting = find_counting_rows(log)
    motor = run.robot.drive.motor_angle
    # travel and standstill of the motors at the full rate, before rows are sampled
    travel, stood = measure_moves(motor(run.log.q), motor(run.log.slip_dq), log.dt)
    # cut them into motions, each as long as its recording
    motions = []
    for i, name in enumerate(log.names):
        n = int(np.searchsorted(at, len(log.recordings[i])))
        rows = at[:n]
        motions.append(
            MotionResidual(
                motion=name,
                t=log.t[rows],
                valid=valid[:n, i],
                measured={channel: measured[channel][:n, i] for channel in rest},
                predicted={channel: measured[channel][:n, i] - rest[channel][:n, i] for channel in rest},
                state=run.state.each(lambda values: np.broadcast_to(values, log.q.shape)[rows, i]),  # noqa: B023
                motor_acceleration=run.robot.drive.motor_angle(run.log.ddq[rows, i]),
                since_reversal=travel[rows, i],
                at_rest_for=stood[rows, i],
                judged={
                    channel: np.stack([counting[channel, c][:n, i] for c in range(rest[channel].shape[2])], axis=-1)
                    for channel in rest
                },
            )
        )
    return Residual(
        robot=log.robot,
        motions=tuple(motions),
        floor=dict(floor),
        cutoff=log.sampling.cutoff,
    )
