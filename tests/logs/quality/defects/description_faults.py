"""Torque, tool and header that do not fit the robot."""

from dataclasses import replace

import numpy as np

from tests.logs.quality.defects.defect import (
    Damaged,
    columns_of,
    defect,
    moving_row,
    permuted,
    smooth_noise,
    some_joint,
)


@defect("torque_lag")
def all_torques_100_ms_late(recording, rng):
    rows = round(rng.uniform(0.1, 0.15) / recording.dt)
    columns = columns_of(recording)
    for name in columns:
        if "effort" in name:
            columns[name] = np.r_[columns[name][:1].repeat(rows), columns[name][:-rows]]
    return Damaged(columns, recording.header, "", (f"motor.effort.{some_joint(recording, rng)}",))


@defect("torque_sign", "gravity_direction")  # of slow loaded joints the two are one
def all_torques_with_the_opposite_sign(recording, rng):
    columns = {name: -x if "effort" in name else x for name, x in recording.columns.items()}
    return Damaged(columns, recording.header, "", ())


@defect("torque_units", robot=True)
def all_torques_in_millinewton_metres(recording, rng):
    columns = {name: 1000 * x if "effort" in name else x for name, x in recording.columns.items()}
    return Damaged(columns, recording.header, "", ())


@defect("torque_permutation", "units", "permutation", "agreement", "scale", "side", robot=True, least_joints=2)
def permuted_torques(recording, rng):
    return permuted(recording, "motor.effort", rng)


@defect("gear_ratio", robot=True)
def wrong_gear_ratio(recording, rng):
    ratios = list(recording.header.gear_ratio)
    j = int(rng.integers(len(ratios)))
    ratios[j] *= rng.choice([0.5, 0.9, 1.05, 2.0])
    return Damaged(
        columns_of(recording), replace(recording.header, gear_ratio=tuple(ratios)), recording.header.joints[j]
    )


@defect("tracker_scale", "tool_reach", needs=("tcp.position",))
def tracker_in_millimetres(recording, rng):
    columns = {name: 1000 * x if name.startswith("tcp.position") else x for name, x in recording.columns.items()}
    return Damaged(columns, recording.header, "", ("tcp.position.x",))


@defect("tracker_motion", needs=("tcp.position",))
def tracker_of_another_motion(recording, rng):
    columns = columns_of(recording)
    for axis in "xyz":
        x = columns[f"tcp.position.{axis}"]
        columns[f"tcp.position.{axis}"] = np.nanmean(x) + 0.02 * smooth_noise(recording, rng) + 0 * x
    return Damaged(columns, recording.header, "", ("tcp.position.x",))


@defect("tracker_lag", needs=("tcp.position",))
def tracker_late(recording, rng):
    rows = round(rng.uniform(0.05, 0.2) / recording.dt)
    columns = columns_of(recording)
    for axis in "xyz":
        x = columns[f"tcp.position.{axis}"]
        columns[f"tcp.position.{axis}"] = np.r_[x[:1].repeat(rows), x[:-rows]]
    return Damaged(columns, recording.header, "", ("tcp.position.x",))


@defect("temperature")
def temperature_in_kelvin(recording, rng):
    columns = columns_of(recording)
    for joint in recording.header.joints:
        columns[f"temperature.{joint}"] = 293.15 + rng.uniform(0, 20) + 1e-3 * recording.t
    return Damaged(columns, recording.header, "", (f"temperature.{recording.header.joints[0]}",))


@defect("ends_in_motion")
def truncated_in_motion(recording, rng):
    row = moving_row(recording, some_joint(recording, rng), rng)
    row = max(row, len(recording) // 3) if row > len(recording) // 3 else row + len(recording) // 3
    part = recording.slice(end=float(recording.t[row]))
    return Damaged(columns_of(part), part.header)


@defect("torque_semantics")
def torque_of_unknown_meaning(recording, rng):
    return Damaged(
        columns_of(recording), replace(recording.header, torque_semantics="unspecified"), "", ("motor.effort",)
    )
