"""Hypotheses with the values that they have: what their machine predicts, and how that changes with each number."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, IntArray
from ffgym.diagnosis.evidence.fitted import fitted
from ffgym.diagnosis.evidence.priors import Priors
from ffgym.diagnosis.evidence.stack import Evidence
from ffgym.diagnosis.failures import FAILED
from ffgym.diagnosis.fit.hypothesis import Hypothesis, machine_with
from ffgym.diagnosis.fit.setting import Setting, values_of
from ffgym.diagnosis.fit.tangents import tangents
from ffgym.diagnosis.measured import residual_rows
from ffgym.diagnosis.replay import Replay, predicted, replay
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.signatures.parts import Parts
from ffgym.simulation.plant import Machine

_FAR = 3.0
"""Practical steps that a number may move in one round."""

_WIDE = 10.0
"""Standard deviation of a number in practical steps: as good as free, but not without end."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit:
    """Hypotheses as the log has them."""

    hypotheses: tuple[Hypothesis, ...]
    run: Replay
    residual: Mapping[Channel, Array]
    """(R, M, C), calibration not taken off."""
    columns: tuple[Parts, ...]
    """Tangents of all free numbers, per practical step, in the order of the hypotheses."""
    evidence: Evidence
    """Of calibration columns, then tangents."""
    priors: Priors
    left: float
    """Energy that calibration and hypotheses leave, of all rows."""

    @property
    def n_calibration(self) -> int:
        """Columns of the calibration."""
        return len(self.priors.low) - len(self.columns)

    @property
    def fold_columns(self) -> IntArray:
        """Places of columns that are fitted anew in each fold: all but durations of what a session changes.

        The first recording of a session says how fast things changed; without it a duration is extrapolated along its
        slope, which tells nothing about the effect.
        """
        free = [number for hypothesis in self.hypotheses for number in hypothesis.free()]
        kept = [i for i, number in enumerate(free) if not number.of_session]
        return np.concatenate([self.calibration_only, self.n_calibration + np.array(kept, dtype=np.intp)])

    def tangents_of(self, hypothesis: Hypothesis) -> tuple[Parts, ...]:
        """Columns of a hypothesis, whatever values it has; none if it is not among these."""
        at = 0
        for own in self.hypotheses:
            n = len(own.free())
            if own.repeats(hypothesis) and own.null == hypothesis.null:
                return self.columns[at : at + n]
            at += n
        return ()

    @property
    def everything(self) -> IntArray:
        """Places of all columns."""
        return np.arange(len(self.priors.low))

    @property
    def calibration_only(self) -> IntArray:
        """Places of the calibration's columns."""
        return np.arange(self.n_calibration)


@dataclass(frozen=True, kw_only=True, eq=False)
class Trial:
    """Hypotheses with the values that they have, replayed."""

    hypotheses: Sequence[Hypothesis]
    run: Replay
    residual: Mapping[Channel, Array]
    """(R, M, C)."""
    left: float


def trial_of(
    setting: Setting,
    hypotheses: Sequence[Hypothesis],
    nominal: Machine | None = None,
    beside: Replay | None = None,
) -> Trial | None:
    """Replay the machine with all hypotheses.

    Args:
        setting: the log and what all fits share.
        hypotheses: of the machine.
        nominal: the machine that has them; None is that of the setting.
        beside: replay of one that differs by errors of calibration, see `replay`.

    Returns:
        None if no machine can have them, or what it does cannot be computed.
    """
    machine = machine_with(nominal or setting.nominal, hypotheses)
    if machine is None:
        return None
    try:
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            run = replay(setting.log, machine, setting.like, beside=beside)
            rows = residual_rows(setting.log, predicted(run))
            residual = {channel: values - setting.bias[channel] for channel, values in rows.items()}
        if not all(np.isfinite(values).all() for values in residual.values()):
            return None
        left = _left(setting.stack.evidence(values_of(residual)), priors_of_calibration(setting, hypotheses))
    except FAILED:
        return None
    return Trial(hypotheses=hypotheses, run=run, residual=residual, left=left) if np.isfinite(left) else None


def _left(evidence: Evidence, priors: Priors) -> float:
    """Energy that the columns of the calibration, which come first, leave, with what their prior says of them."""
    n = len(priors.low)
    x = fitted(evidence, np.arange(n), priors)
    gram, pull = evidence.gram.sum(axis=0)[:n, :n], evidence.moment.sum(axis=0)[:n, 0]
    return float(evidence.energy.sum() - 2 * x @ pull + x @ gram @ x + priors.precision[:n] @ x**2)


def evaluated(setting: Setting, hypotheses: Sequence[Hypothesis], like: Fit | None = None) -> Fit:
    """Hypotheses with the values that they have: replay, residual, tangents, and what calibration can still do.

    Raises:
        FFGymError: if no machine can have them.
    """
    tried = trial_of(setting, hypotheses)
    if tried is None:
        raise FFGymError(f"No machine can have {', '.join(h.label for h in hypotheses)} with these values.")
    return with_tangents(setting, tried, like)


def with_tangents(setting: Setting, tried: Trial, like: Fit | None) -> Fit:
    """What was replayed, with columns for all numbers; but for the newest hypothesis those that `like` has serve.

    Raises:
        FFGymError: if a number can be neither higher nor lower, or slopes cannot be computed.
    """
    known = {i: of for i, h in enumerate(tried.hypotheses[:-1]) if like is not None and (of := like.tangents_of(h))}
    columns = tangents(tried.run, setting.nominal, tried.hypotheses, known) if tried.hypotheses else []
    if not all(np.isfinite(rows).all() for column in columns for rows in column.values()):
        raise FFGymError(f"Slopes of {', '.join(h.label for h in tried.hypotheses)} are beyond all numbers.")
    return Fit(
        hypotheses=tuple(tried.hypotheses),
        run=tried.run,
        residual=tried.residual,
        columns=tuple(columns),
        evidence=setting.stack.beside(columns).evidence(values_of(tried.residual)),
        priors=priors_of(setting, tried.hypotheses),
        left=tried.left,
    )


def left_by(setting: Setting, hypotheses: Sequence[Hypothesis]) -> float:
    """Energy that calibration and hypotheses with the values that they have leave, of all rows; inf if none can."""
    tried = trial_of(setting, hypotheses)
    return np.inf if tried is None else tried.left


def priors_of_calibration(setting: Setting, hypotheses: Sequence[Hypothesis]) -> Priors:
    """Calibration beside hypotheses, in standard deviations."""
    low, high = setting.calibration_limits(hypotheses)
    return Priors(precision=np.ones(len(low)), low=low, high=high)


def priors_of(setting: Setting, hypotheses: Sequence[Hypothesis]) -> Priors:
    """Calibration in standard deviations; changes of free numbers in practical steps, within their bounds."""
    known = priors_of_calibration(setting, hypotheses)
    free = [number for hypothesis in hypotheses for number in hypothesis.free()]
    low = [max(-_FAR, (number.low - number.value) / number.step) for number in free]
    high = [min(_FAR, (number.high - number.value) / number.step) for number in free]
    return Priors(
        precision=np.concatenate([known.precision, np.full(len(free), _WIDE**-2)]),
        low=np.concatenate([known.low, np.minimum(low, 0.0)]),
        high=np.concatenate([known.high, np.maximum(high, 0.0)]),
    )
