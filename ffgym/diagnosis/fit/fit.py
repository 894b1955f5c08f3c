"""Evaluation of hypotheses: replay of their machine, residuals, tangents, and the variance that they explain."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, IntArray
from ffgym.diagnosis.computing import FAILED
from ffgym.diagnosis.fit.hypothesis import Hypothesis, build_machine
from ffgym.diagnosis.fit.problem import FitProblem, compute_tangents, split_components
from ffgym.diagnosis.normal_equations import NormalEquations
from ffgym.diagnosis.perturbation import Parts
from ffgym.diagnosis.replay import Replay, predict, replay
from ffgym.diagnosis.replay.rows import lends_deflection
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.residual_rows import compute_residuals, find_valid_rows
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.solving import Priors, solve
from ffgym.simulation.plant import Machine


@dataclass(frozen=True, kw_only=True, eq=False)
class Trial:
    """Hypotheses with fixed values, replayed."""

    numbers: Machine
    """The machine without them: the nominal one, or with other numbers."""
    hypotheses: tuple[Hypothesis, ...]
    run: Replay
    residual: Mapping[Channel, Array]
    """Measured minus predicted, (R, M, C)."""
    left: float
    """Residual sum of squares beside nuisance parameters, with their prior, in units of noise."""

    @property
    def machine(self) -> Machine:
        """The machine with all hypotheses."""
        return self.run.machine


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit(Trial):
    """Replayed hypotheses with tangents; nuisance parameters are not taken off the residual."""

    columns: tuple[Parts, ...]
    """Tangents of all free numbers, per practical step, in the order of the hypotheses."""
    equations: NormalEquations
    """Normal equations of columns of nuisance parameters, then tangents."""
    priors: Priors

    @property
    def n_nuisances(self) -> int:
        """Number of columns of nuisance parameters, which come first."""
        return len(self.priors.low) - len(self.columns)

    @property
    def fold_columns(self) -> IntArray:
        """Places of columns that are fitted anew in each fold: all but durations of what a session changes.

        The first recording of a session says how fast things changed; without it a duration is extrapolated along its
        slope, which tells nothing about the effect.
        """
        free = [number for hypothesis in self.hypotheses for number in hypothesis.list_free()]
        kept = [i for i, number in enumerate(free) if not number.of_session]
        return np.concatenate([np.arange(self.n_nuisances), self.n_nuisances + np.array(kept, dtype=np.intp)])

    def find_tangents(self, hypothesis: Hypothesis) -> tuple[Parts, ...]:
        """Find the columns of a hypothesis, whatever its values; empty if it is not among these."""
        at = 0
        for own in self.hypotheses:
            n = len(own.list_free())
            if own.repeats(hypothesis) and own.null == hypothesis.null:
                return self.columns[at : at + n]
            at += n
        return ()


def replay_hypotheses(
    problem: FitProblem, hypotheses: Sequence[Hypothesis], numbers: Machine | None = None, beside: Replay | None = None
) -> Trial | None:
    """Replay the nominal machine, or one with other `numbers`, with all hypotheses; None if it cannot exist.

    None, too, if its motion cannot be computed. `beside` is passed on to `replay`.
    """
    numbers = numbers or problem.nominal
    machine = build_machine(numbers, hypotheses)
    if machine is None:
        return None
    # measured minus predicted, less the bias that replaying itself has
    try:
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            run = _replay_or_recall(problem, machine, hypotheses, beside)
            rows = compute_residuals(problem.log, predict(run))
            residual = {channel: values - problem.bias[channel] for channel, values in rows.items()}
        if not all(np.isfinite(values).all() for values in residual.values()):
            return None
        # energy that the columns of the calibration leave, with what their prior says of them
        equations, priors = (
            problem.design.form_equations(split_components(residual)),
            problem.nuisance_priors(hypotheses),
        )
        x = solve(equations, np.arange(len(priors.low)), priors)
        gram, pull = equations.gram.sum(axis=0), equations.moment.sum(axis=0)[:, 0]
        left = float(equations.energy.sum() - 2 * x @ pull + x @ gram @ x + priors.precision @ x**2)
    except FAILED:
        return None
    if not np.isfinite(left):
        return None
    return Trial(numbers=numbers, hypotheses=tuple(hypotheses), run=run, residual=residual, left=left)


_KEPT = 2
"""Replays that are kept; chosen: each takes 100 MB for 84 s of six axes."""


def _replay_or_recall(
    problem: FitProblem, machine: Machine, hypotheses: Sequence[Hypothesis], beside: Replay | None
) -> Replay:
    """Replay a machine, or recall it if it is one of the last that a search asked for: it asks for many of them twice.

    A machine with other numbers than the nominal one is not kept.
    """
    if beside is not None or machine.robot is not problem.nominal.robot:
        return replay(problem.log, machine, problem.like, beside=beside)
    key, known = tuple(one.values_key for one in hypotheses), problem.last_replays
    if key in known:
        return known[key]
    # one of them may tell how joints bend, which takes most of the time
    like = next((run for run in known.values() if lends_deflection(run, problem.log, machine)), problem.like)
    _keep(problem, key, run := replay(problem.log, machine, like))
    return run


def _keep(problem: FitProblem, key: tuple[Any, ...], run: Replay) -> None:
    """Keep a replay in place of the oldest of the last ones."""
    known = problem.last_replays
    known.pop(key, None)
    while len(known) >= _KEPT:
        del known[next(iter(known))]
    known[key] = run


def keep_replay(problem: FitProblem, fit: Trial) -> None:
    """Keep the replay of a fit, which is about to be asked for, or may tell how joints bend in another one."""
    if fit.numbers.robot is problem.nominal.robot:
        _keep(problem, tuple(one.values_key for one in fit.hypotheses), fit.run)


def evaluate(problem: FitProblem, hypotheses: Sequence[Hypothesis], like: Fit | None = None) -> Fit:
    """Evaluate hypotheses at the values that they have: replay, residual, tangents and normal equations."""
    if like is not None:
        keep_replay(problem, like)
    tried = replay_hypotheses(problem, hypotheses)
    if tried is None:
        raise FFGymError(f"No machine can have {', '.join(h.label for h in hypotheses)} with these values.")
    return add_tangents(problem, tried, like)


def renew_tangents(problem: FitProblem, fit: Fit) -> Fit:
    """Compute the tangents of a fit anew, at the values that it has."""
    tried = Trial(numbers=fit.numbers, hypotheses=fit.hypotheses, run=fit.run, residual=fit.residual, left=fit.left)
    return add_tangents(problem, tried, None)


def add_tangents(problem: FitProblem, tried: Trial, like: Fit | None) -> Fit:
    """Add tangents of all numbers to a trial; a fit `like` it serves for all but the newest hypothesis."""
    known = {i: of for i, h in enumerate(tried.hypotheses[:-1]) if like is not None and (of := like.find_tangents(h))}
    columns = compute_tangents(tried.run, problem.nominal, tried.hypotheses, known) if tried.hypotheses else []
    if not all(np.isfinite(rows).all() for column in columns for rows in column.values()):
        raise FFGymError(f"Slopes of {', '.join(h.label for h in tried.hypotheses)} are beyond all numbers.")
    return Fit(
        **vars(tried),
        columns=tuple(columns),
        equations=problem.design.beside(columns).form_equations(split_components(tried.residual)),
        priors=build_priors(problem, tried.hypotheses),
    )


def compute_rss(problem: FitProblem, hypotheses: Sequence[Hypothesis]) -> float:
    """Compute the residual sum of squares, in units of noise; inf if no machine can be so."""
    tried = replay_hypotheses(problem, hypotheses)
    return np.inf if tried is None else tried.left


def build_priors(problem: FitProblem, hypotheses: Sequence[Hypothesis]) -> Priors:
    """Build priors of nuisance parameters (standard deviations) and of free numbers (practical steps)."""
    known = problem.nuisance_priors(hypotheses)
    free = [number for hypothesis in hypotheses for number in hypothesis.list_free()]
    reach = settings().estimator.reach
    low = [max(-reach, (number.low - number.value) / number.step) for number in free]
    high = [min(reach, (number.high - number.value) / number.step) for number in free]
    return Priors(
        precision=np.concatenate([known.precision, np.full(len(free), settings().screening.width ** -2)]),
        low=np.concatenate([known.low, np.minimum(low, 0.0)]),
        high=np.concatenate([known.high, np.maximum(high, 0.0)]),
    )


Loudness = Mapping[tuple[Channel, int], float]
"""Energy over that of noise alone, by component."""


def subtract_nuisances(problem: FitProblem, fit: Fit) -> dict[Channel, Array]:
    """Subtract from the residuals (R, M, C) of a fit what nuisance parameters within their bounds explain.

    Hypotheses stay as they are: beside steps that they did not take, the nuisance parameters would explain something
    else.
    """
    sizes = solve(fit.equations, np.arange(fit.n_nuisances), fit.priors)
    rest = {channel: rows.copy() for channel, rows in fit.residual.items()}
    for column, size in zip(problem.nuisance_columns, sizes, strict=True):
        for (channel, c), rows in column.items():
            if channel in rest:
                rest[channel][:, :, c] -= size * rows
    return rest


def loudness(problem: FitProblem, rest: Mapping[Channel, Array]) -> Loudness:
    """Compute the energy of a residual over that of noise alone, by component."""
    valid = find_valid_rows(problem.log).astype(np.float64)
    found = {}
    for channel, rows in rest.items():
        for c in range(rows.shape[2]):
            found[channel, c] = compute_row_energy(rows[:, :, c], problem.weights[channel, c] * valid)
    return found


def compute_row_energy(rows: Array, weight: Array) -> float:
    """Compute the weighted energy of (R, M) per row that counts."""
    weight = np.broadcast_to(weight, rows.shape)
    return float(np.sum((rows * weight) ** 2)) / max(int(np.count_nonzero(weight)), 1)


def compute_excess(problem: FitProblem, fit: Fit) -> float:
    """Compute the largest energy of any component above that of noise, as a share of that of noise."""
    return max(loudness(problem, subtract_nuisances(problem, fit)).values()) - 1.0


def find_touched(problem: FitProblem, columns: list[Parts], *, by_channel: bool = False) -> set[tuple[Channel, int]]:
    """Find components in which columns have a notable share of their energy, in all or within the same channel."""
    energy: dict[tuple[Channel, int], float] = {}
    for column in columns:
        for key, rows in column.items():
            energy[key] = energy.get(key, 0.0) + compute_row_energy(rows, problem.weights[key])
    most = dict.fromkeys((channel for channel, _ in energy), 0.0 if by_channel else sum(energy.values()))
    for (channel, _), value in energy.items() if by_channel else ():
        most[channel] += value
    return {key for key, value in energy.items() if value > settings().search.touched * most[key[0]]}


@dataclass(frozen=True, kw_only=True)
class ExplainedVariance:
    """Variance that a cause explains in some components, as shares of energy."""

    of_excess: float
    """Share of the energy above the noise, which is no more than what is left."""
    of_all: float
    """Share of all energy, noise included."""
    excess: float
    """Share of all energy that was above the noise that the floor allows for."""
    n_loud: int
    """Components with much above the noise: more than a tenth of their mean."""
    best: float
    """Share that is gone of the component of which most is, among those that have a tenth of all above the noise."""


def compute_explained(
    before: Loudness, after: Loudness, where: set[tuple[Channel, int]], allowed: Loudness | None = None
) -> ExplainedVariance:
    """Compute the variance that a cause explains in components `where`, beyond what is `allowed` for in each of them.

    Components in which no more is left than that say nothing of it, unless none says more.
    """
    limits = settings().search
    free = dict.fromkeys(where, 0.0) if allowed is None else {key: allowed[key] for key in where}
    judged = sorted(key for key in where if before[key] - 1.0 > free[key]) or sorted(where)
    # what is gone more than is allowed for; nothing is allowed for what has come
    gone = {}
    for key in judged:
        less = before[key] - after[key]
        gone[key] = less if less < 0 else max(less - free[key], 0.0)
    total = sum(before[key] for key in judged)
    # there may be less noise than the floor allows for: what is left is then all of it
    above = {key: max(before[key] - min(1.0, after[key]), 0.0) for key in judged}
    most = sum(above.values())
    loud = [key for key in judged if above[key] > limits.loudest_share * most / len(judged)]
    return ExplainedVariance(
        of_excess=sum(gone.values()) / max(most, 1e-9),
        of_all=sum(gone.values()) / max(total, 1e-9),
        excess=max(sum(before[key] - 1.0 for key in judged), 0.0) / max(total, 1e-9),
        n_loud=len(loud),
        best=max(
            (gone[key] / max(above[key], 1e-9) for key in loud if above[key] >= limits.loudest_share * most),
            default=0.0,
        ),
    )
