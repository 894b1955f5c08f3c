"""Search for the mistakes that explain a set of logs, one after the other, the most telling first."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from ffgym.logs.quality.wiring.currents import with_currents
from ffgym.logs.quality.wiring.found import Found
from ffgym.logs.quality.wiring.hypothesis import Hypothesis, delays, hypotheses, touches_motion, zeros
from ffgym.logs.quality.wiring.score import FLOOR, TOOL_FLOOR, TORQUE, Channel, Lefts, Scorer
from ffgym.recordings.rewiring import Rewiring

_GAIN = 1.5
"""Least gain, in logarithms of the share that is left, summed over all signals: wrong friction, loads and springs gain
less by any mistake in wiring."""

_SHARE = 0.05
"""Share of a signal that the given reading must leave in one of those that a mistake explains: less is physics."""

_EXPLAINED = 0.35
"""Largest share that the mended reading may leave in a signal that it explains."""

_EXPLAINED_BY_RATE = 0.05
"""The same of another clock, which acts on inertia as an unknown mass does."""

_TELLING = 8.0
"""How much more the given reading leaves than the mended one where that is below `_SHARE`: of paths of the tool, in
which joints show that turn little."""

_LEAST_DELAY, _LEAST_ROWS = 0.04, 1.6
"""Delay [s], or in rows if those are longer, from which on a torque is of another time: no servo is stable with it, and
recorders put a column off by a row and a half at most; less is a cause of a diagnosis."""

_ALIKE = 0.5
"""Gain by which two mistakes are alike, so that what they leave below the floor decides."""

_MOST = 8
"""Mistakes after which a set of logs is not wired wrongly but something else."""


def search(scorer: Scorer) -> tuple[Rewiring, list[Found]]:
    """The corrected reading, and the mistakes in the given one."""
    wiring = Rewiring()
    found: list[Found] = []
    fixed = [*hypotheses(scorer.samples, scorer.robot)]
    while len(found) < _MOST:
        best = _best(scorer, wiring, fixed)
        if best is None:
            return with_currents(scorer, wiring, found)
        found.append(best)
        wiring = best.hypothesis.mended(wiring, scorer.n)
    return Rewiring(), []


def _best(scorer: Scorer, wiring: Rewiring, fixed: list[Hypothesis]) -> Found | None:
    """The mistake that explains most, if it explains enough."""
    before = scorer.all(wiring)
    if sum(np.log(left / _floor(key)) for key, left in before.items()) < _GAIN:
        return None
    least = max(_LEAST_DELAY, _LEAST_ROWS * scorer.samples.period * wiring.clock) / wiring.clock
    considered: list[Found] = []
    for candidates in (fixed, delays(scorer.samples, scorer.n, least), _zeros(scorer)):
        considered += _improved(scorer, wiring, before, candidates, considered)
    if not considered:
        return None
    best = _clearest(scorer, wiring, considered)
    if best.hypothesis.kind not in ("zero", "delay"):
        return best
    return replace(best, hypothesis=_refined(scorer, wiring, best.hypothesis, least))


def _zeros(scorer: Scorer) -> Iterator[Hypothesis]:
    return zeros(scorer.samples, scorer.robot)


def _improved(
    scorer: Scorer, wiring: Rewiring, before: Lefts, candidates: Iterable[Hypothesis], known: list[Found]
) -> list[Found]:
    """Candidates that explain enough, and about as much as the best; those that cannot are not computed."""
    possible = []
    for candidate in candidates:
        mended = candidate.mended(wiring, scorer.n)
        if candidate.kind == "clock":
            cheap = scorer.cheap(mended)
        else:
            cheap = scorer.changed(before, mended, candidate.families, candidate.parts)
        possible.append((_bound(before, cheap, candidate) - candidate.cost, candidate, mended, cheap))
    found: list[Found] = []
    best = max((one.worth for one in known), default=_GAIN + _ALIKE)
    for bound, candidate, mended, cheap in sorted(possible, key=lambda entry: -entry[0]):
        if bound <= best - _ALIKE:
            break
        sure = cheap | scorer.tools(mended)
        if _bound(before, sure, candidate) - candidate.cost <= best - _ALIKE:
            continue
        after = sure | scorer.torques(mended)
        one = Found(hypothesis=candidate, gain=_gain(before, after), before=before, after=after)
        if one.worth > best - _ALIKE and _convincing(one):
            found.append(one)
            best = max(best, one.worth)
    return found


def _clearest(scorer: Scorer, wiring: Rewiring, considered: list[Found]) -> Found:
    """Of mistakes that explain next to everything the one that leaves least, however little that is."""
    best = max(one.worth for one in considered)
    alike = [one for one in considered if one.worth > best - _ALIKE]
    if len(alike) == 1:
        return alike[0]
    return min(alike, key=lambda one: scorer.left_at_all(one.hypothesis.mended(wiring, scorer.n)) + one.hypothesis.cost)


def _floor(channel: Channel) -> float:
    return TOOL_FLOOR if channel[0].startswith("tcp") else FLOOR


def _gain(before: Lefts, after: Lefts) -> float:
    return sum(float(np.log(left / after.get(key, left))) for key, left in before.items())


def _bound(before: Lefts, cheap: Lefts, candidate: Hypothesis) -> float:
    """Largest gain that a mistake can have, when its cheap signals are known."""
    gain = sum(float(np.log(before[key] / left)) for key, left in cheap.items() if key in before)
    for key, left in before.items():
        if key not in cheap and _may_change(key, candidate):
            gain += float(np.log(left / _floor(key)))
    return gain


def _may_change(channel: Channel, candidate: Hypothesis) -> bool:
    family, j = channel
    if touches_motion(candidate):
        return True
    if family == TORQUE:
        return TORQUE in candidate.families and j in candidate.parts
    return family in candidate.families or (family.startswith("tcp_") and "reference.position" in candidate.families)


def _convincing(found: Found) -> bool:
    """Whether a signal that the given reading does not explain is explained by the mended one."""
    key = found.telling
    before, after = found.before[key], found.after.get(key, found.before[key])
    if after > (_EXPLAINED_BY_RATE if found.hypothesis.kind == "clock" else _EXPLAINED):
        return False
    return before > _SHARE or before > _TELLING * after


def _refined(scorer: Scorer, wiring: Rewiring, found: Hypothesis, least: float) -> Hypothesis:
    """The delay or zero near the one that was found at which least is left, however little that is."""
    candidates = [*_near(found, scorer.samples.shortest, least)]
    left = [scorer.left_at_all(candidate.mended(wiring, scorer.n)) for candidate in candidates]
    return candidates[int(np.argmin(left))]


def _near(found: Hypothesis, dt: float, least: float) -> Iterator[Hypothesis]:
    """Zeros about one, or delays of whole rows: a logger is late by rows."""
    if found.kind == "zero":
        yield from (replace(found, amount=float(found.amount * factor)) for factor in np.linspace(0.75, 1.3, 111))
        return
    rows = max(round(abs(found.amount) / 4 / dt), 2)
    nearest = round(found.amount / dt)
    amounts = [dt * k for k in range(nearest - rows, nearest + rows + 1)]
    yield from (replace(found, amount=amount) for amount in amounts if abs(amount) >= least)
