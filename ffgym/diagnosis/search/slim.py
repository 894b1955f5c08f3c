"""Hypotheses of several sizes without those that rows which were left out do not ask for.

Friction that depends on temperature has three sizes, of Coulomb, breakaway and viscous torque. Where one of them is in
the log, the other two bend around noise, and lose against another effect of a single size that looks alike.
"""

import numpy as np

from ffgym.diagnosis.evidence.priors import Priors
from ffgym.diagnosis.failures import FAILED
from ffgym.diagnosis.fit.fit import Fit, evaluated
from ffgym.diagnosis.fit.refine import refined
from ffgym.diagnosis.fit.setting import Setting
from ffgym.diagnosis.search.found import Tried
from ffgym.diagnosis.search.judge import left_out, scored

_THERE = 1e-6
"""Practical steps from its null value within which a size is there: bounds must lie apart."""


def slimmed(setting: Setting, tried: Tried, like: Fit | None = None) -> Tried:
    """The newest hypothesis without sizes whose absence leaves less on rows that were left out.

    Args:
        setting: the log.
        tried: the newest hypothesis beside others.
        like: a fit of those others, whose tangents serve here.
    """
    while len(sizes := _sizes(tried)) > 1:
        left = {size: _left_without(setting, tried.fit, size) for size in sizes}
        least = min(left, key=left.__getitem__)
        if left[least] >= tried.total:
            break
        *others, newest = tried.fit.hypotheses
        try:
            fewer = scored(setting, refined(setting, evaluated(setting, (*others, newest.without(least)), like), like))
        except FAILED:
            break
        if fewer.total >= tried.total:
            break
        tried = fewer
    return tried


def _sizes(tried: Tried) -> list[str]:
    """Sizes of the newest hypothesis that are fitted."""
    known = tried.hypothesis.kind.parameters()
    return list(dict.fromkeys(free.name for free in tried.hypothesis.free() if known[free.name].role == "size"))


def _left_without(setting: Setting, fit: Fit, size: str) -> float:
    """Energy on rows that were left out with one size at its null value, by slopes."""
    free, known = fit.hypotheses[-1].free(), fit.hypotheses[-1].kind.parameters()
    first = len(fit.priors.low) - len(free)
    low, high = fit.priors.low.copy(), fit.priors.high.copy()
    for i, number in enumerate(free):
        if number.name == size:
            null = (known[size].neutral - number.value) / number.step
            low[first + i], high[first + i] = null - _THERE, null + _THERE
    priors = Priors(precision=fit.priors.precision, low=low, high=high)
    return float(np.sum(left_out(setting, fit, priors)))
