"""Ranking of candidates by the energy that they explain on held-out rows, with a threshold from surrogate data."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, IntArray
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.normal_equations import NormalEquations
from ffgym.diagnosis.resampling import make_half_folds, make_motion_folds
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.search.candidates import Candidates
from ffgym.diagnosis.sensitivity import Sensitivity
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.solving import screen, solve, solve_bounded
from ffgym.effects.parameters import Parameter
from ffgym.robot import RobotDescription


def build_hypothesis(columns: Sequence[Sensitivity], sizes: Array, robot: RobotDescription) -> Hypothesis:
    """Build a hypothesis from the columns of a candidate and their sizes in a linear fit, in units of parameters.

    What spans a phase gives amplitude and phase; what spans a linear shape gives its mean, weighted by sizes. Shares
    begin within what is plausible, whatever the robot: one that acts through another number, as the width of a peak
    that is to be higher, is far off in a linear fit. Other sizes depend on the robot's.
    """
    # values of all parameters from the columns of each
    kind, joint = columns[0].effect, columns[0].joint
    values: dict[str, Array] = {}
    for p in kind.parameters().values():
        own = [(c, float(x)) for c, x in zip(columns, sizes, strict=True) if c.parameter == p.name]
        if p.role != "size":
            values[p.name] = _choose_shape(p, columns, sizes)
        elif p.per == "vector":
            moved = np.array([sum(x for c, x in own if c.part == k) for k in range(3)])
            values[p.name] = np.clip(p.neutral + moved, p.minimum, p.maximum)
        else:
            spans_phase = len([c for c, _ in own if "phase" in c.shape]) == 2
            total = math.hypot(*(x for _, x in own)) if spans_phase else sum(x for _, x in own)
            low, high = (p.low, p.high) if p.unit == "1" else (p.minimum, p.maximum)
            values[p.name] = np.array(np.clip(p.neutral + total, low, high))
    if not values:
        raise FFGymError(f"Effect {kind.name} has no parameters.")
    source = columns[0].part if kind.parameters()[columns[0].parameter].per == "pair" else None
    return Hypothesis(kind=kind, joint=joint, source=source, values=values)


def _choose_shape(p: Parameter, columns: Sequence[Sensitivity], sizes: Array) -> Array:
    """Choose the value of a shape parameter: as in the columns, or the mean of the values that span it."""
    default = p.neutral if p.default is None else p.default
    neutral = np.full(3, default) if p.per == "vector" else np.array(default)
    if p.role == "phase":
        return np.array(float(np.arctan2(sizes[1], sizes[0]))) if len(sizes) == 2 else neutral
    known = [np.asarray(c.shape.get(p.name, neutral), dtype=np.float64) for c in columns]
    if p.role != "span":
        return known[0]
    total = float(np.sum(sizes))
    if abs(total) < 1e-12:
        return neutral
    mean = sum(x * value for x, value in zip(sizes, known, strict=True)) / total
    return np.clip(mean, p.low, p.high)


Component = tuple[Channel, int]
"""Joint of a channel, or axis of the tool."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Ranking:
    """Scores of all candidates, in units of the energy of noise in one component."""

    score: Array
    """Mean of both splits, shape (C,)."""
    order: IntArray
    """Best first."""
    threshold: float
    """Largest score by chance."""
    most: Array
    """Score that each would have at the largest size that is plausible, shape (C,); empty if not wanted."""

    def is_significant(self, i: int) -> bool:
        """Tell whether a candidate explains more than chance would."""
        return bool(self.score[i] > self.threshold)


def rank(equations: NormalEquations, candidates: Candidates, nuisances: IntArray, *, with_most: bool = True) -> Ranking:
    """Rank candidates by what they remove from halves and motions that were left out.

    Args:
        equations: of the log's residual first, then of surrogate residuals.
        candidates: with the columns of the evidence.
        nuisances: places of columns that are fitted beside each candidate.
        with_most: whether scores at the largest plausible sizes are wanted, too.
    """
    # held-out gains over both splits, in units of noise energy in one component
    halves, _ = screen(equations, make_half_folds(equations.blocks), nuisances, candidates.groups, candidates.priors)
    motions = halves
    if folds := make_motion_folds(equations.blocks):
        motions, _ = screen(equations, folds, nuisances, candidates.groups, candidates.priors)
    per = float(equations.rows.sum()) / equations.n_components
    score = 0.5 * (halves / per + motions / per)
    # threshold from the best candidate in each surrogate log
    chance = score[:, 1:].max(axis=0) if score.shape[1] > 1 else np.zeros(1)
    return Ranking(
        score=score[:, 0],
        order=np.argsort(-score[:, 0], kind="stable"),
        threshold=_estimate_extreme(chance),
        most=_compute_largest(equations, candidates, nuisances) / per if with_most else np.zeros(0),
    )


def _compute_largest(equations: NormalEquations, candidates: Candidates, nuisances: IntArray) -> Array:
    """Compute the energy of each candidate's largest column, at the end of its range, that no nuisance can imitate.

    Nuisance parameters have bounds: what is as large as a plausible effect may be beyond all of them together.
    """
    limits = settings().screening
    gram, priors = equations.gram.sum(axis=0), candidates.priors
    inner, precision = gram[np.ix_(nuisances, nuisances)], priors.precision[nuisances]
    low, high = priors.low[nuisances], priors.high[nuisances]
    cross = gram[nuisances] / limits.step
    x = np.linalg.solve(inner + np.diag(precision), cross)
    for p in np.flatnonzero(np.any((x < low[:, None]) | (x > high[:, None]), axis=0)):
        x[:, p] = solve_bounded(inner, cross[:, p], precision, low, high)
    own = np.diagonal(gram) / limits.step**2 - np.sum(x * (2 * cross - inner @ x - precision[:, None] * x), axis=0)
    return np.array([own[group.columns].max() for group in candidates.groups])


def _estimate_extreme(largest: Array) -> float:
    """Estimate a high quantile of largest scores by the distribution of largest values (Gumbel's)."""
    spread = max(float(np.std(largest)), 1e-12) * np.sqrt(6) / np.pi
    middle = float(np.mean(largest)) - np.euler_gamma * spread
    return float(max(middle - spread * np.log(-np.log(settings().screening.level)), largest.max()))


def propose_start(
    equations: NormalEquations, candidates: Candidates, i: int, nuisances: IntArray, robot: RobotDescription
) -> Hypothesis:
    """Propose the hypothesis that a candidate begins with: the linear fit beside nuisance parameters."""
    group = candidates.groups[i]
    sizes = _fit_linearly(equations, candidates, i, nuisances) * candidates.scale[group.columns]
    return build_hypothesis(candidates.of(group), sizes, robot)


def find_changed_components(
    equations: NormalEquations, candidates: Candidates, i: int, nuisances: IntArray
) -> dict[Component, float]:
    """Find components that a candidate changes, by a linear fit, with shares of the energy of that change."""
    energy = equations.design.energy_of(
        candidates.groups[i].columns, _fit_linearly(equations, candidates, i, nuisances)
    )
    total = sum(energy.values())
    return {key: value / total for key, value in energy.items()} if total else {}


def compute_overlap(one: Mapping[Component, float], other: Mapping[Component, float]) -> float:
    """Compute the share of what two candidates change that both of them change."""
    return sum(min(value, other.get(key, 0.0)) for key, value in one.items())


def _fit_linearly(equations: NormalEquations, candidates: Candidates, i: int, nuisances: IntArray) -> Array:
    """Fit a candidate's columns linearly beside nuisance parameters, with a ridge where they are alike."""
    own = candidates.groups[i].columns
    precision = candidates.priors.precision.copy()
    precision[own] = np.maximum(precision[own], settings().screening.ridge * equations.gram[:, own, own].sum(axis=0))
    places = np.concatenate([nuisances, own])
    return solve(equations, places, replace(candidates.priors, precision=precision))[len(nuisances) :]
