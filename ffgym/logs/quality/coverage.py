"""Excitation of a log, joint by joint: figures, not faults; and what its uses need (needs.toml)."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from types import MappingProxyType

import numpy as np

from ffgym.core.errors import check_choice
from ffgym.core.types import Array
from ffgym.logs.quality.check import Finding, Seen, check, load_table
from ffgym.logs.quality.log import CheckedLog, NotJudgedError
from ffgym.logs.quality.signals import stretches
from ffgym.logs.quality.torque import model_of

_LASTS = 0.1
"""Time [s] that a direction or a rest must last to count."""

_SLOWEST = 1e-3
"""Speed [rad/s or m/s, link side] below which a joint rests: the steps of an encoder make less."""

_PRESLIDING = 2e-4
"""Travel [rad or m, link side] after a reversal in which bristles bend: 20 to 200 microrad in robots."""

FIGURES = (
    *("travel", "reversals", "top_speed", "speed_ratio", "both_ways", "longest_rest", "presliding_rows"),
    *("load_span", "temperature_span"),
)
"""Figures of coverage; joints that do not move have zeros."""


def figures(log: CheckedLog, name: str) -> Array:
    """A figure of every joint, (N,)."""
    if not log.has_positions:
        raise NotJudgedError("there are no positions")
    if name == "load_span":
        if not log.excited.any():
            return np.zeros(len(log.joints))
        model = model_of(log)
        return np.where(log.excited, np.ptp(model.gravity, axis=0) / model.robot.drive.peak_torque, 0.0)
    if name == "temperature_span":
        if not log.excited.any():
            return np.zeros(len(log.joints))
        if not log.recording.has("temperature"):
            raise NotJudgedError("there is no temperature")
        columns = [x[np.isfinite(x)] for x in log.recording.joint_array("temperature").T]
        return np.array([np.ptp(x) if moves and x.size else 0.0 for x, moves in zip(columns, log.excited, strict=True)])
    return _motion_figures(log)[name]


@lru_cache(maxsize=4)
def _motion_figures(log: CheckedLog) -> dict[str, Array]:
    """Figures of the motion of every joint, (N,) each."""
    found = {name: np.zeros(len(log.joints)) for name in FIGURES}
    for j in np.flatnonzero(log.excited).tolist():
        q, dq = log.smooth_q[:, j], log.dq[:, j]
        found["travel"][j] = np.ptp(q)
        found["top_speed"][j] = np.abs(dq).max()
        # stretches in which the joint goes one way
        forth, back = (stretches(sign * dq > _SLOWEST, log.rows(_LASTS)) for sign in (1, -1))
        ways = sorted(forth + back, key=lambda rows: rows.start)
        found["reversals"][j] = np.sum(np.diff([np.sign(dq[rows.start]) for rows in ways]) != 0)
        typical = [float(np.median(np.abs(dq[rows]))) for rows in ways]
        found["speed_ratio"][j] = max(typical) / min(typical) if typical else 1.0
        # share of the time in motion that goes the rarer way
        forwards, backwards = (float(np.sum(sign * dq > _SLOWEST)) for sign in (1, -1))
        found["both_ways"][j] = min(forwards, backwards) / max(forwards + backwards, 1.0)
        rests = stretches(np.abs(dq) <= _SLOWEST)
        found["longest_rest"][j] = max((log.t[rows.stop - 1] - log.t[rows.start] for rows in rests), default=0.0)
        # rows in the first bit of travel after reversals, per reversal
        travelled = [np.abs(q[rows] - q[rows.start]) > _PRESLIDING for rows in ways]
        counts = [int(np.argmax(beyond) or len(beyond)) for beyond in travelled]
        found["presliding_rows"][j] = np.median(counts) if counts else 0.0
    return found


def _judge(name: str) -> Callable[[CheckedLog], Iterator[Seen]]:
    def judge(log: CheckedLog) -> Iterator[Seen]:
        for joint, value in zip(log.joints, figures(log, name).tolist(), strict=True):
            yield Seen(value, joint=joint)

    return judge


COVERAGE = tuple(check(_judge(name), name) for name in FIGURES)
"""Checks of what a log excites."""


@dataclass(frozen=True, kw_only=True)
class Need:
    """A use of a log."""

    columns: Sequence[str] = ()
    """Families that it takes."""
    any_of: Sequence[str] = ()
    """Families of which it takes one at least."""
    torque: bool = False
    """True if the header must say what the torque is."""
    least: Mapping[str, float] = field(default_factory=dict)
    """Figures of coverage that at least one joint must reach, by name."""
    sound: Sequence[str] = ()
    """Checks that must not even be flagged."""
    why: str


NEEDS: Mapping[str, Need] = MappingProxyType({name: Need(**row) for name, row in load_table("needs.toml").items()})
"""Uses of a log by name."""


def need_findings(log: CheckedLog, needs: Iterable[str], others: Sequence[Finding]) -> tuple[Finding, ...]:
    """List the needs that a log does not meet: refused if no joint serves, flagged for joints that do not.

    Of what checks found, the `others`, some uses bear less.
    """
    found: list[Finding] = []
    for name in needs:
        need = NEEDS[check_choice("need", name, list(NEEDS))]
        # what the use does not bear, although others do
        flagged = [finding for finding in others if finding.verdict == "flagged" and finding.check in need.sound]
        flaws = [_refuse(name, f"For {name}: {finding.message}", finding.columns) for finding in flagged]
        met = Finding(check=f"need_{name}", verdict="ok", message=f"The log has what {name} needs.")
        found += _columns(log, name, need) or flaws or _coverage(log, name, need) or [met]
    return tuple(found)


def _columns(log: CheckedLog, name: str, need: Need) -> list[Finding]:
    absent = [family for family in need.columns if not log.recording.has(family)]
    if absent:
        return [_refuse(name, f"{', '.join(absent)} is missing, {name} needs it ({need.why}). Log it.", tuple(absent))]
    if need.any_of and not any(log.recording.has(family) for family in need.any_of):
        return [_refuse(name, f"{' or '.join(need.any_of)} is missing, {name} needs one ({need.why}). Log it.")]
    if need.torque and log.recording.header.torque_semantics == "unspecified":
        text = (
            f"header torque_semantics is 'unspecified', {name} needs to know it ({need.why}). Say what the torque is."
        )
        return [_refuse(name, text, ("motor.effort",))]
    return []


def _refuse(name: str, message: str, columns: tuple[str, ...] = ()) -> Finding:
    return Finding(check=f"need_{name}", verdict="refused", message=message, columns=columns)


def _coverage(log: CheckedLog, name: str, need: Need) -> list[Finding]:
    short = np.zeros(len(log.joints), dtype=np.bool_)
    texts = []
    for figure, least in need.least.items():
        try:
            values = figures(log, figure)
        except NotJudgedError as reason:
            return [_refuse(name, f"{figure} is not known: {reason}; {name} needs it ({need.why}).")]
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
        return [_refuse(name, message)]
    return [Finding(check=f"need_{name}", verdict="flagged", message=message, joint=joint) for joint in joints]
