"""Checks of sizes: joint ranges, speeds, temperatures, tool positions, rests and ends."""

from collections.abc import Iterator

import numpy as np

from ffgym.logs.quality.check import Check, NotJudgedError, Seen
from ffgym.logs.quality.log import Log
from ffgym.recordings import FAMILIES
from ffgym.recordings.stretch import is_stretch

_TURNS = 12.0
"""Angle [rad] that no joint with stops reaches; wrists of six-axis robots turn to 7."""

_COLDEST, _HOTTEST = -40.0, 160.0
"""Temperatures [degC] of motors and gearboxes; 160 is where windings burn."""

_LARGEST = 1e12
"""Number beyond which nothing is measured; clocks that count from 1970 in microseconds come to 2e15 and are refused."""

_REACH = 20.0
"""Distance [m] from its base that no arm reaches."""


def _range(log: Log) -> Iterator[Seen]:
    positions = [name for name in log.motion_families if name.endswith("position")]
    if not positions:
        raise NotJudgedError("there are no positions")
    if log.robot is None and len(log.joints) == 1:
        raise NotJudgedError("a single axis may turn without end; the robot would say its range")
    for family in positions:
        q = log.link_side(family)
        for j, joint in enumerate(log.joints):
            low, high, whose = _limits(log, j)
            excess = max(float(q[:, j].max()) - high, low - float(q[:, j].min()), 0.0) / (high - low)
            message = (
                f"{family}.{joint} reaches from {q[:, j].min():.4g} to {q[:, j].max():.4g} behind the gearbox, must "
                f"be in [{low:.4g}, {high:.4g}], {whose}. Look at degrees, side, gear ratio and zero."
            )
            yield Seen(value=excess, message=message, columns=(f"{family}.{joint}",), joint=joint)


def _limits(log: Log, j: int) -> tuple[float, float, str]:
    if log.robot is not None and log.robot.n_joints == len(log.joints):
        low, high = log.robot.kinematics.range[j]
        return float(low), float(high), f"the range of {log.robot.name}"
    if log.recording.header.joint_types[j] == "hinge":
        return -_TURNS, _TURNS, "what hinges of robots turn by"
    return -_REACH, _REACH, "what slides of robots move by"


def _speed(log: Log) -> Iterator[Seen]:
    if log.robot is None or log.robot.n_joints != len(log.joints) or log.dq is None:
        raise NotJudgedError("it needs the robot and positions")
    for j, joint in enumerate(log.joints):
        top, limit = float(np.abs(log.dq[:, j]).max()), float(log.robot.kinematics.max_speed[j])
        message = (
            f"Joint {joint} moves at {top:.4g} {log.robot.kinematics.units[j]}/s, must stay below {limit:.4g}, the "
            f"limit of {log.robot.name}. Look at the unit of time and angle, and at the gear ratio."
        )
        yield Seen(value=top / limit, message=message, columns=(f"motor.position.{joint}",), joint=joint)


def _temperature(log: Log) -> Iterator[Seen]:
    if not log.recording.has("temperature"):
        raise NotJudgedError("there is no temperature")
    for name, values in log.columns("temperature").items():
        seen = values[np.isfinite(values)]
        if not seen.size:
            continue
        low, high = float(seen.min()), float(seen.max())
        outside = max(high - _HOTTEST, _COLDEST - low, 0.0)
        message = (
            f"{name} goes from {low:.4g} to {high:.4g} degC, must be in [{_COLDEST:g}, {_HOTTEST:g}]. If it is in "
            "kelvin, subtract 273.15; if in degF, convert it."
        )
        yield Seen(value=outside, message=message, columns=(name,), joint=name.removeprefix("temperature."))


def _reach(log: Log) -> Iterator[Seen]:
    families = [name for name in ("tcp.position", "tcp_reference.position") if log.recording.has(name)]
    if not families:
        raise NotJudgedError("there is no tool position")
    for family in families:
        far = float(np.nanmax(np.abs(log.recording.vector(family)), initial=0.0))
        message = (
            f"{family} is up to {far:.4g} m from the base, must be below {_REACH:g} m. If it is in mm, divide by 1000."
        )
        yield Seen(value=far, message=message, columns=FAMILIES[family].columns(log.joints))


def _rests(log: Log) -> Iterator[Seen]:
    if log.dq is None or not log.recording.header.phases:
        raise NotJudgedError("there are no phases, or no positions")
    top = np.abs(log.dq).max(axis=0)
    for phase in log.recording.header.phases:
        rows = np.flatnonzero((log.t >= phase.start) & (log.t < phase.end))
        margin = log.rows(0.05)
        rows = rows[margin:-margin]
        if len(rows) < 5 or not log.excited.any():
            continue
        speed = np.sqrt(np.mean(log.dq[rows] ** 2, axis=0))[log.excited] / top[log.excited]
        rest = phase.kind == "standstill"
        value = float(speed.max()) if rest else float(speed.max() == 0.0)
        message = (
            f"phases: {phase.label!r} is a {phase.kind} from {phase.start:.4g} to {phase.end:.4g} s, but the joints "
            f"{'move there' if rest else 'rest there'}, must {'rest' if rest else 'move'}. Correct its times."
        )
        yield Seen(value=value, message=message, columns=("timestamp",))


def _ends(log: Log) -> Iterator[Seen]:
    if log.dq is None or not log.excited.any():
        raise NotJudgedError("no joint moves")
    if is_stretch(log.recording):
        raise NotJudgedError("the log is a stretch of a longer one")
    top = np.abs(log.dq).max(axis=0)
    share = np.where(log.excited, np.abs(log.dq[-1]) / np.where(top > 0, top, 1.0), 0.0)
    j = int(np.argmax(share))
    message = (
        f"The log ends while joint {log.joints[j]} moves at {share[j]:.0%} of its top speed, must be at rest. It may "
        "be cut short; a log of a whole motion begins and ends at rest."
    )
    yield Seen(value=float(share[j]), message=message, columns=("timestamp",), joint=log.joints[j])


def _size(log: Log) -> Iterator[Seen]:
    for name, values in log.recording.columns.items():
        largest = float(np.nanmax(np.abs(values), initial=0.0))
        message = (
            f"{name} reaches {largest:.4g} {log.recording.unit(name)}, must stay below {_LARGEST:g}. It is "
            "damaged: read or record it again."
        )
        if name != "timestamp":
            yield Seen(value=largest, message=message, columns=(name,))


SIZE = (
    Check(
        name="size",
        figure="Largest number of all columns",
        unit="1",
        flag=_LARGEST,
        refuse=_LARGEST,
        why="no quantity of a robot is as large in SI units; a bit that flipped in an exponent is",
        judge=_size,
    ),
)
"""Checks that come before all computing."""

PLAUSIBLE = (
    Check(
        name="joint_range",
        figure="Excess over the joint range, in ranges",
        unit="1",
        flag=0.02,
        refuse=0.5,
        why="zeros differ by some degrees; degrees for radians leave the range many times over",
        judge=_range,
    ),
    Check(
        name="joint_speed",
        figure="Top speed over the limit",
        unit="1",
        flag=1.2,
        refuse=5.0,
        why="drives overshoot by some percent",
        judge=_speed,
    ),
    Check(
        name="temperature",
        figure="Excess over the range of temperatures",
        unit="degC",
        flag=0.0,
        refuse=0.0,
        why="room temperature in kelvin is 293",
        judge=_temperature,
    ),
    Check(
        name="tool_reach",
        figure="Distance of the tool from the base",
        unit="m",
        flag=_REACH,
        refuse=_REACH,
        why="a metre in millimetres is 1000",
        judge=_reach,
    ),
    Check(
        name="phases",
        figure="Speed in phases of rest over the top speed",
        unit="1",
        flag=0.25,
        why="what is named a standstill is used as one; a joint that sticks and slips in slow circles settles at 0.2",
        judge=_rests,
    ),
    Check(
        name="ends_in_motion",
        figure="Speed in the last row over the top speed",
        unit="1",
        flag=0.2,
        why="a log that ends in motion was cut short, on purpose or not",
        judge=_ends,
    ),
)
"""Checks of sizes."""
