"""Single bad rows: interpolated, and left out for their joint."""

import numpy as np

from ffgym.core.types import Array, IntArray
from ffgym.logs.quality.cells import COMPUTED, REACH, SPIKE, Column, columns_of, outlier_ratio
from ffgym.logs.quality.conditioning.bridge import bridged, is_smooth
from ffgym.logs.quality.conditioning.notes import amended, count
from ffgym.logs.quality.log import Log
from ffgym.recordings import FAMILIES, Recording

_SHARE, _FEW = 0.005, 3
"""Share of the rows of a column, or number if that is more, up to which rows that stick out are single ones; a column
that does so more often is noisy, or of another machine."""

_JUDGED = ("motor.position", "motor.effort", "link.position")
"""Families that residuals are made of: their bad rows do not count for the joint. Others are repaired only."""


def without_spikes(recording: Recording) -> Recording:
    """The log with single rows replaced that stick out of their neighbours as no sample of a machine does.

    What a controller computed is left as it is: commands may jump.
    """
    changed: dict[str, Array] = {}
    masked = np.zeros(recording.valid.shape, dtype=np.bool_)
    odd = np.zeros(recording.valid.shape, dtype=np.bool_)
    texts = []
    for column in columns_of(Log(recording)):
        rows = _single(column)
        if column.family in COMPUTED or not rows.size:
            continue
        bad = np.zeros(len(recording), dtype=np.bool_)
        bad[rows] = True
        values = recording[column.name]
        if FAMILIES[column.family].may_miss:
            changed[column.name] = np.where(bad, np.nan, values)
        else:
            changed[column.name] = bridged(recording.t, values, bad, smooth=is_smooth(column.name))
        if FAMILIES[column.family].parts == "joint":
            joint = recording.header.joints.index(column.name.rpartition(".")[2])
            odd[bad, joint] = True
            masked[bad, joint] |= column.family in _JUDGED
        texts.append(f"{column.name} ({count(len(rows), 'row')}, the first at {recording.t[rows[0]]:.5g} s)")
    if not texts:
        return recording
    note = "Single rows that stick out were replaced, those of positions, torques and several joints left out: "
    masked[odd.sum(axis=1) > 1] = True  # what shakes several joints at once, as the robot's own stop, shakes all
    return amended(recording, changed, masked, f"{note}{', '.join(texts)}.")


def _single(column: Column) -> IntArray:
    """Rows of the recording in which a column sticks out alone, if they are few."""
    found = np.flatnonzero(outlier_ratio(column.values, column.resolution) > SPIKE)
    if found.size > max(_FEW, _SHARE * len(column.values)):
        return found[:0]
    apart = np.diff(found, prepend=-np.inf, append=np.inf) > REACH
    return np.asarray(column.rows[found[apart[:-1] & apart[1:]]])
