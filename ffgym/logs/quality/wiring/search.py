"""Search for the mistakes that explain a set of logs, one after the other, the most telling first."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ffgym.logs.quality.wiring.hypothesis import (
    Found,
    Mistake,
    WiringHypothesis,
    delays,
    effort_groups,
    hypotheses,
    mistake_of,
    zeros,
)
from ffgym.logs.quality.wiring.model import KNOWN_MASSES, regressor_of
from ffgym.logs.quality.wiring.sample import WiringSamples
from ffgym.logs.quality.wiring.score import FLOOR, POSITION, TOOL_FLOOR, TORQUE, Channel, Lefts, Scorer
from ffgym.recordings import Recording
from ffgym.recordings.rewiring import Rewiring
from ffgym.robot import RobotDescription

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
"""Factor by which the given reading leaves more than the mended one where that is below `_SHARE`: of paths of the tool,
in which joints show that turn little."""

LEAST_DELAY, LEAST_ROWS = 0.04, 1.6
"""Delay [s], or in rows if those are longer, from which on a torque is of another time: no servo is stable with it, and
recorders put a column off by a row and a half at most; less is a cause of a diagnosis."""

_ALIKE = 0.5
"""Gain by which two mistakes are alike, so that what they leave below the floor decides."""

_MOST = 8
"""Mistakes after which a set of logs is not wired wrongly but something else."""

_FACTOR = 1.8
"""Factor of all parts of a torque from which on it is no torque: masses are known better, and a payload that nobody
told of acts on gravity more than on rotors and friction."""

_UNCLEAN = 1.3
"""Factor of the torque of a joint that is no torque constant next to 1, where most joints show that there are some."""

_CURRENT_SHARE, _CURRENT_EXPLAINED = 0.05, 0.02
"""Share of a torque that is left as given at least, and with its factor at most, where masses are known to 60 %."""

_ALONE = 0.004
"""The same of few joints, on which a heavy payload acts more than on others."""

_ROWS = 100
"""Rows that a recording needs to take part."""

_RATIO = 0.2
"""Relative difference of gear ratios from which on logs are of another robot."""


def search(scorer: Scorer) -> tuple[Rewiring, list[Found]]:
    """The corrected reading, and the mistakes in the given one."""
    wiring = Rewiring()
    found: list[Found] = []
    fixed = [*hypotheses(scorer.samples, scorer.n)]
    while len(found) < _MOST:
        best = _best(scorer, wiring, fixed)
        if best is None:
            return with_currents(scorer, wiring, found)
        found.append(best)
        wiring = best.hypothesis.correct(wiring, scorer.n)
    return Rewiring(), []


def _best(scorer: Scorer, wiring: Rewiring, fixed: list[WiringHypothesis]) -> Found | None:
    """The mistake that explains most, if it explains enough."""
    before = scorer.all(wiring)
    if sum(np.log(left / _floor(key)) for key, left in before.items()) < _GAIN:
        return None
    least = max(LEAST_DELAY, LEAST_ROWS * scorer.samples.period * wiring.clock) / wiring.clock
    considered: list[Found] = []
    for candidates in (fixed, delays(scorer.samples, scorer.n, least), zeros(scorer.samples, scorer.robot)):
        considered += _improve(scorer, wiring, before, candidates, considered)
    if not considered:
        return None

    def left(candidate: WiringHypothesis) -> float:
        return scorer.left_at_all(candidate.correct(wiring, scorer.n))

    # of mistakes that explain next to everything the one that leaves least, however little that is
    most = max(one.worth for one in considered)
    alike = [one for one in considered if one.worth > most - _ALIKE]
    best = min(alike, key=lambda one: left(one.hypothesis) + one.hypothesis.cost) if len(alike) > 1 else alike[0]
    if best.hypothesis.kind not in ("zero", "delay"):
        return best
    return replace(best, hypothesis=min(_near(best.hypothesis, scorer.samples.shortest, least), key=left))


def _improve(
    scorer: Scorer, wiring: Rewiring, before: Lefts, candidates: Iterable[WiringHypothesis], known: list[Found]
) -> list[Found]:
    """Candidates that explain enough, and about as much as the best; those that cannot are not computed."""
    possible = []
    for candidate in candidates:
        mended = candidate.correct(wiring, scorer.n)
        if candidate.kind == "clock":
            cheap = scorer.cheap(mended)
        else:
            cheap = scorer.update(before, mended, candidate.families, candidate.parts)
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
        gain = sum(float(np.log(left / after.get(key, left))) for key, left in before.items())
        one = Found(hypothesis=candidate, gain=gain, before=before, after=after)
        if one.worth > best - _ALIKE and _convincing(one):
            found.append(one)
            best = max(best, one.worth)
    return found


def _floor(channel: Channel) -> float:
    return TOOL_FLOOR if channel[0].startswith("tcp") else FLOOR


def _bound(before: Lefts, cheap: Lefts, candidate: WiringHypothesis) -> float:
    """Largest gain that a mistake can have, when its cheap signals are known."""
    gain = sum(float(np.log(before[key] / left)) for key, left in cheap.items() if key in before)
    changed = candidate.families
    for (family, j), left in before.items():
        if family == TORQUE:
            may_change = TORQUE in changed and j in candidate.parts
        else:
            may_change = family in changed or (family.startswith("tcp_") and "reference.position" in changed)
        # a mistake of the motion, or of its clock, changes all that the arm is computed for
        may_change |= candidate.kind == "clock" or POSITION in changed
        if may_change and (family, j) not in cheap:
            gain += float(np.log(left / _floor((family, j))))
    return gain


def _convincing(found: Found) -> bool:
    """Tell whether a signal that the given reading does not explain is explained by the corrected one."""
    key = found.telling
    before, after = found.before[key], found.after.get(key, found.before[key])
    if after > (_EXPLAINED_BY_RATE if found.hypothesis.kind == "clock" else _EXPLAINED):
        return False
    return before > _SHARE or before > _TELLING * after


def _near(found: WiringHypothesis, dt: float, least: float) -> Iterator[WiringHypothesis]:
    """Zeros about one, or delays of whole rows: a logger is late by rows."""
    if found.kind == "zero":
        yield from (replace(found, amount=float(found.amount * factor)) for factor in np.linspace(0.75, 1.3, 111))
        return
    rows = max(round(abs(found.amount) / 4 / dt), 2)
    nearest = round(found.amount / dt)
    amounts = [dt * k for k in range(nearest - rows, nearest + rows + 1)]
    yield from (replace(found, amount=amount) for amount in amounts if abs(amount) >= least)


def with_currents(scorer: Scorer, wiring: Rewiring, found: Sequence[Found]) -> tuple[Rewiring, list[Found]]:
    """Reading and mistakes, and beside them that torques are currents, if that explains them."""
    if not scorer.samples.has(TORQUE) or scorer.samples.header.torque_semantics == "unspecified":
        return wiring, [*found]
    strengths = {j: scorer.strength(wiring, j) for j in scorer.list_judged(wiring)}
    factors = {j: s for j, s in strengths.items() if s > 0 and abs(np.log(s)) > np.log(_FACTOR)}
    if not factors:
        return wiring, [*found]
    before = scorer.torques(wiring, 0.0, KNOWN_MASSES)
    candidates = [_scale(group, factors) for group in effort_groups(scorer.samples) if TORQUE in group]
    best = min(candidates, key=lambda one: scorer.left_at_all(one.correct(wiring, scorer.n)) + one.cost)
    after = scorer.torques(best.correct(wiring, scorer.n), 0.0, KNOWN_MASSES)
    telling = {j for j in factors if before[TORQUE, j] > _CURRENT_SHARE and after[TORQUE, j] < _CURRENT_EXPLAINED}
    if not telling:
        return wiring, [*found]
    if len(telling) <= len(strengths) / 2:
        factors = {j: factors[j] for j in telling if after[TORQUE, j] < _ALONE}
        if not factors:
            return wiring, [*found]
    else:  # all of them, also where friction of an unknown size explains the factor as well
        factors = {j: s for j, s in strengths.items() if s > 0 and abs(np.log(s)) > np.log(_UNCLEAN)}
    current = _scale(best.families, factors)
    one = Found(hypothesis=current, before=before, after=after)
    return current.correct(wiring, scorer.n), [*found, one]


def _scale(families: tuple[str, ...], factors: dict[int, float]) -> WiringHypothesis:
    return WiringHypothesis(kind="current", families=families, parts=tuple(factors), factors=tuple(factors.values()))


@dataclass(frozen=True, kw_only=True)
class Wiring:
    """Mistakes in the wiring of a set of logs, the most telling first, and how their columns should be read."""

    mistakes: tuple[Mistake, ...] = ()
    rewiring: Rewiring = field(default_factory=Rewiring)


def find_wiring(recordings: Sequence[Recording], robot: RobotDescription) -> Wiring:
    """Fit the wiring of recordings of one robot, by what its description explains of their signals.

    Friction, payloads, masses, springs and gears that differ from the description are no mistakes in wiring: they are
    free within what machines have. A mistake is one that is discrete, and without which far more is explained on rows
    that were left out. Without motor positions, or where recordings do not fit the robot or each other, there are none.

    Args:
        recordings: of one robot, with columns that mean the same.
        robot: its description; masses and friction may be typical.
    """
    own, ratios = [r for r in recordings if r.header.joints == robot.joints], robot.drive.gear_ratio
    long = [recording for recording in own if len(recording) >= _ROWS and recording.has(POSITION)]
    fitting = [recording for recording in long if np.allclose(recording.header.gear_ratio, ratios, rtol=_RATIO)]
    meanings = {(h.gear_ratio, h.position_side, h.torque_semantics, h.coupling) for h in (r.header for r in fitting)}
    if len(meanings) != 1:
        return Wiring()
    samples = WiringSamples(fitting)
    if POSITION not in samples.families:
        return Wiring()
    rewiring, found = search(Scorer(samples, regressor_of(robot)))
    ratio = fitting[0].header.gear_ratio
    return Wiring(mistakes=tuple(mistake_of(one, samples, ratio) for one in found), rewiring=rewiring)
