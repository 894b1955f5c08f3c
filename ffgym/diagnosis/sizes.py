"""Numbers of the answer: levels of residuals, the gain of the extended model, sizes of causes with intervals."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.computing import trim_heap
from ffgym.diagnosis.fit.fit import Fit
from ffgym.diagnosis.fit.hypothesis import FreeParameter, Hypothesis
from ffgym.diagnosis.fit.problem import FitProblem
from ffgym.diagnosis.fit.written import build_extended_model
from ffgym.diagnosis.log import Log
from ffgym.diagnosis.nuisance import ParameterPrior, is_row_offset
from ffgym.diagnosis.resampling import Pool, bootstrap, make_half_folds, make_motion_folds
from ffgym.diagnosis.residual import UNITS, Channel
from ffgym.diagnosis.residual_rows import compute_component_rms
from ffgym.diagnosis.result import Cause, Level, Size
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.solving import solve_bounded
from ffgym.effects import EFFECTS
from ffgym.robot import RobotDescription


def compute_levels(
    log: Log, before: Mapping[Channel, Array], after: Mapping[Channel, Array], floor: Mapping[Channel, Array]
) -> tuple[Level, ...]:
    """Compute RMS of every judged component, of residuals (R, M, C) before and after, beside the noise floor (M, C)."""
    return tuple(
        Level(
            channel=channel,
            component=name,
            unit=UNITS[channel],
            measured=measured,
            noise_floor=noise,
            before=first,
            after=last,
        )
        for channel, name, (measured, first, last, noise) in compute_component_rms(log, before, after, floor)
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class HeldOutGain:
    """Residuals (R, M, C) by channel, on motions that were not used."""

    before: Mapping[Channel, Array]
    after: Mapping[Channel, Array]
    is_better: bool
    """True if less is left than before, in units of the noise of each row."""


def compute_held_out_gain(problem: FitProblem, nominal: Fit, found: Fit, prior: ParameterPrior) -> HeldOutGain | None:
    """Compute residuals of both models on motions that were left out of the fit; None if no model could be written."""
    before = {channel: rows.copy() for channel, rows in nominal.residual.items()}
    after = {channel: rows.copy() for channel, rows in nominal.residual.items()}
    # groups of motions are left out in turn, or halves of a single one
    blocks = problem.blocks
    folds = make_motion_folds(blocks, settings().intervals.folds) or make_half_folds(blocks)
    # fit the written model without each fold, and take its residual there
    for fold in folds:
        trim_heap()
        model = build_extended_model(problem, found, prior, fold.train)
        if model is None:
            return None
        test = (blocks.of_row >= 0) & fold.test[np.maximum(blocks.of_row, 0)]
        plain = build_extended_model(problem, nominal, prior, fold.train) if prior.refit is not None else None
        for channel, rows in model.residual.items():
            after[channel][test] = rows[test]
            if plain is not None:
                before[channel][test] = plain.residual[channel][test]
    return HeldOutGain(
        before=before, after=after, is_better=_compute_energy(problem, after) < _compute_energy(problem, before)
    )


def _compute_energy(problem: FitProblem, residual: Mapping[Channel, Array]) -> float:
    """Compute the energy of rows that are of blocks, in units of the noise."""
    inside = problem.blocks.of_row >= 0
    return sum(
        float(np.sum((np.broadcast_to(weight, inside.shape) * residual[channel][:, :, c])[inside] ** 2))
        for (channel, c), weight in problem.weights.items()
    )


COVERED = (0.05, 0.95)
"""Quantiles of the interval."""

_DOWN_UP = np.array([-1.0, 1.0])


def list_causes(
    fit: Fit, gains: tuple[float, ...], prior: ParameterPrior, rng: np.random.Generator
) -> tuple[Cause, ...]:
    """List causes of a fit, in order, with sizes, intervals and the share of energy that each explains.

    A size that is a share of a nominal number is no better known than that number, and a time by which torque is late
    no better than the instant of the torque within its row.
    """
    limits = settings().intervals
    # bootstrap of all free numbers, then one cause after the other
    draws = _resample_numbers(fit, rng)
    found, at = [], 0
    for hypothesis, gain in zip(fit.hypotheses, gains, strict=True):
        # numbers of fixed value, such as scales, are reported beside the sizes
        known = hypothesis.kind.parameters()
        kept = sorted({*hypothesis.null, *(name for name, p in known.items() if p.scale)})
        sizes, fixed = [], {name: float(np.max(hypothesis.values[name])) for name in kept}
        for free in hypothesis.list_free():
            p = hypothesis.kind.parameters()[free.name]
            values = free.value + free.step * draws[:, at]
            at += 1
            # uncertainty of the nominal number or instant that a size refers to
            if p.role == "size" and p.unit == "1":
                values = values * (1 + prior.share * rng.normal(size=len(values)))
            if p.unit == "s" and is_row_offset(hypothesis.kind, fit.run.robot.n_joints):
                values = values + settings().prior.late_rows * fit.run.log.dt * rng.normal(size=len(values))
            # interval by quantiles, widened by what equations are inexact
            if p.role == "size" or p.role == "cycles":
                reach = limits.widened * (np.quantile(values, COVERED) - free.value)
                inexact = limits.inexact * free.value if p.role == "size" else 0.0
                low, high = np.clip(free.value + _DOWN_UP * np.hypot(reach, inexact), free.low, free.high)
                interval = (float(low), float(high))
                sizes.append(
                    Size(
                        name=_name_number(hypothesis, free, fit.run.robot),
                        value=free.value,
                        unit=p.unit,
                        interval=interval,
                    )
                )
            else:
                fixed[_name_number(hypothesis, free, fit.run.robot)] = free.value
        found.append(
            Cause(
                effect=hypothesis.kind.name,
                code=hypothesis.kind.code,
                title=hypothesis.kind.title,
                joint=hypothesis.joint,
                parameters=tuple(sizes),
                fixed=fixed,
                held_out_gain=gain,
            )
        )
    return tuple(found)


def is_there(cause: Cause) -> bool:
    """Tell whether the interval of any size of a cause excludes that the effect is absent."""
    known = EFFECTS[cause.effect].parameters()
    for size in cause.parameters:
        p, (low, high) = known[size.name.partition(".")[0]], size.interval
        if p.role == "size" and not low <= p.neutral <= high:
            return True
    return False


def _name_number(hypothesis: Hypothesis, free: FreeParameter, robot: RobotDescription) -> str:
    """Name a number by its parameter, with the axis of a vector or the other joint of a pair behind a dot."""
    if free.part is not None:
        return f"{free.name}.{'xyz'[free.part]}"
    return free.name if hypothesis.source is None else f"{free.name}.{robot.joints[hypothesis.source]}"


def _resample_numbers(fit: Fit, rng: np.random.Generator) -> Array:
    """Resample changes of all free numbers, in practical steps, shape (B, P).

    Blocks of rows are resampled for what noise and motions leave open, and nuisance parameters drawn for what is
    unknown of the nominal numbers, which a size is relative to; all stay within their bounds, as in the fit. What a
    step from all rows would change is taken off: the fit has been there, and stayed.
    """
    # step from all rows, which resamples share
    gram, moment, priors = fit.equations.gram, fit.equations.moment[:, :, 0], fit.priors
    nuisances = fit.n_nuisances
    stays = solve_bounded(gram.sum(axis=0), moment.sum(axis=0), priors.precision, priors.low, priors.high)[nuisances:]

    def step_from(counts: Array) -> Array:
        drawn = np.concatenate([rng.normal(size=nuisances), np.zeros(len(priors.low) - nuisances)])
        pull = counts @ moment + priors.precision * drawn
        x = solve_bounded(np.einsum("b,bpq->pq", counts, gram), pull, priors.precision, priors.low, priors.high)
        return x[nuisances:] - stays

    return bootstrap(step_from, Pool(len(gram)), rng, settings().intervals.resamples)
