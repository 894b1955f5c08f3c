"""Stretches of a stuck column: bridged, and left out."""

import numpy as np

from ffgym.core.types import Array
from ffgym.logs.quality.conditioning.bridge import bridged, is_smooth
from ffgym.logs.quality.conditioning.notes import amended
from ffgym.logs.quality.log import Log
from ffgym.logs.quality.values import stuck_stretches
from ffgym.recordings import Recording


def without_stuck(recording: Recording) -> Recording:
    """The log with stuck columns bridged; where a position is not known, no torque counts, as it depends on all."""
    found = stuck_stretches(Log(recording))
    if not found:
        return recording
    changed: dict[str, Array] = {}
    masked = np.zeros(recording.valid.shape, dtype=np.bool_)
    texts = []
    for stretch in found:
        bad = np.zeros(len(recording), dtype=np.bool_)
        bad[stretch.rows] = True
        values = changed.get(stretch.name, recording[stretch.name])
        changed[stretch.name] = bridged(recording.t, values, bad, smooth=is_smooth(stretch.name))
        masked[bad, slice(None) if "position" in stretch.name else stretch.joint] = True
        first, last = recording.t[stretch.rows.start], recording.t[stretch.rows.stop - 1]
        texts.append(f"{stretch.name} ({first:.5g} to {last:.5g} s)")
    return amended(recording, changed, masked, f"Stuck columns were bridged and left out: {', '.join(texts)}.")
