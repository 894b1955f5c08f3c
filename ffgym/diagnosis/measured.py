"""What was measured along a log, channel by channel, at the rows where residuals are taken."""

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.log import Log
from ffgym.diagnosis.low_speed import judged_rows
from ffgym.diagnosis.residual import Channel

LEAST = 2.0
"""Time [s] that all motions together must last: a block of a second to fit to, and another to judge by."""


def measured_rows(log: Log) -> dict[Channel, Array]:
    """Measured signals (R, M, C) through the log's low-pass; unknown tool positions are 0 there, and not valid."""
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
    """Check that there is something to fit to, and something else to judge by.

    Raises:
        FFGymError: if all motions together are too short.
    """
    lasts = float(np.count_nonzero(valid_rows(log))) * log.sampling.row_dt
    if lasts < LEAST:
        raise FFGymError(
            f"The recordings are too short: without the ends, which low-passes take, {lasts:.2g} s are left in which "
            f"all is known, must be {LEAST:g} s at least."
        )


def valid_rows(log: Log) -> BoolArray:
    """Rows that count in all channels, shape (R, M)."""
    known = log.known
    if log.tool is not None:
        known = known & ~np.isnan(log.tool).any(axis=-1)
    return log.sampling.valid(known)


def counting_rows(log: Log) -> dict[tuple[Channel, int], BoolArray]:
    """Rows that count for each component, (R, M) each.

    All valid ones, but those of torque at low speed where the model knows nothing of it, those whose samples the mask
    of a recording leaves out for the joint, and none of an encoder that is not there.
    """
    valid, judged = valid_rows(log), judged_rows(log) & _unmasked(log)
    found: dict[tuple[Channel, int], BoolArray] = {}
    for channel, rows in measured_rows(log).items():
        for c in range(rows.shape[2]):
            found[channel, c] = valid & judged[..., c] if channel == "torque" else valid
    if log.link is not None:
        for c in np.flatnonzero(np.isnan(log.link).any(axis=(0, 1))).tolist():
            found["link", c] = np.zeros_like(valid)
    return found


def _unmasked(log: Log) -> BoolArray:
    """Rows none of whose samples is left out for a joint, shape (R, M, N)."""
    masks = [recording.valid for recording in log.recordings]
    if all(mask.all() for mask in masks):
        return np.ones((len(log.sampling.at), len(masks), log.robot.n_joints), dtype=np.bool_)
    within = np.ones((log.sampling.n_samples, len(masks), log.robot.n_joints), dtype=np.bool_)
    for i, mask in enumerate(masks):
        within[: len(mask), i] = mask
    return np.stack([log.sampling.valid(within[:, :, j]) for j in range(log.robot.n_joints)], axis=-1)


def residual_rows(log: Log, prediction: dict[Channel, Array]) -> dict[Channel, Array]:
    """Measured minus predicted (R, M, C).

    The servo's integral begins where nobody knows, and an encoder counts from where nobody knows: their means are taken
    off. An error that is written with rounded angles, off by a part of a step, drifts in the integral: so is its slope.
    """
    valid = valid_rows(log)
    found = {}
    for channel, rows in measured_rows(log).items():
        rest = rows - prediction[channel]
        if channel == "link" and log.link is not None:
            rest = np.where(np.isnan(log.link).any(axis=(0, 1)), 0.0, rest)
        if channel in ("servo", "link"):
            rest = _without_trend(rest, valid, slope=channel == "servo")
        found[channel] = rest
    return found


def _without_trend(rows: Array, valid: BoolArray, *, slope: bool) -> Array:
    """Rows (R, M, C) without the mean, and the slope over time, of valid rows (R, M) of each motion."""
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
