"""Repeated rows, which a logger writes that polls faster than the controller computes: dropped."""

import numpy as np

from ffgym.logs.quality.conditioning.notes import count, noted
from ffgym.logs.quality.log import Log, NotJudgedError
from ffgym.logs.quality.rows import copies
from ffgym.recordings import Recording


def without_copies(recording: Recording) -> Recording:
    """The log without rows that repeat the one before in motion; their times stay free, as of missing rows."""
    try:
        found = copies(Log(recording))
    except NotJudgedError:
        return recording
    if not found:
        return recording
    kept = np.ones(len(recording), dtype=np.bool_)
    for rows in found:
        kept[rows] = False
    note = (
        f"{count(int((~kept).sum()), 'row')} of {len(kept)} that repeat the row before in motion were dropped, the "
        f"first at {recording.t[found[0].start]:.4g} s."
    )
    columns = {name: values[kept] for name, values in recording.columns.items()}
    return Recording(columns, noted(recording.header, note))
