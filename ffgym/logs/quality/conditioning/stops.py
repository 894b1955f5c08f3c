"""The robot's own stops, which no model of its motion has: brakes, and whatever ended the run."""

import numpy as np

from ffgym.core.types import Array
from ffgym.logs.quality.conditioning.notes import amended
from ffgym.logs.quality.log import RESTING, Log
from ffgym.logs.quality.signals import stretches
from ffgym.recordings import Recording

_WINDOW = 0.02
"""Time [s] over which a change of speed counts; two rows of 100 Hz, long beside quantisation, and as long as brakes
take."""

_BRAKING = 0.2
"""Time [s] before a rest in which a stop brakes: drives stop within that from full speed."""

_REST = 0.25
"""Time [s] for which all joints rest after a stop, at least."""

_HARDER = 1.5
"""How much harder than anything else in the log a stop brakes."""

_SLOW = 0.05
"""Largest sample period [s] at which braking is seen."""


def without_stops(recording: Recording) -> Recording:
    """The log with a mask over abrupt stops of all joints, and over the rest that follows them."""
    log = Log(recording)
    if not log.excited.any() or log.dt > _SLOW:
        return recording
    masked = np.zeros(recording.valid.shape, dtype=np.bool_)
    notes = []
    for rows in abrupt_stops(log):
        if recording.valid[rows].any():
            masked[rows] = True
            notes.append(
                f"All joints stop abruptly at {recording.t[rows.start]:.4g} s: the stop, and the rest to "
                f"{recording.t[rows.stop - 1]:.4g} s, were left out."
            )
    return amended(recording, {}, masked, *notes) if notes else recording


def abrupt_stops(log: Log) -> list[slice]:
    """Rows from where an abrupt stop begins to brake to the end of the rest after it."""
    braking = _speed_changes(log.q[:, log.excited], log.rows(_WINDOW))
    speed = np.abs(log.dq[:, log.excited])
    resting = np.all(speed <= RESTING * speed.max(axis=0), axis=1)
    ahead = log.rows(_BRAKING)
    rests = [rows for rows in stretches(resting, log.rows(_REST)) if rows.start > ahead]
    if not rests:
        return []
    elsewhere = ~resting
    for rows in rests:
        elsewhere[max(0, rows.start - 2 * ahead) : rows.start + ahead] = False
    if elsewhere.sum() < log.rows(1.0):
        return []
    most = braking[elsewhere].max(axis=0)
    found = []
    for rows in rests:
        hard = np.any(braking[rows.start - ahead : rows.start + ahead] > _HARDER * most, axis=1)
        if hard.any():
            begin = rows.start - ahead + int(np.argmax(hard)) - log.rows(_WINDOW)
            found.append(slice(max(0, begin), rows.stop))
    return found


def _speed_changes(q: Array, width: int) -> Array:
    """Change of the mean speed from `width` rows before to as many after each row, in positions, (T, N)."""
    changes = np.zeros_like(q)
    if len(q) > 2 * width:
        changes[width:-width] = np.abs(q[2 * width :] - 2 * q[width:-width] + q[: -2 * width])
    return changes
