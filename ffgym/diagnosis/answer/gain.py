"""Gain of the extended model: each motion by a model that was written without it, beside the nominal one."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.calibration import Calibration
from ffgym.diagnosis.evidence.folds import Fold, half_folds
from ffgym.diagnosis.fit.fit import Fit
from ffgym.diagnosis.fit.setting import Setting
from ffgym.diagnosis.fit.written import written
from ffgym.diagnosis.heap import trim_heap
from ffgym.diagnosis.residual import Channel

FOLDS = 3
"""Groups of motions that are left out in turn; each takes a fit, and a replay of all motions."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Gain:
    """Residuals (R, M, C) by channel, on motions that were not used."""

    before: Mapping[Channel, Array]
    after: Mapping[Channel, Array]
    is_better: bool
    """Whether less is left than before, in units of the noise of each row."""


def held_out_gain(setting: Setting, nominal: Fit, found: Fit, calibration: Calibration) -> Gain | None:
    """Residuals of nominal and extended model on motions that were left out of the fit; None if none could be written.

    Args:
        setting: the log.
        nominal: the model without causes.
        found: with the causes.
        calibration: how well nominal numbers are known.
    """
    before = {channel: rows.copy() for channel, rows in nominal.residual.items()}
    after = {channel: rows.copy() for channel, rows in nominal.residual.items()}
    for fold in _folds(setting):
        trim_heap()
        model = written(setting, found, calibration, fold.train)
        if model is None:
            return None
        test = _rows_of(setting, fold)
        plain = written(setting, nominal, calibration, fold.train) if calibration.refit is not None else None
        for channel, rows in model.residual.items():
            after[channel][test] = rows[test]
            if plain is not None:
                before[channel][test] = plain.residual[channel][test]
    return Gain(before=before, after=after, is_better=_energy(setting, after) < _energy(setting, before))


def _folds(setting: Setting) -> list[Fold]:
    """Groups of motions, or halves of a single one."""
    blocks = setting.blocks
    motions = np.unique(blocks.motion)
    if len(motions) < 2:
        return half_folds(blocks)
    group = np.searchsorted(motions, blocks.motion) % min(FOLDS, len(motions))
    return [Fold(train=group != k, test=group == k) for k in range(int(group.max()) + 1)]


def _rows_of(setting: Setting, fold: Fold) -> BoolArray:
    """Rows (R, M) that a fold leaves out."""
    of_row = setting.blocks.of_row
    inside: BoolArray = (of_row >= 0) & fold.test[np.maximum(of_row, 0)]
    return inside


def _energy(setting: Setting, residual: Mapping[Channel, Array]) -> float:
    """Of rows that are of blocks, in units of the noise."""
    inside = setting.blocks.of_row >= 0
    return sum(
        float(np.sum((np.broadcast_to(weight, inside.shape) * residual[channel][:, :, c])[inside] ** 2))
        for (channel, c), weight in setting.weights.items()
    )
