"""Torques that are some multiple of what they should be: currents, whose torque constant is unknown."""

from collections.abc import Sequence

import numpy as np

from ffgym.logs.quality.wiring.found import Found
from ffgym.logs.quality.wiring.hypothesis import Hypothesis, effort_groups
from ffgym.logs.quality.wiring.model import KNOWN_MASSES
from ffgym.logs.quality.wiring.score import TORQUE, Lefts, Scorer
from ffgym.recordings.rewiring import Rewiring

_FACTOR = 1.8
"""Factor of all parts of a torque from which on it is no torque: masses are known better, and a payload that nobody
told of acts on gravity more than on rotors and friction."""

_UNCLEAN = 1.3
"""Factor of the torque of a joint that is no torque constant next to 1, where most joints show that there are some."""

_SHARE, _EXPLAINED = 0.05, 0.02
"""Share of a torque that is left as given at least, and with its factor at most, where masses are known to 60 %."""


_ALONE = 0.004
"""The same of few joints, on which a heavy payload acts more than on others."""


def with_currents(scorer: Scorer, wiring: Rewiring, found: Sequence[Found]) -> tuple[Rewiring, list[Found]]:
    """Reading and mistakes, and beside them that torques are currents, if that explains them."""
    if not scorer.samples.has(TORQUE) or scorer.samples.header.torque_semantics == "unspecified":
        return wiring, [*found]
    strengths = {j: scorer.strength(wiring, j) for j in scorer.judged(wiring)}
    factors = {j: s for j, s in strengths.items() if s > 0 and abs(np.log(s)) > np.log(_FACTOR)}
    if not factors:
        return wiring, [*found]
    before = scorer.torques(wiring, 0.0, KNOWN_MASSES)
    candidates = [_scaled(group, factors) for group in effort_groups(scorer.samples) if TORQUE in group]
    best = min(candidates, key=lambda one: scorer.left_at_all(one.mended(wiring, scorer.n)) + one.cost)
    after = scorer.torques(best.mended(wiring, scorer.n), 0.0, KNOWN_MASSES)
    telling = {j for j in factors if before[TORQUE, j] > _SHARE and after[TORQUE, j] < _EXPLAINED}
    if not telling:
        return wiring, [*found]
    if len(telling) <= len(strengths) / 2:
        factors = {j: factors[j] for j in telling if after[TORQUE, j] < _ALONE}
        if not factors:
            return wiring, [*found]
    else:  # all of them, also where friction of an unknown size explains the factor as well
        factors = {j: s for j, s in strengths.items() if s > 0 and abs(np.log(s)) > np.log(_UNCLEAN)}
    current = _scaled(best.families, factors)
    one = Found(hypothesis=current, gain=_gain(before, after), before=before, after=after)
    return current.mended(wiring, scorer.n), [*found, one]


def _scaled(families: tuple[str, ...], factors: dict[int, float]) -> Hypothesis:
    return Hypothesis(kind="current", families=families, parts=tuple(factors), factors=tuple(factors.values()))


def _gain(before: Lefts, after: Lefts) -> float:
    return sum(float(np.log(max(left, 1e-9) / max(after[key], 1e-9))) for key, left in before.items())
