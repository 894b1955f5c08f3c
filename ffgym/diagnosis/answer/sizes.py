"""Sizes of causes with intervals, by resampling blocks of rows."""

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.calibration import Calibration
from ffgym.diagnosis.evidence.solve import bounded
from ffgym.diagnosis.fit.fit import Fit
from ffgym.diagnosis.fit.free import Free
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.lateness import OF_ROW, is_row_offset
from ffgym.diagnosis.result import Cause, Size
from ffgym.effects import EFFECTS
from ffgym.robot import RobotDescription

RESAMPLES = 200
"""Resamples of blocks; quantiles of 5 and 95 % are then known to a per cent or two."""

COVERED = (0.05, 0.95)
"""Quantiles of the interval."""

_DOWN_UP = np.array([-1.0, 1.0])

WIDENED = 1.5
"""Quantiles of resamples are this much further from a size: what neither rows nor calibration vary (equations that are
not straight, few blocks) counts too."""

INEXACT = 0.02
"""Share of a size that is open whatever the rows say, as the model around it is inexact: numbers of the nominal model
are off by half a per cent each, and a fit stops when it would gain nothing. Of 90 sizes of development exams 74 % lay
in what rows alone give, a fifth wider; 88 % lie in intervals with both constants.
"""


def causes_of(
    fit: Fit, gains: tuple[float, ...], calibration: Calibration, rng: np.random.Generator
) -> tuple[Cause, ...]:
    """Causes of a fit, in order, with the share of energy that each removes.

    A size that is a share of a nominal number is no better known than that number, and a time by which torque is late
    no better than the instant of the torque within its row.
    """
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
                values = values + OF_ROW * fit.run.log.dt * rng.normal(size=len(values))
            if p.role == "size" or p.role == "cycles":
                reach = WIDENED * (np.quantile(values, COVERED) - free.value)
                inexact = INEXACT * free.value if p.role == "size" else 0.0
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
    for _ in range(RESAMPLES):
        counts = np.bincount(rng.integers(n, size=n), minlength=n).astype(np.float64)
        drawn = np.concatenate([rng.normal(size=doubts), np.zeros(len(priors.low) - doubts)])
        pull = counts @ moment + priors.precision * drawn
        x = bounded(np.einsum("b,bpq->pq", counts, gram), pull, priors.precision, priors.low, priors.high)
        found.append(x[doubts:] - stays)
    return np.array(found)
