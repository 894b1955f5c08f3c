"""Candidates: every effect on every joint that can have it, beside nuisance parameters, and surrogate residuals."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ffgym.core.types import Array, IntArray
from ffgym.diagnosis.normal_equations import DesignMatrix, Values, build_design_matrix
from ffgym.diagnosis.nuisance import NuisanceParameter
from ffgym.diagnosis.perturbation import Parts
from ffgym.diagnosis.resampling import TimeBlocks
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.sensitivity import Sensitivity, group_candidates
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.solving import Candidate, Priors
from ffgym.diagnosis.variant import compute_step


def draw_surrogates(
    draws: Mapping[Channel, Array], blocks: TimeBlocks, nuisance_columns: Sequence[Parts], rng: np.random.Generator
) -> Values:
    """Draw residuals (R, M, K) by component of K surrogate logs without fault.

    Each is a replay of the nominal model over its own simulation, with the sign of every block drawn, which keeps size
    and spectrum; nuisance parameters are drawn from their priors, within their bounds.

    Args:
        draws: residuals of faultless replays (R, M, C, D).
        blocks: of rows.
        nuisance_columns: columns per standard deviation.
        rng: draws signs and errors.
    """
    prior_limits = settings().prior
    screening_limits = settings().screening
    errors = np.clip(
        rng.normal(size=(len(nuisance_columns), screening_limits.surrogates)),
        -prior_limits.bound,
        prior_limits.bound,
    )
    found: dict[tuple[Channel, int], Array] = {}
    for channel, rows in draws.items():
        for c in range(rows.shape[2]):
            pick = rng.integers(rows.shape[3], size=screening_limits.surrogates)
            signs = rng.choice([-1.0, 1.0], size=(len(blocks) + 1, screening_limits.surrogates))
            found[channel, c] = rows[:, :, c, pick] * signs[blocks.of_row]
    for column, sizes in zip(nuisance_columns, errors, strict=True):
        for key, rows in column.items():
            if key in found:
                found[key] += rows[..., None] * sizes
    return found


_WIDE = 10.0
"""Standard deviation of a candidate's parameter in practical steps: as good as free, but not without end."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Candidates:
    """Columns of nuisance parameters and effects, scaled to standard deviations and practical steps."""

    nuisances: tuple[NuisanceParameter, ...]
    columns: tuple[Sensitivity, ...]
    """Sensitivities of effects, without their rows, which are hundreds of megabytes."""
    groups: tuple[Candidate, ...]
    """Effect, joint and shape, with places among all columns: nuisance parameters first."""
    scale: Array
    """Standard deviation or step of each column, in its parameter's unit, shape (P,)."""
    priors: Priors
    design: DesignMatrix
    """Design matrix of all columns, scaled."""

    @property
    def nuisance_places(self) -> IntArray:
        """Places of the columns of nuisance parameters."""
        return np.arange(len(self.nuisances))

    def first(self, group: Candidate) -> Sensitivity:
        """Return one column of a candidate: all have its effect and joint."""
        return self.columns[int(group.columns[0]) - len(self.nuisances)]

    def of(self, group: Candidate) -> list[Sensitivity]:
        """List all columns of a candidate."""
        return [self.columns[int(i) - len(self.nuisances)] for i in group.columns]

    def beside(self, columns: Sequence[Sensitivity]) -> "Candidates":
        """Append candidates of other columns; those of one effect, joint and shape are adopted together."""
        groups = []
        for places in group_candidates(columns):
            first = columns[places[0]]
            p = first.effect.parameters()[first.parameter]
            one_sided = len(places) == 1 and p.minimum == p.null
            groups.append(Candidate(columns=np.array(places) + len(self.scale), one_sided=one_sided))
        scale = np.array([abs(compute_step(c.effect.parameters()[c.parameter])) for c in columns])
        wide, endless = np.full(len(columns), _WIDE**-2), np.full(len(columns), np.inf)
        return Candidates(
            nuisances=self.nuisances,
            columns=(*self.columns, *(replace(column, parts={}) for column in columns)),  # the stack has their rows
            groups=(*self.groups, *groups),
            scale=np.concatenate([self.scale, scale]),
            priors=Priors(
                precision=np.concatenate([self.priors.precision, wide]),
                low=np.concatenate([self.priors.low, -endless]),
                high=np.concatenate([self.priors.high, endless]),
            ),
            design=self.design.beside([column.parts for column in columns], scale),
        )


def build_candidates(
    nuisances: Sequence[NuisanceParameter], columns: Sequence[Sensitivity], blocks: TimeBlocks, weights: Values
) -> Candidates:
    """Build candidates from columns, beside nuisance parameters."""
    sigma = np.array([nuisance.sigma for nuisance in nuisances])
    none = Candidates(
        nuisances=tuple(nuisances),
        columns=(),
        groups=(),
        scale=sigma,
        priors=Priors(
            precision=np.ones(len(nuisances)),
            low=np.array([nuisance.limits[0] for nuisance in nuisances]),
            high=np.array([nuisance.limits[1] for nuisance in nuisances]),
        ),
        design=build_design_matrix(blocks, [nuisance.column.parts for nuisance in nuisances], weights, sigma),
    )
    return none.beside(columns)
