"""What a log excites, joint by joint: figures, not faults; and what it must have for the uses of needs.toml."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import final

import numpy as np

from ffgym.core.errors import check_choice
from ffgym.core.types import Array
from ffgym.logs.quality.check import Finding, Seen, check, load_table
from ffgym.logs.quality.log import Log, NotJudgedError
from ffgym.logs.quality.signals import stretches
from ffgym.logs.quality.torque import model_of

_LASTS = 0.1
"""Time [s] that a direction or a rest must last to count."""

_SLOWEST = 1e-3
"""Speed [rad/s or m/s, link side] below which a joint rests: the steps of an encoder make less."""

_PRESLIDING = 2e-4
"""Travel [rad or m, link side] after a reversal in which bristles bend: 20 to 200 microrad in robots."""

Figure = Callable[[Log, int], float]


def directions(log: Log, j: int) -> list[slice]:
    """Stretches in which joint `j` goes one way for `_LASTS` at least, in order."""
    shortest = log.rows(_LASTS)
    both = [stretches(sign * log.dq[:, j] > _SLOWEST, shortest) for sign in (1, -1)]
    return sorted(both[0] + both[1], key=lambda rows: rows.start)


def _reversals(log: Log, j: int) -> float:
    signs = [np.sign(log.dq[rows.start, j]) for rows in directions(log, j)]
    return float(np.sum(np.diff(signs) != 0))


def _speeds(log: Log, j: int) -> float:
    typical = [float(np.median(np.abs(log.dq[rows, j]))) for rows in directions(log, j)]
    return max(typical) / min(typical) if typical else 1.0


def _top_speed(log: Log, j: int) -> float:
    return float(np.abs(log.dq[:, j]).max())


def _both_ways(log: Log, j: int) -> float:
    """Share of the time in motion that goes the rarer way."""
    forwards, backwards = (float(np.sum(sign * log.dq[:, j] > _SLOWEST)) for sign in (1, -1))
    return min(forwards, backwards) / max(forwards + backwards, 1.0)


def _longest_rest(log: Log, j: int) -> float:
    rests = stretches(np.abs(log.dq[:, j]) <= _SLOWEST)
    return max((float(log.t[rows.stop - 1] - log.t[rows.start]) for rows in rests), default=0.0)


def _presliding_rows(log: Log, j: int) -> float:
    """Rows in the first bit of travel after reversals, per reversal."""
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
    return float(np.ptp(log.smooth_q[:, j]))


def figures(log: Log, figure: Figure) -> Array:
    """A figure of every joint, (N,); 0 for joints that do not move.

    Raises:
        NotJudgedError: if there are no positions, or the figure needs more.
    """
    if not log.has_positions:
        raise NotJudgedError("there are no positions")
    return np.array([figure(log, j) if log.excited[j] else 0.0 for j in range(len(log.joints))])


def _judge(figure: Figure) -> Callable[[Log], Iterator[Seen]]:
    def judge(log: Log) -> Iterator[Seen]:
        for j, value in enumerate(figures(log, figure)):
            yield Seen(float(value), joint=log.joints[j])

    return judge


FIGURES: Mapping[str, Figure] = {
    "travel": _travel,
    "reversals": _reversals,
    "top_speed": _top_speed,
    "speed_ratio": _speeds,
    "both_ways": _both_ways,
    "longest_rest": _longest_rest,
    "presliding_rows": _presliding_rows,
    "load_span": _load_span,
    "temperature_span": _temperature_span,
}
"""Figures of coverage by name; joints that do not move have zeros."""

COVERAGE = tuple(check(_judge(figure), name) for name, figure in FIGURES.items())
"""What a log excites."""


@final
@dataclass(frozen=True, kw_only=True)
class Need:
    """A use of a log."""

    columns: Sequence[str] = ()
    """Families that it takes."""
    torque: bool = False
    """Whether the header must say what the torque is."""
    least: Mapping[str, float] = field(default_factory=dict)
    """Figures of coverage that at least one joint must reach, by name."""
    sound: Sequence[str] = ()
    """Checks that must not even be flagged."""
    why: str


NEEDS: Mapping[str, Need] = MappingProxyType({name: Need(**row) for name, row in load_table("needs.toml").items()})
"""Uses of a log by name."""


def need_findings(log: Log, needs: Iterable[str], others: Sequence[Finding]) -> tuple[Finding, ...]:
    """What a log lacks for its uses: refused if no joint serves, flagged for joints that do not.

    Args:
        log: what is judged.
        needs: names of uses.
        others: what checks found, of which some uses bear less.

    Raises:
        FFGymError: if a use is unknown.
    """
    found: list[Finding] = []
    for name in needs:
        need = NEEDS[check_choice("need", name, list(NEEDS))]
        found += _columns(log, name, need) or _flaws(name, need, others) or _coverage(log, name, need) or [_met(name)]
    return tuple(found)


def _met(name: str) -> Finding:
    return Finding(check=f"need_{name}", verdict="ok", message=f"The log has what {name} needs.")


def _columns(log: Log, name: str, need: Need) -> list[Finding]:
    absent = [family for family in need.columns if not log.recording.has(family)]
    if absent:
        return [_refused(name, f"{', '.join(absent)} is missing, {name} needs it ({need.why}). Log it.", tuple(absent))]
    if need.torque and log.recording.header.torque_semantics == "unspecified":
        text = (
            f"header torque_semantics is 'unspecified', {name} needs to know it ({need.why}). Say what the torque is."
        )
        return [_refused(name, text, ("motor.effort",))]
    return []


def _flaws(name: str, need: Need, others: Sequence[Finding]) -> list[Finding]:
    """What the use does not bear, although others do."""
    flagged = [finding for finding in others if finding.verdict == "flagged" and finding.check in need.sound]
    return [_refused(name, f"For {name}: {finding.message}", finding.columns) for finding in flagged]


def _refused(name: str, message: str, columns: tuple[str, ...] = ()) -> Finding:
    return Finding(check=f"need_{name}", verdict="refused", message=message, columns=columns)


def _coverage(log: Log, name: str, need: Need) -> list[Finding]:
    short = np.zeros(len(log.joints), dtype=np.bool_)
    texts = []
    for figure, least in need.least.items():
        try:
            values = figures(log, FIGURES[figure])
        except NotJudgedError as reason:
            return [_refused(name, f"{figure} is not known: {reason}; {name} needs it ({need.why}).")]
        short |= values < least
        shown = ", ".join(f"{joint} {value:.3g}" for joint, value in zip(log.joints, values, strict=True))
        texts.append(f"{figure} is {shown}, must be {least:g} at least")
    if not short.any():
        return []
    joints = [joint for joint, lacks in zip(log.joints, short, strict=True) if lacks]
    message = (
        f"{'; '.join(texts)}: joints {', '.join(joints)} do not serve for {name} ({need.why}). Record another motion."
    )
    if short.all():
        return [_refused(name, message)]
    return [Finding(check=f"need_{name}", verdict="flagged", message=message, joint=joint) for joint in joints]
