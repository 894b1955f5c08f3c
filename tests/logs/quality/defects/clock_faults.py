"""Defects of the clock."""

from dataclasses import replace

import numpy as np

from tests.logs.quality.defects.defect import Damaged, columns_of, defect, moving_row, some_joint


@defect("clock_unit")
def time_in_milliseconds(recording, rng):
    columns = columns_of(recording)
    columns["timestamp"] *= 1000
    return Damaged(columns, replace(recording.header, phases=()), "", ("timestamp",))


@defect("clock_rate")
def seconds_read_as_nanoseconds(recording, rng):
    columns = columns_of(recording)
    columns["timestamp"] *= 1e-9
    return Damaged(columns, replace(recording.header, phases=()), "", ("timestamp",))


@defect("clock_jump")
def clock_step(recording, rng):
    columns = columns_of(recording)
    row = moving_row(recording, some_joint(recording, rng), rng)
    columns["timestamp"][row:] += rng.uniform(5, 500) * recording.dt
    return Damaged(columns, recording.header, "", ("timestamp",))


@defect("dropped_samples")
def dropped_samples(recording, rng):
    keep = np.ones(len(recording), dtype=bool)
    for _ in range(int(rng.integers(1, 6))):
        row = moving_row(recording, some_joint(recording, rng), rng)
        keep[row : row + int(rng.integers(1, 8))] = False
    return Damaged({name: x[keep] for name, x in recording.columns.items()}, recording.header, "", ("timestamp",))


@defect("clock_jitter")
def jitter(recording, rng):
    columns = columns_of(recording)
    size = rng.uniform(0.1, 0.3) * recording.dt
    columns["timestamp"] = np.sort(columns["timestamp"] + rng.normal(scale=size, size=len(recording)))
    columns["timestamp"] -= min(columns["timestamp"][0], 0.0)
    return Damaged(columns, replace(recording.header, phases=()), "", ("timestamp",))


@defect("clock_drift")
def rate_changes_midway(recording, rng):
    columns = columns_of(recording)
    row = len(recording) // 2
    factor = rng.uniform(1.03, 1.2)
    t = columns["timestamp"]
    columns["timestamp"] = np.where(np.arange(len(t)) < row, t, t[row] + (t - t[row]) * factor)
    return Damaged(columns, replace(recording.header, phases=()), "", ("timestamp",))
