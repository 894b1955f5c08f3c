"""Checks of columns that are late or early against each other."""

from collections.abc import Iterator

import numpy as np

from ffgym.logs.quality.check import Check, NotJudgedError, Seen
from ffgym.logs.quality.kinship import Signals, channel_of, columns_of
from ffgym.logs.quality.log import Log
from ffgym.logs.quality.signals import motion_signals, torque_signals

_SERVO_LAG = 0.05
"""Delay [s] that a servo may have behind its set-point: the ratio of its speed to its position gain, 1/70 s for the
robots here, some times that without feed-forward of the speed."""


_CURRENT_LOOP = 5e-4
"""Difference [s] between the delays of joints that their drives may make: current loops have 300 Hz and more."""

_ROWS = 0.75
"""Delay in rows that columns of one time may seem to have: a speed from backward differences is half a row late."""

_COPY = 0.995
"""Correlation of motor and set-point from which on a delay between them is one: what else differs may look like it."""


def _within(log: Log) -> Iterator[Seen]:
    """Columns of one machine part: measured ones, torques, set-points."""
    judged = False
    for signals in (motion_signals(log), torque_signals(log)):
        for family, other in _pairs(signals):
            for j in signals.numbers:
                lag = signals.lag(family, other, int(j))
                if lag is None:
                    continue
                judged = True
                columns = (*columns_of(family, log.joints[j]), *columns_of(other, log.joints[j]))
                message = (
                    f"{columns[0]} is {_late(lag)} than {columns[-1]} by {abs(lag) * log.dt:.4g} s ({abs(lag):.3g} "
                    "rows), must be by less than 0.75 rows. Shift it; if it is filtered, say so in filters, or log the "
                    "raw signal."
                )
                yield Seen(value=abs(lag), message=message, columns=columns, joint=log.joints[j])
    if not judged:
        raise NotJudgedError("no two columns of one channel say the same of a joint that moves")


def _apart(log: Log) -> Iterator[Seen]:
    """Torques of which those of one joint are late."""
    signals, judged = torque_signals(log), False
    limit = max(_ROWS * log.dt, _CURRENT_LOOP)
    for family, other in _pairs(signals):
        lags = {j: lag * log.dt for j in signals.numbers if (lag := signals.lag(family, other, j)) is not None}
        if len(lags) < 2:
            continue
        judged = True
        usual = float(np.median([*lags.values()]))
        odd = max(lags, key=lambda j: abs(lags[j] - usual))
        like = max(lags, key=lambda j: abs(lags[j] - lags[odd]))
        message = (
            f"{family} is later than {other} by {lags[odd]:.4g} s on joint {log.joints[odd]} and by {lags[like]:.4g} s "
            f"on joint {log.joints[like]}, must be alike within {limit:.2g} s: rows of a log are of one time. Shift "
            "the torque that is out of step."
        )
        columns = [
            name for j in (odd, like) for signal in (other, family) for name in columns_of(signal, log.joints[j])
        ]
        yield Seen(value=abs(lags[odd] - lags[like]) / limit, message=message, columns=tuple(columns))
    if not judged:
        raise NotJudgedError("no two columns say the same of the torques of two joints")


def _pairs(signals: Signals) -> list[tuple[str, str]]:
    """Families, each with the one that it is compared with: the first of its channel, else the motors'."""
    pairs = []
    for family in signals.values:
        first = next(name for name in signals.values if channel_of(name) == channel_of(family))
        if first == family and channel_of(family) != "reference":
            first = next(iter(signals.values))
        if first != family:
            pairs.append((family, first))
    return pairs


def _late(lag: float) -> str:
    return "later" if lag > 0 else "earlier"


def _behind(log: Log) -> Iterator[Seen]:
    """Measured against planned motion."""
    signals = motion_signals(log)
    if not {"motor.position", "reference.position"} <= set(signals.values):
        raise NotJudgedError("motor.position or reference.position is not there")
    lags = {int(j): signals.lag("motor.position", "reference.position", int(j), _COPY) for j in signals.numbers}
    known = [lag * log.dt for lag in lags.values() if lag is not None]
    if 2 * len(known) <= len(lags):
        raise NotJudgedError("motors and set-points of most joints differ by more than a delay, or by too little")
    common = float(np.median(known))
    message = (
        f"motor.position is {_late(common)} than reference.position by {abs(common):.4g} s, must be later by "
        f"{_SERVO_LAG} s at most and earlier by a tenth of that. Shift the columns of the other clock."
    )
    names = tuple(f"{family}.{joint}" for family in ("motor.position", "reference.position") for joint in log.joints)
    yield Seen(value=common if common > 0 else -10 * common, message=message, columns=names)


TIMING = (
    Check(
        name="torque_lag_apart",
        figure="Difference between joints in the delay of one torque column behind another, over 0.5 ms, or 0.75 rows "
        "where those are longer",
        unit="1",
        flag=1.0,
        why="all torques of a row are of one time; delays of current loops differ by less than 0.5 ms",
        judge=_apart,
    ),
    Check(
        name="lag",
        figure="Delay between columns of one quantity",
        unit="rows",
        flag=_ROWS,
        why="a speed from backward differences is half a row late; more is a filter, or another clock",
        judge=_within,
    ),
    Check(
        name="reference_lag",
        figure="Delay of the motors behind their set-point (ten times its size where they are ahead)",
        unit="s",
        flag=_SERVO_LAG,
        why="a servo may follow late, by its gains; it cannot be ahead by more than its feed-forward's error",
        judge=_behind,
    ),
)
"""Checks of delays."""
