"""Hypotheses fitted to a log by replaying the machine that they make: Gauss-Newton with calibration beside them.

A replay takes steps of its own, follows standing motors within a band, and knows motions through a low-pass. For the
nominal machine that difference is known and taken off every residual; a machine with an effect has another one, which
would be read as a part of the effect.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from ffgym.core.types import Array
from ffgym.diagnosis.clean_recordings import make_clean_recordings
from ffgym.diagnosis.computing import FAILED
from ffgym.diagnosis.fit.descent import Slope, Steps, descend
from ffgym.diagnosis.fit.fit import Fit, Trial, add_tangents, compute_rss, evaluate, keep_replay, replay_hypotheses
from ffgym.diagnosis.fit.hypothesis import Hypothesis, move_hypotheses
from ffgym.diagnosis.fit.problem import FitProblem
from ffgym.diagnosis.log import assemble_log
from ffgym.diagnosis.replay import predict, replay
from ffgym.diagnosis.residual_rows import compute_residuals
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.solving import Priors, solve
from ffgym.effects.effect import LinkBrake

_SIZES = (0.6, 1.0, 1.5, 2.2, 3.3)
"""Multiples of the size of a linear fit at which effects of springs are tried first."""

_FURTHER, _GROWTH = 6, 1.4
"""Times that a larger one is tried where the largest leaves least, and by which factor: to 25 times the linear fit,
which is of a small effect, and sees little of one that grows with the cube."""

_SOUGHT, _FINE = (-0.3, 0.3), 0.005
"""Logarithms of the factors between which a size is sought along a line, and how finely."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Hypotheses(Slope[Trial]):
    """Free numbers of hypotheses in practical steps, beside nuisance parameters that are solved for each time."""

    problem: FitProblem
    like: Fit | None
    """A fit whose tangents of other hypotheses serve here."""

    def cost(self, point: Trial) -> float:
        return point.left

    def step(self, point: Trial, reach: float) -> Array:
        assert isinstance(point, Fit)
        priors, n = point.priors, point.n_nuisances
        low, high = np.maximum(priors.low[n:], -reach), np.minimum(priors.high[n:], reach)
        bounded = Priors(
            precision=priors.precision,
            low=np.concatenate([priors.low[:n], low]),
            high=np.concatenate([priors.high[:n], high]),
        )
        return solve(point.equations, np.arange(len(priors.low)), bounded)[n:]

    def move(self, point: Trial, step: Array) -> Trial | None:
        return replay_hypotheses(self.problem, move_hypotheses(point.hypotheses, step))

    def renew(self, point: Trial, *, is_last: bool) -> Trial | None:
        try:
            return add_tangents(self.problem, point, self.like)
        except FAILED:
            return None  # a machine at the edge of what can be: the fit stays where slopes were known


def fit(problem: FitProblem, hypotheses: Sequence[Hypothesis], *, begun: bool = False, like: Fit | None = None) -> Fit:
    """Fit hypotheses to a log, from the values that they have.

    Those of the last one, which is the newest, are of a linear fit, or good already if it has `begun`. Tangents of a
    fit `like` it, of others among them, serve here: they hardly change when one more comes.
    """
    return refine(problem, evaluate(problem, hypotheses if begun else _choose_start(problem, hypotheses), like), like)


def refine(problem: FitProblem, begun: Fit, like: Fit | None = None, *, roughly: bool = False) -> Fit:
    """Refine a fit from where it has `begun`; `roughly` if only its energy is asked for, to a per cent."""
    if not begun.hypotheses:
        return begun
    limits = settings().estimator
    steps = Steps(
        most=limits.steps,
        reach=limits.reach,
        least_reach=limits.least_reach,
        gain=limits.gain,
        rest=np.inf if roughly else limits.rest,
    )
    found = descend(_Hypotheses(problem=problem, like=like), begun, steps)
    assert isinstance(found, Fit)
    return found


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
    """Tell whether an effect changes how springs swing; friction behind them does not, whatever its size."""
    kind = hypothesis.kind
    return kind.needs_elasticity and kind.side == "link" and not (kind.needs_friction or issubclass(kind, LinkBrake))


def _choose_start(problem: FitProblem, hypotheses: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Choose the best of several sizes for the newest hypothesis where it acts on springs.

    An arm that is driven at its motors swings sharply, so that only models near the truth are led to it by slopes.
    """
    first = list(hypotheses)
    if not first or not _on_springs(first[-1]):
        return first

    def scale_newest(factor: float) -> list[Hypothesis]:
        return [*first[:-1], first[-1].scale(factor)]

    left = {factor: compute_rss(problem, scale_newest(factor)) for factor in _SIZES}
    for _ in range(_FURTHER):
        largest = max(left)
        if min(left, key=left.__getitem__) != largest:
            break
        left[largest * _GROWTH] = compute_rss(problem, scale_newest(largest * _GROWTH))
    return scale_newest(min(left, key=left.__getitem__))


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
        keep_replay(problem, found)
        again = fit(problem.with_bias(bias), found.hypotheses, begun=True)
    except FAILED:
        return found
    return again if again.left < found.left else found
