"""Defects of rows and of single columns."""

import numpy as np

from tests.logs.quality.defects.defect import Damaged, columns_of, defect, moving_row, on_column, some_joint, two_joints


@defect("repeated_rows")
def duplicate_rows(recording, rng):
    order = np.arange(len(recording))
    for _ in range(int(rng.integers(3, 9))):
        row = moving_row(recording, some_joint(recording, rng), rng)
        order = np.insert(order, int(np.searchsorted(order, row)), row)
    columns = {name: x[order] for name, x in recording.columns.items()}
    columns["timestamp"] = recording.t[0] + recording.dt * np.arange(len(order))
    return Damaged(columns, recording.header)


@defect("repeated_block")
def a_block_pasted_twice(recording, rng):
    length = int(rng.integers(20, 100))
    row = moving_row(recording, some_joint(recording, rng), rng, margin=length + 5)
    order = np.r_[0 : row + length, row : len(recording)]
    columns = {name: x[order] for name, x in recording.columns.items()}
    columns["timestamp"] = recording.t[0] + recording.dt * np.arange(len(order))
    return Damaged(columns, recording.header)


@defect("copied_column", least_joints=2)
def one_joint_copied_to_another(recording, rng):
    source, target = two_joints(recording, rng)
    family = str(rng.choice(["motor.position", "motor.effort"]))
    columns = columns_of(recording)
    columns[f"{family}.{target}"] = columns[f"{family}.{source}"].copy()
    return Damaged(columns, recording.header, "", (f"{family}.{target}",))


@defect("constant")
def all_zeros_torque(recording, rng):
    return on_column(recording, "motor.effort", some_joint(recording, rng), np.zeros_like)


@defect("stuck")
def stuck_position(recording, rng):
    joint = some_joint(recording, rng)
    row = moving_row(recording, joint, rng)
    length = max(12, round(rng.uniform(0.2, 0.5) / recording.dt))

    def change(x):
        x[row : row + length] = x[row]
        return x

    return on_column(recording, "motor.position", joint, change)


@defect("spike")
def a_spike(recording, rng):
    joint = some_joint(recording, rng)
    family = str(rng.choice(["motor.position", "motor.effort"]))
    row = moving_row(recording, joint, rng)

    def change(x):
        x[row] += rng.choice([-1, 1]) * rng.uniform(0.5, 5) * np.ptp(x)
        return x

    return on_column(recording, family, joint, change)


@defect("jump")
def offset_jump(recording, rng):
    joint = some_joint(recording, rng)
    row = moving_row(recording, joint, rng)

    def change(x):
        x[row:] += rng.choice([-1, 1]) * rng.uniform(0.3, 1) * np.ptp(x)
        return x

    return on_column(recording, "motor.position", joint, change)


@defect("noise_burst", "spike")
def noise_burst(recording, rng):
    joint = some_joint(recording, rng)
    row = moving_row(recording, joint, rng)
    length = int(rng.integers(130, 260))

    def change(x):
        part = x[row : row + length]
        part += rng.normal(scale=rng.uniform(0.3, 1) * np.ptp(x), size=len(part))
        return x

    return on_column(recording, "motor.effort", joint, change)


@defect("clipped")
def clipped_torque(recording, rng):
    joint = some_joint(recording, rng)
    share = rng.uniform(0.3, 0.6)

    def change(x):
        middle, half = 0.5 * (x.max() + x.min()), 0.5 * np.ptp(x)
        return np.clip(x, middle - share * half, middle + share * half)

    return on_column(recording, "motor.effort", joint, change)


@defect("coarse", "encoder_steps")
def quantised_to_8_bits(recording, rng):
    joint = some_joint(recording, rng)
    family = str(rng.choice(["motor.position", "motor.effort"]))

    def change(x):
        step = np.ptp(x) / 2 ** int(rng.integers(5, 9))
        return np.round(x / step) * step

    return on_column(recording, family, joint, change)


@defect("missing", needs=("tcp.position",))
def nan_filled_tracker(recording, rng):
    columns = columns_of(recording)
    start = int(rng.integers(0, len(recording) // 3))
    for axis in "xyz":
        columns[f"tcp.position.{axis}"][start:] = np.nan
    return Damaged(columns, recording.header, "", ("tcp.position.x",))
