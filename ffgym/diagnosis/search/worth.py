"""What a cause is worth: how much of what it acts on it removes, and whether that is enough."""

import numpy as np

from ffgym.diagnosis.calibration import BOUND
from ffgym.diagnosis.fit.fit import Fit, Loudness, Removed, loudness, removed, touched, without_calibration
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.fit.setting import Setting, is_number_of
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.search.found import Tried

_AT_END = 1e-3
"""Share of its plausible range within which a shape is at the end of it."""

_SEEN = 10.0
"""Energy of a tenth of a shape's range, in energies of the noise of a row, from which on the log says what it is."""


def stretched(setting: Setting, fit: Fit) -> tuple[tuple[Hypothesis, str], ...]:
    """Causes with shapes that the fit moved to the end of their plausible range, where they change what is seen."""
    found, at = [], 0
    for hypothesis in fit.hypotheses:
        for free in hypothesis.free():
            p, column = hypothesis.kind.parameters()[free.name], fit.columns[at]
            at += 1
            near = _AT_END * (p.high - p.low)
            is_shape = p.role == "shape" or (p.role == "cycles" and not p.is_looked_for)
            if not is_shape or p.low + near < free.value < p.high - near or free.value == p.default:
                continue
            # energy of the column, in energies of the noise of a row
            if sum(float(np.sum((setting.weights[key] * rows) ** 2)) for key, rows in column.items()) > _SEEN:
                found.append((hypothesis, free.name))
    return tuple(found)


EXPLAINS = 0.25
"""Share of what is left above the noise, where it acts, that a cause of one joint must remove to be adopted. One of
the machine as a whole explains all components by the same numbers, and each of them is a witness: of n, the share is
less by the root of n."""

FLOOR = 0.05
"""Share of all energy where it acts, noise included, that must lie above the noise, and that a cause must remove."""

TOGETHER = 0.5
"""Share of what is above the noise in the component that they explain best, among those with much above it, that all
causes together must remove, else none of them is one: something else is there, which each of them imitates a little."""

INEXACT = 0.1
"""Share of what the causes before removed from a component that another one must remove beyond: no equation is exact,
and what is left of a cause that was adopted in another form is no cause of its own. What may be left of one that is
named."""

QUIET = 1.5
"""Energy in units of the noise's that clean logs may have in a component: causes may leave it, and none whose shape is
at the end of its range is adopted for it."""

LEAKS = 0.02
"""Share of what is still above the noise in the loudest component of a channel that a cause must remove beyond, in any
of them: what ails one joint shows in others a little, through springs and calibration, until it is explained; chosen: a
seventh of the amplitude."""

HOLDS = 0.25
"""Share of what a cause removes in a fit to all rows that it must remove from rows that it was not fitted to. Right
ones of development exams hold nearly all of it; one that bends around what another equation leaves, next to nothing."""

CLEAR = 6.0
"""Held-out energy over the largest that chance reaches from which on a cause may stand below the noise floor: the floor
allows for what may be there, and need not be. Of development exams, none of 200 clean logs comes to more with MOSTLY of
what is there; right causes do with 7 and more."""

MOSTLY = 0.6
"""Share of all energy where it acts that a cause below the noise floor must remove: what is left there is no noise, but
what else the model lacks, and a cause that removes less of it is a guess. Of development exams, a clean log comes to
0.45 and a wrong cause to 0.52, by friction that falls with speed where sensors are quiet."""

CLEARER = 15.0
"""The same as CLEAR for a cause of one number, which has no shape to bend around what the model lacks: with that much,
EXPLAINS of what is there is enough. A right cause of a development exam comes to 22 with 0.45 of what is there."""

CERTAIN = 0.25
"""Share of the energy of noise that is not doubt of single rows from which on a cause may stand below the floor: what
rows are doubted by may be there, and any cause would bend around it; chosen: three quarters of usual logs are."""

SIZEABLE = 0.02
"""Share of the plausible range of a size that one of a cause below the floor must have: of less, any simulation has
some, by its steps; chosen: servo gains that are a thousandth off stand out from logs without noise."""

KNOWN = BOUND
"""Standard deviations from what is described within which a number of the model is what it is said to be, and no
cause: where joints swing, slopes of calibration do not explain what the number itself does."""


def removed_by(setting: Setting, before: Tried, after: Tried, nominal: Tried | None = None) -> Removed:
    """What the newest cause removes where it acts, by fits to all rows.

    Beyond what inexact causes before it would leave, if the `nominal` model is given, from which those were taken; but
    another wave of one of them names nothing new.
    """
    own = after.fit.columns[-len(after.hypothesis.free()) :]
    loud, then = (loudness(setting, without_calibration(setting, one.fit)) for one in (before, after))
    allowed = None
    if nominal is not None:
        first = loudness(setting, without_calibration(setting, nominal.fit))
        is_wave = any(known.place == after.hypothesis.place for known in before.fit.hypotheses)
        inexact = 0.0 if is_wave else INEXACT
        leaks: dict[Channel, float] = {}  # what the loudest component of a channel may leave in any other
        for (channel, _), value in loud.items():
            leaks[channel] = max(leaks.get(channel, 0.0), LEAKS * (value - 1.0))
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
    if after.hypothesis.is_unphysical or is_known(setting, after.hypothesis):
        return False
    gone, held_out = removed_by(setting, before, after, nominal), before.total - after.total
    witnesses = 1 if after.hypothesis.joint else max(gone.heard, 1)
    explains = gone.of_excess > EXPLAINS / np.sqrt(witnesses) and gone.of_all > FLOOR
    # below the noise floor it must stand out by its share of all, and on rows left out
    is_clear = (held_out > CLEAR * chance and gone.of_all > MOSTLY) or (
        len(after.hypothesis.free()) == 1 and held_out > CLEARER * chance and gone.of_all > EXPLAINS
    )
    # and noise there must be mostly of sensors and model, not doubt of single rows
    if gone.excess <= FLOOR and is_clear:
        where = touched(setting, list(after.fit.columns[-len(after.hypothesis.free()) :]))
        is_clear = min((setting.certain(key) for key in where), default=0.0) > CERTAIN
    is_heard = gone.excess > FLOOR or (is_clear and is_sizeable(after.hypothesis))
    holds = held_out > max(HOLDS * (before.fit.left - after.fit.left), 0.0)
    return holds and explains and is_heard and not _imitates(setting, before, after)


def is_sizeable(cause: Hypothesis) -> bool:
    """Tell whether a size of a cause is a noticeable part of what is plausible."""
    known = cause.kind.parameters()
    sizes = [(number, known[number.name]) for number in cause.free() if known[number.name].role == "size"]
    return any(abs(number.value - p.neutral) > SIZEABLE * (p.high - p.low) for number, p in sizes)


def is_known(setting: Setting, cause: Hypothesis) -> bool:
    """Whether a cause is a number of the model that is within its calibration."""
    n = setting.log.robot.n_joints
    doubts = {doubt.column.parameter: doubt for doubt in setting.doubts if is_number_of(doubt, cause, n)}
    free = cause.free()
    if not free or any(number.name not in doubts for number in free):
        return False
    return all(abs(doubts[x.name].at + x.value / doubts[x.name].sigma) <= KNOWN for x in free)


def _imitates(setting: Setting, before: Tried, after: Tried) -> bool:
    """Whether the newest cause bends to the end of what is plausible to explain what a clean log may have."""
    if all(hypothesis is not after.hypothesis for hypothesis, _ in stretched(setting, after.fit)):
        return False
    own = after.fit.columns[-len(after.hypothesis.free()) :]
    loud = loudness(setting, without_calibration(setting, before.fit))
    return max((loud[key] for key in touched(setting, list(own))), default=0.0) <= QUIET


def explains_most(setting: Setting, nominal: Tried, now: Tried) -> bool:
    """Whether all causes together explain most of what is where they act."""
    first, then = (loudness(setting, without_calibration(setting, one.fit)) for one in (nominal, now))
    gone = removed(first, then, touched(setting, list(now.fit.columns)))
    return max(gone.of_excess, gone.best) >= TOGETHER
