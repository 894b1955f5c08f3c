"""Causes of a search when one more was adopted: all are fitted again, and what is not needed any more is dropped."""

from collections.abc import Sequence

from ffgym.diagnosis.failures import FAILED
from ffgym.diagnosis.fit.fit import evaluated
from ffgym.diagnosis.fit.hypothesis import Hypothesis, machine_with
from ffgym.diagnosis.fit.refine import polished, refined
from ffgym.diagnosis.fit.setting import Setting
from ffgym.diagnosis.search.found import Tried
from ffgym.diagnosis.search.judge import judged_with, scored

NEEDED = 0.05
"""Share of the energy that a cause must keep away beside the others, else it is dropped."""

CLEARLY_NEEDED = 1.0
"""The same where others are fitted by slopes alone, from which on they are not fitted by replaying; chosen: slopes are
that far off for none but springs that swing."""

QUIET = 1.05
"""Energy left, in units of the noise's, from which on a fit may gain from being finer."""


def refitted(setting: Setting, adopted: Tried) -> Tried:
    """The adopted cause, fitted with tangents of all, and more finely if there is anything left to explain."""
    if len(adopted.fit.hypotheses) > 1:
        try:
            adopted = judged_with(setting, adopted.fit.hypotheses, begun=True)
        except FAILED:
            return adopted  # with the tangents that it has
    if adopted.fit.left < QUIET * float(adopted.fit.evidence.rows.sum()):
        return adopted
    finer = polished(setting, adopted.fit)
    return adopted if finer is adopted.fit else scored(setting, finer)


def _without(setting: Setting, now: Tried, others: Sequence[Hypothesis]) -> Tried | None:
    """The other causes alone; None if they do not make up for the one that is left out."""
    begun = evaluated(setting, others, now.fit)
    if scored(setting, begun).total > now.total * (1 + CLEARLY_NEEDED):
        return None
    fewer = scored(setting, refined(setting, begun, now.fit, roughly=True))
    if fewer.total > now.total * (1 + NEEDED):
        return None
    return judged_with(setting, fewer.fit.hypotheses, now.fit, begun=True)


def without_needless(setting: Setting, now: Tried) -> Tried:
    """Drop causes that the others make up for; what slopes say is enough where they come nowhere near."""
    for i in range(len(now.fit.hypotheses) - 1):
        others = [h for k, h in enumerate(now.fit.hypotheses) if k != i]
        if machine_with(setting.nominal, others) is None:
            continue
        try:
            fewer = _without(setting, now, others)
        except FAILED:
            continue  # a machine without it cannot be: it is needed
        if fewer is not None:
            return without_needless(setting, fewer)
    return now
