"""Hypotheses fitted to a log by replaying the machine that they make: Gauss-Newton with calibration beside them.

A replay takes steps of its own, follows standing motors within a band, and knows motions through a low-pass. For the
nominal machine that difference is known and taken off every residual; a machine with an effect has another one, which
would be read as a part of the effect.
"""

from collections.abc import Sequence

import numpy as np
import scipy

from ffgym.diagnosis.clean_recordings import make_clean_recordings
from ffgym.diagnosis.computing import FAILED
from ffgym.diagnosis.fit.fit import Fit, add_tangents, compute_rss, evaluate, replay_hypotheses
from ffgym.diagnosis.fit.hypothesis import Hypothesis, move_hypotheses
from ffgym.diagnosis.fit.problem import FitProblem
from ffgym.diagnosis.log import assemble_log
from ffgym.diagnosis.replay import predict, replay
from ffgym.diagnosis.residual_rows import compute_residuals
from ffgym.diagnosis.solving import solve

_ROUNDS = 4
"""Gauss-Newton steps at most."""

_ENOUGH = 0.01
"""Relative gain of energy below which another step is not worth a replay."""

_SIZES = (0.6, 1.0, 1.5, 2.2, 3.3)
"""Multiples of the size of a linear fit at which effects of springs are tried first."""

_FURTHER, _GROWTH = 6, 1.4
"""Times that a larger one is tried where the largest leaves least, and by which factor: to 25 times the linear fit,
which is of a small effect, and sees little of one that grows with the cube."""

_SOUGHT, _FINE = (-0.3, 0.3), 0.005
"""Logarithms of the factors between which a size is sought along a line, and how finely."""

_SMALL = 0.02
"""Change, in practical steps, below which a fit has come to rest."""

_HALVINGS = 3
"""Times that a step is halved if it makes things worse."""


def fit(problem: FitProblem, hypotheses: Sequence[Hypothesis], *, begun: bool = False, like: Fit | None = None) -> Fit:
    """Fit hypotheses to a log, from the values that they have.

    Those of the last one, which is the newest, are of a linear fit, or good already if it has `begun`. Tangents of a
    fit `like` it, of others among them, serve here: they hardly change when one more comes.
    """
    return refine(problem, evaluate(problem, hypotheses if begun else _choose_start(problem, hypotheses), like), like)


def refine(problem: FitProblem, begun: Fit, like: Fit | None = None, *, roughly: bool = False) -> Fit:
    """A fit from where it has `begun`; `roughly` if only what it leaves is asked for, to a per cent."""
    best = begun
    for _ in range(_ROUNDS if begun.hypotheses else 0):
        step, tried = solve(best.equations, np.arange(len(best.priors.low)), best.priors)[best.n_nuisances :], None
        for _ in range(_HALVINGS):
            tried = replay_hypotheses(problem, move_hypotheses(best.hypotheses, step))
            if tried is not None and tried.left < best.left:
                break
            step = 0.3 * step
        if tried is None or tried.left >= best.left:
            break
        gained = 1 - tried.left / best.left
        try:
            best = add_tangents(problem, tried, like)
        except FAILED:
            break  # a machine at the edge of what can be: it stays where slopes were known
        if gained < _ENOUGH and (roughly or float(np.max(np.abs(step))) < _SMALL):
            break
    return best


def polish(problem: FitProblem, found: Fit) -> Fit:
    """A fit with the size of its newest hypothesis sought along a line where it acts on springs, then fitted again.

    There slopes lead to the truth only from very near; a line search needs no slopes.
    """
    if not found.hypotheses or not _on_springs(found.hypotheses[-1]):
        return found
    *others, last = found.hypotheses

    def left(log_factor: float) -> float:
        return compute_rss(problem, [*others, last.scale(float(np.exp(log_factor)))])

    best = scipy.optimize.minimize_scalar(left, bounds=_SOUGHT, method="bounded", options={"xatol": _FINE})
    if not best.fun < found.left:
        return found
    try:
        return fit(problem, [*others, last.scale(float(np.exp(best.x)))], begun=True)
    except FAILED:
        return found


def _on_springs(hypothesis: Hypothesis) -> bool:
    return hypothesis.kind.needs_elasticity and hypothesis.kind.side == "link"


def _choose_start(problem: FitProblem, hypotheses: Sequence[Hypothesis]) -> list[Hypothesis]:
    """With the newest hypothesis at the best of several sizes where it acts on springs.

    An arm that is driven at its motors swings sharply, so that only models near the truth are led to it by slopes.
    """
    first = list(hypotheses)
    if not first or not _on_springs(first[-1]):
        return first

    def sized(factor: float) -> list[Hypothesis]:
        return [*first[:-1], first[-1].scale(factor)]

    left = {factor: compute_rss(problem, sized(factor)) for factor in _SIZES}
    for _ in range(_FURTHER):
        largest = max(left)
        if min(left, key=left.__getitem__) != largest:
            break
        left[largest * _GROWTH] = compute_rss(problem, sized(largest * _GROWTH))
    return sized(min(left, key=left.__getitem__))


def correct_bias(problem: FitProblem, found: Fit) -> Fit:
    """The same hypotheses, fitted once more to residuals without what replay and simulation of their machine differ by.

    As they are, where nothing was found, the machine cannot be simulated along the log's set-points or be fitted again,
    or no more would be explained.
    """
    log, machine = problem.log, found.run.machine
    if not found.hypotheses:
        return found
    try:
        exact = make_clean_recordings(log, found.run)
        if not exact.simulated:
            return found
        own = assemble_log(log.robot, exact.recordings, like=log)
        bias = compute_residuals(own, predict(replay(own, machine)))
        again = fit(problem.with_bias(bias), found.hypotheses, begun=True)
    except FAILED:
        return found
    return again if again.left < found.left else found
