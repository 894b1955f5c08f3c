"""Hypotheses fitted to a log by replaying the machine that they make: Gauss-Newton with calibration beside them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import minimize_scalar

from ffgym.diagnosis.calibration import Doubt
from ffgym.diagnosis.evidence.fitted import fitted
from ffgym.diagnosis.evidence.priors import Priors
from ffgym.diagnosis.evidence.stack import Blocks, Evidence, Stack, Values, stack_of
from ffgym.diagnosis.fit.hypothesis import Hypothesis, machine_with, moved
from ffgym.diagnosis.fit.tangents import tangents
from ffgym.diagnosis.log import Log
from ffgym.diagnosis.measured import residual_rows
from ffgym.diagnosis.replay import Replay, predicted, replay
from ffgym.diagnosis.replay.springs import FlownAwayError
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.signatures.column import Parts
from ffgym.errors import FFGymError
from ffgym.plant import Machine
from ffgym.types import Array, IntArray

_ROUNDS = 4
"""Gauss-Newton steps at most."""

_ENOUGH = 0.01
"""Relative gain of energy below which another step is not worth a replay."""

_FAR = 3.0
"""Practical steps that a number may move in one round."""

_WIDE = 10.0
"""Standard deviation of a number in practical steps: as good as free, but not without end."""

_SIZES = (0.6, 1.0, 1.5, 2.2, 3.3)
"""Multiples of the size of a linear fit at which effects of springs are tried first."""

_SOUGHT, _FINE = (-0.3, 0.3), 0.005
"""Logarithms of the factors between which a size is sought along a line, and how finely."""

_SMALL = 0.02
"""Change, in practical steps, below which a fit has come to rest."""

_HALVINGS = 3
"""Times that a step is halved if it makes things worse."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Setting:
    """What all fits of a diagnosis share."""

    log: Log
    nominal: Machine
    blocks: Blocks
    weights: Values
    calibration: Sequence[Parts]
    """Columns per standard deviation."""
    doubts: tuple[Doubt, ...]
    """What those columns are."""
    like: Replay | None
    """Nominal replay of the log, whose parts serve other replays."""
    bias: Mapping[Channel, Array]
    """What replay and simulation of one model differ by, (R, M, C): steps of time; taken off every residual."""
    bound: float
    """Standard deviations beyond which a calibration error is none."""

    @cached_property
    def stack(self) -> Stack:
        """The calibration's columns, weighted."""
        return stack_of(self.blocks, self.calibration, self.weights)


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

    def tangents_of(self, hypothesis: Hypothesis) -> tuple[Parts, ...]:
        """Columns of a hypothesis, whatever values it has; none if it is not among these."""
        at = 0
        for own in self.hypotheses:
            n = len(own.free())
            if own.repeats(hypothesis):
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


def fit(setting: Setting, hypotheses: Sequence[Hypothesis], *, begun: bool = False, like: Fit | None = None) -> Fit:
    """Fit hypotheses to a log, from the values that they have.

    Args:
        setting: the log and what all fits share.
        hypotheses: the last of them is the newest.
        begun: whether its values are good already; else they are those of a linear fit.
        like: a fit of others among them, whose tangents serve here: they hardly change when one more comes.
    """
    best = evaluated(setting, hypotheses if begun else _well_begun(setting, hypotheses), like)
    for _ in range(_ROUNDS if hypotheses else 0):
        step, tried = _step(best), None
        for _ in range(_HALVINGS):
            tried = _trial(setting, moved(best.hypotheses, step))
            if tried is not None and tried.left < best.left:
                break
            step = 0.3 * step
        if tried is None or tried.left >= best.left:
            break
        gained = 1 - tried.left / best.left
        best = _with_tangents(setting, tried, like)
        if gained < _ENOUGH and float(np.max(np.abs(step))) < _SMALL:
            break
    return best


def polished(setting: Setting, found: Fit) -> Fit:
    """A fit with the size of its newest hypothesis sought along a line where it acts on springs, then fitted again.

    There slopes lead to the truth only from very near; a line search needs no slopes.
    """
    if not found.hypotheses or not _on_springs(found.hypotheses[-1]):
        return found
    *others, last = found.hypotheses

    def left(log_factor: float) -> float:
        return left_by(setting, [*others, last.scaled(float(np.exp(log_factor)))])

    best = minimize_scalar(left, bounds=_SOUGHT, method="bounded", options={"xatol": _FINE})
    if best.fun >= found.left:
        return found
    return fit(setting, [*others, last.scaled(float(np.exp(best.x)))], begun=True)


def _on_springs(hypothesis: Hypothesis) -> bool:
    return hypothesis.kind.needs_elasticity and hypothesis.kind.side == "link"


def _well_begun(setting: Setting, hypotheses: Sequence[Hypothesis]) -> list[Hypothesis]:
    """With the newest hypothesis at the best of several sizes where it acts on springs.

    An arm that is driven at its motors swings sharply, so that only models near the truth are led to it by slopes.
    """
    first = list(hypotheses)
    if not first or not _on_springs(first[-1]):
        return first
    tries = [[*first[:-1], first[-1].scaled(factor)] for factor in _SIZES]
    return min(tries, key=lambda one: left_by(setting, one))


def left_by(setting: Setting, hypotheses: Sequence[Hypothesis]) -> float:
    """Energy that calibration and hypotheses with the values that they have leave, of all rows; inf if none can."""
    tried = _trial(setting, hypotheses)
    return np.inf if tried is None else tried.left


@dataclass(frozen=True, kw_only=True, eq=False)
class _Trial:
    """Hypotheses with the values that they have, replayed."""

    hypotheses: Sequence[Hypothesis]
    run: Replay
    residual: Mapping[Channel, Array]
    """(R, M, C)."""
    left: float


def _trial(setting: Setting, hypotheses: Sequence[Hypothesis]) -> _Trial | None:
    """Replay of the machine with all hypotheses; None if none can have them, or its arm would not stay where it is."""
    machine = machine_with(setting.nominal, hypotheses)
    if machine is None:
        return None
    try:
        run = replay(setting.log, machine, setting.like)
    except FlownAwayError:
        return None
    rows = residual_rows(setting.log, predicted(run))
    residual = {channel: values - setting.bias[channel] for channel, values in rows.items()}
    left = _left(setting.stack.evidence(values_of(residual)), _priors(setting, ()))
    return _Trial(hypotheses=hypotheses, run=run, residual=residual, left=left)


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
    tried = _trial(setting, hypotheses)
    if tried is None:
        raise FFGymError(f"No machine can have {', '.join(h.label for h in hypotheses)} with these values.")
    return _with_tangents(setting, tried, like)


def _with_tangents(setting: Setting, tried: _Trial, like: Fit | None) -> Fit:
    known = {i: of for i, h in enumerate(tried.hypotheses[:-1]) if like is not None and (of := like.tangents_of(h))}
    columns = tangents(tried.run, setting.nominal, tried.hypotheses, known) if tried.hypotheses else []
    return Fit(
        hypotheses=tuple(tried.hypotheses),
        run=tried.run,
        residual=tried.residual,
        columns=tuple(columns),
        evidence=setting.stack.beside(columns).evidence(values_of(tried.residual)),
        priors=_priors(setting, tried.hypotheses),
        left=tried.left,
    )


def values_of(residual: Mapping[Channel, Array]) -> Values:
    """Residuals (R, M, C) by component, (R, M, 1) each."""
    return {(channel, k): rows[..., k : k + 1] for channel, rows in residual.items() for k in range(rows.shape[2])}


def _priors(setting: Setting, hypotheses: Sequence[Hypothesis]) -> Priors:
    """Calibration in standard deviations; changes of free numbers in practical steps, within their bounds."""
    n = len(setting.calibration)
    free = [number for hypothesis in hypotheses for number in hypothesis.free()]
    low = [max(-_FAR, (number.low - number.value) / number.step) for number in free]
    high = [min(_FAR, (number.high - number.value) / number.step) for number in free]
    return Priors(
        precision=np.concatenate([np.ones(n), np.full(len(free), _WIDE**-2)]),
        low=np.concatenate([np.full(n, -setting.bound), np.minimum(low, 0.0)]),
        high=np.concatenate([np.full(n, setting.bound), np.maximum(high, 0.0)]),
    )


def _step(now: Fit) -> Array:
    """Change of the free numbers, in practical steps."""
    x = fitted(now.evidence, now.everything, now.priors)
    step: Array = x[now.n_calibration :]
    return step
