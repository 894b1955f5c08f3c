"""Columns that do not fit each other."""

import numpy as np
from scipy.signal import lfilter

from tests.logs.quality.defects.defect import Damaged, columns_of, defect, on_column, permuted, smooth_noise, some_joint


@defect("units", "joint_range")
def degrees_for_radians(recording, rng):
    return on_column(recording, "motor.position", some_joint(recording, rng), np.degrees)


@defect("units", needs=("motor.velocity",))
def revolutions_per_minute(recording, rng):
    return on_column(recording, "motor.velocity", some_joint(recording, rng), lambda x: x * 30 / np.pi)


@defect("side", "units", "joint_range", needs=("reference.position",))
def link_side_for_motor_side(recording, rng):
    joint = some_joint(recording, rng)
    ratio = recording.header.gear_ratio[recording.header.joints.index(joint)]
    factor = 1 / ratio if recording.header.position_side == "motor" else ratio
    return on_column(recording, "motor.position", joint, lambda x: x * factor)


@defect("sign", needs=("reference.position",))
def swapped_sign_of_a_position(recording, rng):
    return on_column(recording, "motor.position", some_joint(recording, rng), np.negative)


@defect("permutation", "side", "scale", needs=("reference.position",), least_joints=2)
def permuted_positions(recording, rng):
    return permuted(recording, "motor.position", rng)


@defect("agreement", "stuck", "sign", needs=("motor.velocity",))
def velocity_that_is_no_derivative(recording, rng):
    joint = some_joint(recording, rng)
    return on_column(recording, "motor.velocity", joint, lambda x: smooth_noise(recording, rng) * x.std())


@defect("agreement", needs=("reference.position",))
def reference_of_another_motion(recording, rng):
    columns = columns_of(recording)
    joint = some_joint(recording, rng)
    position = f"reference.position.{joint}"
    speed = smooth_noise(recording, rng) * np.abs(np.gradient(columns[position], recording.t)).max()
    columns[position] = columns[position][0] + np.cumsum(speed) * recording.dt
    for name, values in (
        (f"reference.velocity.{joint}", speed),
        (f"reference.acceleration.{joint}", np.gradient(speed)),
    ):
        if name in columns:
            columns[name] = values / (recording.dt if "acceleration" in name else 1.0)
    return Damaged(columns, recording.header, joint, (position, f"motor.position.{joint}"))


@defect("lag", needs=("motor.velocity",))
def a_column_shifted_by_rows(recording, rng):
    rows = int(rng.integers(10, 60))
    return on_column(
        recording, "motor.velocity", some_joint(recording, rng), lambda x: np.r_[x[:1].repeat(rows), x[:-rows]]
    )


@defect("lag", needs=("motor.velocity",))
def filtered_speed_called_raw(recording, rng):
    pole = np.exp(-recording.dt / rng.uniform(0.01, 0.03))
    return on_column(
        recording, "motor.velocity", some_joint(recording, rng), lambda x: lfilter([1 - pole], [1, -pole], x)
    )


@defect("lag", "torque_lag_apart", needs=("command.effort",))
def one_torque_a_sample_late(recording, rng):
    return on_column(recording, "motor.effort", some_joint(recording, rng), lambda x: np.r_[x[:1], x[:-1]])
