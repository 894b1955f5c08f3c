"""Rows that stand out from a misfit which is everywhere: they are kept from deciding what explains it.

Noise is the yardstick of a model that lacks one thing. Of a machine whose model misses a little everywhere, most rows
are far above the noise, and the few in which it misses much, as where a motor starts or a filter smears a reversal,
would decide by their squares what the others tell. They count as much as they would at a few times the usual misfit
(Huber 1964, Ann. Math. Statist. 35(1)). Where most rows are as quiet as noise, what stands out is what is looked for,
and stays.
"""

from collections.abc import Mapping

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.evidence.stack import Values
from ffgym.diagnosis.residual import Channel

EVERYWHERE = 5.0
"""Usual misfit, in standard deviations of the noise, from which on a model misses everywhere; chosen."""

USUAL = 3.0
"""Usual misfits from which on a row stands out; of rows with a normal distribution 0.3 % do."""

_NORMAL = 1.4826
"""Standard deviation of a normal distribution over its median absolute value."""


def bound_outliers(weights: Values, residual: Mapping[Channel, Array]) -> Values:
    """Weights (R, M) by component under which no row stands out from a misfit that is everywhere.

    Args:
        weights: one over the noise of each row, 0 for rows that do not count; (M,) or (R, M).
        residual: of the nominal model, (R, M, C) by channel.
    """
    return {key: _bound(rows, residual[key[0]][:, :, key[1]]) for key, rows in weights.items()}


def _bound(weight: Array, residual: Array) -> Array:
    usual = _usual(weight, residual)
    if usual < EVERYWHERE:
        return weight
    return weight * np.minimum(1.0, USUAL * usual / np.maximum(np.abs(weight * residual), 1e-300))


def _usual(weight: Array, residual: Array) -> float:
    """Usual misfit of rows that count, in standard deviations of the noise."""
    size = np.abs(weight * residual)
    counting = size[np.broadcast_to(weight, size.shape) > 0]
    return _NORMAL * float(np.median(counting)) if counting.size else 0.0
