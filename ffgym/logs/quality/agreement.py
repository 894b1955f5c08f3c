"""Checks of columns that say the same in different words: units, sides, signs, joints, sizes and delays."""

from collections.abc import Callable, Iterator
from typing import get_args

import numpy as np

from ffgym.logs.quality.check import ROWS, Seen, check, late
from ffgym.logs.quality.kinship import Kind, TorqueSignals, channel_of, columns_of, motion_signals, torque_signals
from ffgym.logs.quality.log import CheckedLog, NotJudgedError

_CURRENT_LOOP = 5e-4
"""Difference [s] between the delays of joints that their drives may make: current loops have 300 Hz and more."""

_ROWS = ROWS["lag"]["flag"]
"""Delay in rows that columns of one time may seem to have."""

_COPY = 0.995
"""Correlation of motor and set-point from which on a delay between them is one: what else differs may look like it."""


def _judge(kind: Kind) -> Callable[[CheckedLog], Iterator[Seen]]:
    """Judge of the columns that do not fit in one way."""

    def judge(log: CheckedLog) -> Iterator[Seen]:
        groups = [signals for signals in (motion_signals(log), torque_signals(log)) if len(signals.values) > 1]
        if not groups:
            raise NotJudgedError("no two columns say the same of a joint that moves")
        yield Seen(0.0)  # where nothing is odd
        yield from (seen for signals in groups for way, seen in signals.misfits if way == kind)

    return judge


KINDS = tuple(check(_judge(kind), kind) for kind in get_args(Kind))
"""One check for each way in which a column may not fit the others."""


@check
def _lag(log: CheckedLog) -> Iterator[Seen]:
    """Columns of one machine part: measured ones, torques, set-points."""
    judged = False
    for signals in (motion_signals(log), torque_signals(log)):
        for family, other in _pairs(signals):
            for j in signals.numbers:
                lag = signals.lag(family, other, j)
                if lag is None:
                    continue
                judged = True
                columns = (*columns_of(family, log.joints[j]), *columns_of(other, log.joints[j]))
                words = {"late": late(lag), "last": columns[-1], "seconds": abs(lag) * log.dt}
                yield Seen(abs(lag), columns, log.joints[j], words)
    if not judged:
        raise NotJudgedError("no two columns of one channel say the same of a joint that moves")


@check
def _torque_lag_apart(log: CheckedLog) -> Iterator[Seen]:
    """Torques of which those of one joint are late."""
    signals, judged = torque_signals(log), False
    within = max(_ROWS * log.dt, _CURRENT_LOOP)
    for family, other in _pairs(signals):
        lags = {j: lag * log.dt for j in signals.numbers if (lag := signals.lag(family, other, j)) is not None}
        if len(lags) < 2:
            continue
        judged = True
        usual = float(np.median([*lags.values()]))
        odd = max(lags, key=lambda j: abs(lags[j] - usual))
        like = max(lags, key=lambda j: abs(lags[j] - lags[odd]))
        columns = [c for j in (odd, like) for signal in (other, family) for c in columns_of(signal, log.joints[j])]
        words = {"family": family, "other": other, "within": within, "odd": log.joints[odd], "like": log.joints[like]}
        words |= {"odd_lag": lags[odd], "like_lag": lags[like]}
        yield Seen(abs(lags[odd] - lags[like]) / within, tuple(columns), words=words)
    if not judged:
        raise NotJudgedError("no two columns say the same of the torques of two joints")


def _pairs(signals: TorqueSignals) -> list[tuple[str, str]]:
    """Families, each with the one that it is compared with: the first of its channel, else the motors'."""
    pairs = []
    for family in signals.values:
        first = next(name for name in signals.values if channel_of(name) == channel_of(family))
        if first == family and channel_of(family) != "reference":
            first = next(iter(signals.values))
        if first != family:
            pairs.append((family, first))
    return pairs


@check
def _reference_lag(log: CheckedLog) -> Iterator[Seen]:
    """Measured against planned motion; a servo cannot be ahead by more than its feed-forward's error."""
    signals, names = motion_signals(log), ("motor.position", "reference.position")
    if not set(names) <= set(signals.values):
        raise NotJudgedError("motor.position or reference.position is not there")
    lags = [signals.lag(*names, j, _COPY) for j in signals.numbers]
    known = [lag * log.dt for lag in lags if lag is not None]
    if 2 * len(known) <= len(lags):
        raise NotJudgedError("motors and set-points of most joints differ by more than a delay, or by too little")
    common = float(np.median(known))
    columns = tuple(f"{family}.{joint}" for family in names for joint in log.joints)
    words = {"late": late(common), "seconds": abs(common)}
    yield Seen(common if common > 0 else -10 * common, columns, words=words)
