"""What a cause is worth: how much of what it acts on it removes, and whether that is enough."""

import numpy as np

from ffgym.diagnosis.fit.fit import Fit, Loudness, Removed, loudness, removed, touched, without_calibration
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.fit.setting import Setting, is_number_of
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.search.found import Tried
from ffgym.diagnosis.settings import settings


def stretched(setting: Setting, fit: Fit) -> tuple[tuple[Hypothesis, str], ...]:
    """Causes with shapes that the fit moved to the end of their plausible range, where they change what is seen."""
    limits = settings().significance
    found, at = [], 0
    for hypothesis in fit.hypotheses:
        for free in hypothesis.free():
            p, column = hypothesis.kind.parameters()[free.name], fit.columns[at]
            at += 1
            near = limits.at_range_end * (p.high - p.low)
            is_shape = p.role == "shape" or (p.role == "cycles" and not p.is_looked_for)
            if not is_shape or p.low + near < free.value < p.high - near or free.value == p.default:
                continue
            # energy of the column, in energies of the noise of a row
            if (
                sum(float(np.sum((setting.weights[key] * rows) ** 2)) for key, rows in column.items())
                > limits.seen_shape
            ):
                found.append((hypothesis, free.name))
    return tuple(found)


def removed_by(setting: Setting, before: Tried, after: Tried, nominal: Tried | None = None) -> Removed:
    """What the newest cause removes where it acts, by fits to all rows.

    Beyond what inexact causes before it would leave, if the `nominal` model is given, from which those were taken; but
    another wave of one of them names nothing new.
    """
    limits = settings().significance
    own = after.fit.columns[-len(after.hypothesis.free()) :]
    loud, then = (loudness(setting, without_calibration(setting, one.fit)) for one in (before, after))
    allowed = None
    if nominal is not None:
        first = loudness(setting, without_calibration(setting, nominal.fit))
        is_wave = any(known.place == after.hypothesis.place for known in before.fit.hypotheses)
        inexact = 0.0 if is_wave else limits.inexact
        leaks: dict[Channel, float] = {}  # what the loudest component of a channel may leave in any other
        for (channel, _), value in loud.items():
            leaks[channel] = max(leaks.get(channel, 0.0), limits.leaks * (value - 1.0))
        allowed = {
            key: max(inexact * (first[key] - value), leaks[key[0]], setting.inexact(key)) for key, value in loud.items()
        }
    where = touched(setting, list(own))
    if allowed is not None and not _is_heard(loud, where, allowed):
        # a channel with little noise is loud with what a cause before left; others may hear this one all the same
        beside = touched(setting, list(own), by_channel=True) - where
        where = beside if _is_heard(loud, beside, allowed) else where
    return removed(loud, then, where, allowed)


def _is_heard(loud: Loudness, where: set[tuple[Channel, int]], allowed: Loudness) -> bool:
    """Whether any of some components has more above the noise than is allowed for."""
    return any(loud[key] - 1.0 > allowed[key] for key in where)


def is_worth(setting: Setting, nominal: Tried, before: Tried, after: Tried, chance: float) -> bool:
    """Tell whether a cause explains enough of what is left above the noise, and holds on rows that were left out.

    Args:
        setting: the log.
        nominal: the model without causes.
        before: the model without this cause.
        after: the model with it.
        chance: energy that candidates remove by chance from rows that were left out, at most.
    """
    limits = settings().significance
    if after.hypothesis.is_unphysical or is_known(setting, after.hypothesis):
        return False
    gone, held_out = removed_by(setting, before, after, nominal), before.total - after.total
    witnesses = 1 if after.hypothesis.joint else max(gone.heard, 1)
    explains = gone.of_excess > limits.explains / np.sqrt(witnesses) and gone.of_all > limits.floor
    # below the noise floor it must stand out by its share of all, and on rows left out
    is_clear = (held_out > limits.clear * chance and gone.of_all > limits.mostly) or (
        len(after.hypothesis.free()) == 1 and held_out > limits.clearer * chance and gone.of_all > limits.explains
    )
    # and noise there must be mostly of sensors and model, not doubt of single rows
    if gone.excess <= limits.floor and is_clear:
        where = touched(setting, list(after.fit.columns[-len(after.hypothesis.free()) :]))
        is_clear = min((setting.certain(key) for key in where), default=0.0) > limits.certain
    is_heard = gone.excess > limits.floor or (is_clear and is_sizeable(after.hypothesis))
    holds = held_out > max(limits.holds * (before.fit.left - after.fit.left), 0.0)
    return holds and explains and is_heard and not _imitates(setting, before, after)


def is_sizeable(cause: Hypothesis) -> bool:
    """Tell whether a size of a cause is a noticeable part of what is plausible."""
    known = cause.kind.parameters()
    sizes = [(number, known[number.name]) for number in cause.free() if known[number.name].role == "size"]
    return any(
        abs(number.value - p.neutral) > settings().significance.sizeable * (p.high - p.low) for number, p in sizes
    )


def is_known(setting: Setting, cause: Hypothesis) -> bool:
    """Whether a cause is a number of the model that is within its calibration."""
    n = setting.log.robot.n_joints
    doubts = {doubt.column.parameter: doubt for doubt in setting.doubts if is_number_of(doubt, cause, n)}
    free = cause.free()
    if not free or any(number.name not in doubts for number in free):
        return False
    return all(abs(doubts[x.name].at + x.value / doubts[x.name].sigma) <= settings().prior.bound for x in free)


def _imitates(setting: Setting, before: Tried, after: Tried) -> bool:
    """Whether the newest cause bends to the end of what is plausible to explain what a clean log may have."""
    if all(hypothesis is not after.hypothesis for hypothesis, _ in stretched(setting, after.fit)):
        return False
    own = after.fit.columns[-len(after.hypothesis.free()) :]
    loud = loudness(setting, without_calibration(setting, before.fit))
    return max((loud[key] for key in touched(setting, list(own))), default=0.0) <= settings().significance.quiet


def explains_most(setting: Setting, nominal: Tried, now: Tried) -> bool:
    """Whether all causes together explain most of what is where they act."""
    first, then = (loudness(setting, without_calibration(setting, one.fit)) for one in (nominal, now))
    gone = removed(first, then, touched(setting, list(now.fit.columns)))
    return max(gone.of_excess, gone.best) >= settings().significance.together
