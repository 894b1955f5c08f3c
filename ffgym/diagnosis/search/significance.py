"""Significance of a cause: the variance that it explains where it acts, and whether that suffices to adopt it."""

import numpy as np

from ffgym.diagnosis.fit.fit import (
    ExplainedVariance,
    Fit,
    Loudness,
    compute_explained,
    find_touched,
    loudness,
    subtract_nuisances,
)
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.fit.problem import FitProblem, is_parameter_of
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.search.rounds import ScoredFit
from ffgym.diagnosis.settings import settings


def find_shapes_at_limit(problem: FitProblem, fit: Fit) -> tuple[tuple[Hypothesis, str], ...]:
    """Find causes with shapes that the fit moved to the end of their plausible range, if they matter to the log."""
    limits = settings().significance
    found, at = [], 0
    for hypothesis in fit.hypotheses:
        for free in hypothesis.list_free():
            p, column = hypothesis.kind.parameters()[free.name], fit.columns[at]
            at += 1
            near = limits.at_range_end * (p.high - p.low)
            is_shape = p.role == "shape" or (p.role == "cycles" and not p.is_looked_for)
            if not is_shape or p.low + near < free.value < p.high - near or free.value == p.default:
                continue
            # energy of the column, in energies of the noise of a row
            if (
                sum(float(np.sum((problem.weights[key] * rows) ** 2)) for key, rows in column.items())
                > limits.seen_shape
            ):
                found.append((hypothesis, free.name))
    return tuple(found)


def compute_explained_by_newest(
    problem: FitProblem, before: ScoredFit, after: ScoredFit, nominal: ScoredFit | None = None
) -> ExplainedVariance:
    """Compute the variance that the newest cause explains where it acts, by fits to all rows.

    Beyond what inexact causes before it would leave, if the `nominal` model is given, from which those were taken; but
    another wave of one of them names nothing new.
    """
    limits = settings().significance
    own = after.fit.columns[-len(after.hypothesis.list_free()) :]
    loud, then = (loudness(problem, subtract_nuisances(problem, one.fit)) for one in (before, after))
    # what inexact causes before it, leaks between joints and fitted numbers may leave
    allowed = None
    if nominal is not None:
        first = loudness(problem, subtract_nuisances(problem, nominal.fit))
        is_wave = any(known.key == after.hypothesis.key for known in before.fit.hypotheses)
        inexact = 0.0 if is_wave else limits.inexact
        leaks: dict[Channel, float] = {}  # what the loudest component of a channel may leave in any other
        for (channel, _), value in loud.items():
            leaks[channel] = max(leaks.get(channel, 0.0), limits.leaks * (value - 1.0))
        allowed = {
            key: max(inexact * (first[key] - value), leaks[key[0]], problem.inexact(key)) for key, value in loud.items()
        }
    where = find_touched(problem, list(own))
    if allowed is not None and not _exceeds_allowance(loud, where, allowed):
        # a channel with little noise is loud with what a cause before left; others may hear this one all the same
        beside = find_touched(problem, list(own), by_channel=True) - where
        where = beside if _exceeds_allowance(loud, beside, allowed) else where
    return compute_explained(loud, then, where, allowed)


def _exceeds_allowance(loud: Loudness, where: set[tuple[Channel, int]], allowed: Loudness) -> bool:
    """Tell whether any of some components has more above the noise than is allowed for."""
    return any(loud[key] - 1.0 > allowed[key] for key in where)


def is_significant(problem: FitProblem, nominal: ScoredFit, before: ScoredFit, after: ScoredFit, chance: float) -> bool:
    """Tell whether a cause explains enough of what is left above the noise, and holds on rows that were left out.

    Args:
        problem: the log.
        nominal: the model without causes.
        before: the model without this cause.
        after: the model with it.
        chance: energy that candidates remove by chance from rows that were left out, at most.
    """
    limits = settings().significance
    if after.hypothesis.is_unphysical or is_within_prior(problem, after.hypothesis):
        return False
    # explained variance where it acts; a cause of the whole machine has a witness in each component
    gone, held_out = compute_explained_by_newest(problem, before, after, nominal), before.rss - after.rss
    witnesses = 1 if after.hypothesis.joint else max(gone.n_loud, 1)
    explains = gone.of_excess > limits.explains / np.sqrt(witnesses) and gone.of_all > limits.floor
    # below the noise floor it must stand out by its share of all, and on rows left out
    is_clear = (held_out > limits.clear * chance and gone.of_all > limits.mostly) or (
        len(after.hypothesis.list_free()) == 1 and held_out > limits.clearer * chance and gone.of_all > limits.explains
    )
    # and noise there must be mostly of sensors and model, not doubt of single rows
    if gone.excess <= limits.floor and is_clear:
        where = find_touched(problem, list(after.fit.columns[-len(after.hypothesis.list_free()) :]))
        is_clear = min((problem.certain(key) for key in where), default=0.0) > limits.certain
    # above the floor, or clear below it; and as much on held-out rows as in the fit
    is_heard = gone.excess > limits.floor or (is_clear and is_sizeable(after.hypothesis))
    holds = held_out > max(limits.holds * (before.fit.left - after.fit.left), 0.0)
    return holds and explains and is_heard and not _imitates(problem, before, after)


def is_sizeable(cause: Hypothesis) -> bool:
    """Tell whether a size of a cause is a noticeable part of what is plausible."""
    known = cause.kind.parameters()
    sizes = [(number, known[number.name]) for number in cause.list_free() if known[number.name].role == "size"]
    return any(
        abs(number.value - p.neutral) > settings().significance.sizeable * (p.high - p.low) for number, p in sizes
    )


def is_within_prior(problem: FitProblem, cause: Hypothesis) -> bool:
    """Tell whether a cause is a number of the model within the bounds of its prior."""
    n = problem.log.robot.n_joints
    nuisances = {
        nuisance.column.parameter: nuisance for nuisance in problem.nuisances if is_parameter_of(nuisance, cause, n)
    }
    free = cause.list_free()
    if not free or any(number.name not in nuisances for number in free):
        return False
    return all(abs(nuisances[x.name].at + x.value / nuisances[x.name].sigma) <= settings().prior.bound for x in free)


def _imitates(problem: FitProblem, before: ScoredFit, after: ScoredFit) -> bool:
    """Tell whether noise and inexact replays may imitate the newest cause.

    It acts only where clean logs are as loud, with a shape at the end of its range or without a size of note.
    """
    newest = after.hypothesis
    if is_sizeable(newest) and all(one is not newest for one, _ in find_shapes_at_limit(problem, after.fit)):
        return False
    own = after.fit.columns[-len(newest.list_free()) :]
    loud = loudness(problem, subtract_nuisances(problem, before.fit))
    return max((loud[key] for key in find_touched(problem, list(own))), default=0.0) <= settings().significance.quiet


def explains_most(problem: FitProblem, nominal: ScoredFit, now: ScoredFit) -> bool:
    """Tell whether all causes together explain most of the energy above noise where they act."""
    first, then = (loudness(problem, subtract_nuisances(problem, one.fit)) for one in (nominal, now))
    gone = compute_explained(first, then, find_touched(problem, list(now.fit.columns)))
    return max(gone.of_excess, gone.best) >= settings().significance.together
