"""Things that go wrong with logs, as changes of a clean recording, and what the quality gate must say of each.

Every defect is a function of columns, header and a generator, which returns what it changed. It draws joint, place and
size from the generator. `checks` are findings of which one must name it; none is a defect that no recording can be made
of.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import lfilter

from ffgym.recordings import Header, Phase, Recording

Columns = dict[str, np.ndarray]


@dataclass
class Damaged:
    """Columns and header with a defect, and where it is."""

    columns: Columns
    header: Header
    joint: str = ""
    columns_at_fault: tuple[str, ...] = ()


@dataclass(frozen=True)
class Defect:
    """A way in which a log is wrong."""

    name: str
    inject: Callable[[Recording, np.random.Generator], Damaged]
    checks: tuple[str, ...]
    """Findings of which one must be refused or flagged; empty if making the recording must fail."""
    needs: tuple[str, ...] = ()
    """Families without which it cannot be injected."""
    robot: bool = False
    """Whether it can only be seen against the description."""
    least_joints: int = 1


DEFECTS: list[Defect] = []


def defect(*checks: str, needs: tuple[str, ...] = (), robot: bool = False, least_joints: int = 1) -> Callable:
    def register(inject: Callable) -> Callable:
        entry = Defect(
            name=inject.__name__, inject=inject, checks=checks, needs=needs, robot=robot, least_joints=least_joints
        )
        DEFECTS.append(entry)
        return inject

    return register


def columns_of(recording: Recording) -> Columns:
    return {name: values.copy() for name, values in recording.columns.items()}


def some_joint(recording: Recording, rng: np.random.Generator) -> str:
    """A joint that moves well, so that a defect of it can matter."""
    travel = {j: np.ptp(recording[f"motor.position.{j}"]) for j in recording.header.joints}
    ratio = dict(zip(recording.header.joints, recording.header.gear_ratio, strict=True))
    side = recording.header.position_side == "motor"
    moved = [j for j, size in travel.items() if size / (abs(ratio[j]) if side else 1) > 3e-3]
    return str(rng.choice(moved))


def two_joints(recording: Recording, rng: np.random.Generator) -> tuple[str, str]:
    first = some_joint(recording, rng)
    while (second := some_joint(recording, rng)) == first:
        pass
    return first, second


def moving_row(recording: Recording, joint: str, rng: np.random.Generator, margin: int = 40) -> int:
    """A row in which a joint is fast."""
    x = recording[f"motor.position.{joint}"]
    speed = np.abs(x[10:] - x[:-10])[margin : -margin - 10]
    return int(rng.choice(np.flatnonzero(speed > 0.5 * speed.max()))) + margin + 5


def on_column(recording: Recording, family: str, joint: str, change: Callable[[np.ndarray], np.ndarray]) -> Damaged:
    name = f"{family}.{joint}"
    columns = columns_of(recording)
    columns[name] = change(columns[name])
    return Damaged(columns, recording.header, joint, (name,))


# --- refused at once


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


# --- clock


@defect("clock_unit")
def time_in_milliseconds(recording, rng):
    columns = columns_of(recording)
    columns["timestamp"] *= 1000
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


# --- rows and values


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


# --- columns against each other


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


def permuted(recording, family, rng):
    one, other = two_joints(recording, rng)
    columns = columns_of(recording)
    a, b = f"{family}.{one}", f"{family}.{other}"
    columns[a], columns[b] = columns[b], columns[a]
    return Damaged(columns, recording.header, "", (a, b))


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


def smooth_noise(recording, rng):
    """A signal of size one that changes within tenths of a second."""
    length = max(2, round(0.3 / recording.dt))
    noise = np.convolve(rng.normal(size=len(recording)), np.ones(length) / length, mode="same")
    return noise / noise.std()


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


@defect("lag", needs=("command.effort",))
def one_torque_a_sample_late(recording, rng):
    return on_column(recording, "motor.effort", some_joint(recording, rng), lambda x: np.r_[x[:1], x[:-1]])


# --- torque, tool, header against the description


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
