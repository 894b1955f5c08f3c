"""Defects that no recording can be made of."""

from dataclasses import replace

import numpy as np

from ffgym.recordings import Phase
from tests.logs.quality.defects.defect import Damaged, columns_of, defect, on_column, some_joint


@defect()
def nan_in_a_position(recording, rng):
    joint = some_joint(recording, rng)

    def change(x):
        x[rng.integers(len(x))] = np.nan
        return x

    return on_column(recording, "motor.position", joint, change)


@defect()
def infinite_torque(recording, rng):
    joint = some_joint(recording, rng)

    def change(x):
        x[rng.integers(len(x))] = np.inf
        return x

    return on_column(recording, "motor.effort", joint, change)


@defect()
def clock_running_backwards(recording, rng):
    columns = columns_of(recording)
    row = int(rng.integers(2, len(recording) - 2))
    columns["timestamp"][row:] -= rng.uniform(2, 50) * recording.dt
    return Damaged(columns, recording.header)


@defect()
def a_timestamp_twice(recording, rng):
    columns = columns_of(recording)
    row = int(rng.integers(1, len(recording)))
    columns["timestamp"][row] = columns["timestamp"][row - 1]
    return Damaged(columns, recording.header)


@defect()
def a_joint_without_torque(recording, rng):
    columns = columns_of(recording)
    del columns[f"motor.effort.{some_joint(recording, rng)}"]
    return Damaged(
        columns if len(recording.header.joints) > 1 else {"timestamp": columns["timestamp"][:1]}, recording.header
    )


@defect()
def columns_of_two_lengths(recording, rng):
    return on_column(recording, "motor.effort", some_joint(recording, rng), lambda x: x[: -int(rng.integers(1, 9))])


@defect()
def phases_beyond_the_end(recording, rng):
    end = float(recording.t[-1])
    phase = Phase(label="late", kind="motion", start=end, end=end + float(rng.uniform(1, 5)))
    return Damaged(columns_of(recording), replace(recording.header, phases=(phase,)))
