"""Bursts of noise: left out for their joint."""

import numpy as np

from ffgym.logs.quality.cells import BURST, BURST_REFUSED, burst_ratios, columns_of
from ffgym.logs.quality.conditioning.notes import amended
from ffgym.logs.quality.log import Log
from ffgym.recordings import FAMILIES, Recording


def without_bursts(recording: Recording) -> Recording:
    """The log with a mask over stretches of a column that are far noisier than the rest of it."""
    masked = np.zeros(recording.valid.shape, dtype=np.bool_)
    texts = []
    for column in columns_of(Log(recording)):
        if FAMILIES[column.family].parts != "joint" or FAMILIES[column.family].may_miss:
            continue
        j = recording.header.joints.index(column.name.rpartition(".")[2])
        loud = np.flatnonzero(burst_ratios(column, recording.valid[:, j]) > BURST_REFUSED)
        if not loud.size:
            continue
        for window in loud.tolist():
            masked[max(0, (window - 1) * BURST) : (window + 2) * BURST, j] = True
        texts.append(f"{column.name} (around {recording.t[loud[0] * BURST]:.5g} s)")
    if not texts:
        return recording
    return amended(recording, {}, masked, f"Bursts of noise were left out: {', '.join(texts)}.")
