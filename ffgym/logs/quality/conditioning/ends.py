"""Ends of a log that count for no joint: dropped, but for a moment that filters have to settle in."""

import numpy as np

from ffgym.logs.quality.conditioning.notes import noted
from ffgym.recordings import Recording

_SETTLING = 0.25
"""Time [s] of what does not count that stays at either end: the low-passes of diagnosis and identification settle."""


def trimmed(recording: Recording) -> Recording:
    """The log without long ends that count for no joint."""
    counting = np.flatnonzero(recording.valid.any(axis=1))
    if not counting.size:
        return recording
    t, dt = recording.t, recording.dt
    first, last = float(t[counting[0]]) - _SETTLING, float(t[counting[-1]]) + _SETTLING
    kept = (t >= first - 0.5 * dt) & (t <= last + 0.5 * dt)
    if kept.all():
        return recording
    rows = np.flatnonzero(kept)
    end = None if kept[-1] else float(t[rows[-1] + 1])
    part = recording.slice(float(t[rows[0]]), end)
    before, after = float(t[rows[0]] - t[0]), float(t[-1] - t[rows[-1]])
    texts = [f"{x:.3g} s at the {end}" for x, end in ((before, "beginning"), (after, "end")) if x > 0]
    return Recording(
        part.columns, noted(part.header, f"Rows that count for no joint were dropped: {', '.join(texts)}.")
    )
