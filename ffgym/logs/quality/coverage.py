"""What a log excites, joint by joint: figures, not faults; what they must be depends on what the log is for."""

from collections.abc import Callable, Iterator

import numpy as np

from ffgym.core.types import Array
from ffgym.logs.quality.check import Check, NotJudgedError, Seen
from ffgym.logs.quality.log import Log
from ffgym.logs.quality.model import model_of
from ffgym.logs.quality.runs import stretches

_LASTS = 0.1
"""Time [s] that a direction or a rest must last to count."""

_SLOWEST = 1e-3
"""Speed [rad/s or m/s, link side] below which a joint rests: the steps of an encoder make less."""

_PRESLIDING = 2e-4
"""Travel [rad or m, link side] after a reversal in which bristles bend: 20 to 200 microrad in robots."""

Figure = Callable[[Log, int], float]


def directions(log: Log, j: int) -> list[slice]:
    """Stretches in which joint `j` goes one way for `_LASTS` at least, in order."""
    assert log.dq is not None
    shortest = log.rows(_LASTS)
    both = [stretches(sign * log.dq[:, j] > _SLOWEST, shortest) for sign in (1, -1)]
    return sorted(both[0] + both[1], key=lambda rows: rows.start)


def _reversals(log: Log, j: int) -> float:
    assert log.dq is not None
    signs = [np.sign(log.dq[rows.start, j]) for rows in directions(log, j)]
    return float(np.sum(np.diff(signs) != 0))


def _speeds(log: Log, j: int) -> float:
    assert log.dq is not None
    typical = [float(np.median(np.abs(log.dq[rows, j]))) for rows in directions(log, j)]
    return max(typical) / min(typical) if typical else 1.0


def _top_speed(log: Log, j: int) -> float:
    assert log.dq is not None
    return float(np.abs(log.dq[:, j]).max())


def _both_ways(log: Log, j: int) -> float:
    """Share of the time in motion that goes the rarer way."""
    assert log.dq is not None
    forwards, backwards = (float(np.sum(sign * log.dq[:, j] > _SLOWEST)) for sign in (1, -1))
    return min(forwards, backwards) / max(forwards + backwards, 1.0)


def _longest_rest(log: Log, j: int) -> float:
    assert log.dq is not None
    rests = stretches(np.abs(log.dq[:, j]) <= _SLOWEST)
    return max((float(log.t[rows.stop - 1] - log.t[rows.start]) for rows in rests), default=0.0)


def _presliding_rows(log: Log, j: int) -> float:
    """Rows in the first bit of travel after reversals, per reversal."""
    assert log.smooth_q is not None
    q = log.smooth_q[:, j]
    counts = [
        int(np.argmax(np.abs(q[rows] - q[rows.start]) > _PRESLIDING) or rows.stop - rows.start)
        for rows in directions(log, j)
    ]
    return float(np.median(counts)) if counts else 0.0


def _load_span(log: Log, j: int) -> float:
    model = model_of(log)
    return float(np.ptp(model.gravity[:, j]) / model.robot.drive.peak_torque[j])


def _temperature_span(log: Log, j: int) -> float:
    if not log.recording.has("temperature"):
        raise NotJudgedError("there is no temperature")
    values = log.recording.joint_array("temperature")[:, j]
    values = values[np.isfinite(values)]
    return float(np.ptp(values)) if values.size else 0.0


def _travel(log: Log, j: int) -> float:
    assert log.smooth_q is not None
    return float(np.ptp(log.smooth_q[:, j]))


def figures(log: Log, figure: Figure) -> Array:
    """A figure of every joint, (N,); 0 for joints that do not move.

    Raises:
        NotJudgedError: if there are no positions, or the figure needs more.
    """
    if log.smooth_q is None:
        raise NotJudgedError("there are no positions")
    return np.array([figure(log, j) if log.excited[j] else 0.0 for j in range(len(log.joints))])


def _judge(figure: Figure) -> Callable[[Log], Iterator[Seen]]:
    def judge(log: Log) -> Iterator[Seen]:
        for j, value in enumerate(figures(log, figure)):
            yield Seen(value=float(value), message="", joint=log.joints[j])

    return judge


FIGURES: dict[str, tuple[Figure, str, str]] = {
    "travel": (_travel, "Travel", "rad or m"),
    "reversals": (_reversals, "Reversals", "1"),
    "top_speed": (_top_speed, "Top speed", "rad/s or m/s"),
    "speed_ratio": (_speeds, "Fastest over slowest steady speed", "1"),
    "both_ways": (_both_ways, "Share of the motion that goes the rarer way", "1"),
    "longest_rest": (_longest_rest, "Longest rest", "s"),
    "presliding_rows": (_presliding_rows, "Rows in the first 0.2 mrad after a reversal", "1"),
    "load_span": (_load_span, "Span of the gravity torque over the peak torque", "1"),
    "temperature_span": (_temperature_span, "Span of the temperature", "degC"),
}
"""Figures of coverage by name: how they are computed, what they are, unit."""

COVERAGE = tuple(
    Check(
        name=name,
        figure=what,
        unit=unit,
        flag=None,
        why="a figure for every joint; what it must be is a matter of `needs`",
        judge=_judge(figure),
        every=True,
    )
    for name, (figure, what, unit) in FIGURES.items()
)
"""What a log excites; joints that do not move have zeros."""
