"""Numbers of the answer: levels of residuals, the gain of the extended model, sizes of causes with intervals."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ffgym.core.measures import rms
from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.calibration import Calibration, is_row_offset
from ffgym.diagnosis.computing import trim_heap
from ffgym.diagnosis.evidence import Fold, half_folds
from ffgym.diagnosis.fit.fit import Fit
from ffgym.diagnosis.fit.hypothesis import Free, Hypothesis
from ffgym.diagnosis.fit.setting import Setting
from ffgym.diagnosis.fit.written import written
from ffgym.diagnosis.measured import counting_rows, measured_rows
from ffgym.diagnosis.residual import UNITS, Channel, components
from ffgym.diagnosis.result import Cause, Level, Size
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.solving import bounded
from ffgym.effects import EFFECTS
from ffgym.robot import RobotDescription


def levels(
    setting: Setting, before: Mapping[Channel, Array], after: Mapping[Channel, Array], floor: Mapping[Channel, Array]
) -> tuple[Level, ...]:
    """RMS of every component that is judged, of residuals (R, M, C) before and after, beside the noise floor (M, C)."""
    counting, measured = counting_rows(setting.log), measured_rows(setting.log)
    listed = []
    for channel in before:
        for c, name in enumerate(components(channel, setting.log.robot)):
            valid = counting[channel, c]
            if not valid.any():
                continue  # no row counts: an encoder that is not there, or a joint that never moves
            # RMS over rows that count, less their mean
            listed.append(
                Level(
                    channel=channel,
                    component=name,
                    unit=UNITS[channel],
                    measured=float(np.std(measured[channel][:, :, c][valid])),
                    noise_floor=_mean_square(floor[channel][:, c][None] + 0 * valid, valid),
                    before=_mean_square(before[channel][:, :, c], valid),
                    after=_mean_square(after[channel][:, :, c], valid),
                )
            )
    return tuple(listed)


def _mean_square(rows: Array, valid: BoolArray) -> float:
    """RMS over rows that count."""
    return rms(np.broadcast_to(rows, valid.shape)[valid])


@dataclass(frozen=True, kw_only=True, eq=False)
class Gain:
    """Residuals (R, M, C) by channel, on motions that were not used."""

    before: Mapping[Channel, Array]
    after: Mapping[Channel, Array]
    is_better: bool
    """Whether less is left than before, in units of the noise of each row."""


def held_out_gain(setting: Setting, nominal: Fit, found: Fit, calibration: Calibration) -> Gain | None:
    """Residuals of both models on motions that were left out of the fit; None if none could be written."""
    before = {channel: rows.copy() for channel, rows in nominal.residual.items()}
    after = {channel: rows.copy() for channel, rows in nominal.residual.items()}
    # groups of motions are left out in turn, or halves of a single one
    blocks, motions = setting.blocks, np.unique(setting.blocks.motion)
    folds = half_folds(blocks)
    if len(motions) > 1:
        group = np.searchsorted(motions, blocks.motion) % min(settings().intervals.folds, len(motions))
        folds = [Fold(train=group != k, test=group == k) for k in range(int(group.max()) + 1)]
    for fold in folds:
        trim_heap()
        model = written(setting, found, calibration, fold.train)
        if model is None:
            return None
        test = (blocks.of_row >= 0) & fold.test[np.maximum(blocks.of_row, 0)]
        plain = written(setting, nominal, calibration, fold.train) if calibration.refit is not None else None
        for channel, rows in model.residual.items():
            after[channel][test] = rows[test]
            if plain is not None:
                before[channel][test] = plain.residual[channel][test]
    return Gain(before=before, after=after, is_better=_energy(setting, after) < _energy(setting, before))


def _energy(setting: Setting, residual: Mapping[Channel, Array]) -> float:
    """Of rows that are of blocks, in units of the noise."""
    inside = setting.blocks.of_row >= 0
    return sum(
        float(np.sum((np.broadcast_to(weight, inside.shape) * residual[channel][:, :, c])[inside] ** 2))
        for (channel, c), weight in setting.weights.items()
    )


COVERED = (0.05, 0.95)
"""Quantiles of the interval."""

_DOWN_UP = np.array([-1.0, 1.0])


def causes_of(
    fit: Fit, gains: tuple[float, ...], calibration: Calibration, rng: np.random.Generator
) -> tuple[Cause, ...]:
    """Causes of a fit, in order, with the share of energy that each removes.

    A size that is a share of a nominal number is no better known than that number, and a time by which torque is late
    no better than the instant of the torque within its row.
    """
    limits = settings().intervals
    draws = _resampled(fit, rng)
    found, at = [], 0
    for hypothesis, gain in zip(fit.hypotheses, gains, strict=True):
        known = hypothesis.kind.parameters()
        kept = sorted({*hypothesis.null, *(name for name, p in known.items() if p.scale)})
        sizes, fixed = [], {name: float(np.max(hypothesis.values[name])) for name in kept}
        for free in hypothesis.free():
            p = hypothesis.kind.parameters()[free.name]
            values = free.value + free.step * draws[:, at]
            at += 1
            if p.role == "size" and p.unit == "1":
                values = values * (1 + calibration.share * rng.normal(size=len(values)))
            if p.unit == "s" and is_row_offset(hypothesis.kind, fit.run.robot.n_joints):
                values = values + settings().prior.late_rows * fit.run.log.dt * rng.normal(size=len(values))
            if p.role == "size" or p.role == "cycles":
                reach = limits.widened * (np.quantile(values, COVERED) - free.value)
                inexact = limits.inexact * free.value if p.role == "size" else 0.0
                low, high = np.clip(free.value + _DOWN_UP * np.hypot(reach, inexact), free.low, free.high)
                interval = (float(low), float(high))
                sizes.append(
                    Size(name=_name(hypothesis, free, fit.run.robot), value=free.value, unit=p.unit, interval=interval)
                )
            else:
                fixed[_name(hypothesis, free, fit.run.robot)] = free.value
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


def _name(hypothesis: Hypothesis, free: Free, robot: RobotDescription) -> str:
    """Name of a number: its parameter's, with the axis of a vector or the other joint of a pair behind a dot."""
    if free.part is not None:
        return f"{free.name}.{'xyz'[free.part]}"
    return free.name if hypothesis.source is None else f"{free.name}.{robot.joints[hypothesis.source]}"


def _resampled(fit: Fit, rng: np.random.Generator) -> Array:
    """Changes of all free numbers, in practical steps, shape (B, P).

    Blocks of rows are resampled for what noise and motions leave open, and calibration errors drawn for what nobody
    knows of the nominal numbers, which a size is relative to; all stay within their bounds, as in the fit. What a step
    from all rows would change is taken off: the fit has been there, and stayed.
    """
    gram, moment, priors = fit.evidence.gram, fit.evidence.moment[:, :, 0], fit.priors
    n, doubts = len(gram), fit.n_calibration
    stays = bounded(gram.sum(axis=0), moment.sum(axis=0), priors.precision, priors.low, priors.high)[doubts:]
    found = []
    for _ in range(settings().intervals.resamples):
        counts = np.bincount(rng.integers(n, size=n), minlength=n).astype(np.float64)
        drawn = np.concatenate([rng.normal(size=doubts), np.zeros(len(priors.low) - doubts)])
        pull = counts @ moment + priors.precision * drawn
        x = bounded(np.einsum("b,bpq->pq", counts, gram), pull, priors.precision, priors.low, priors.high)
        found.append(x[doubts:] - stays)
    return np.array(found)
