"""How large residuals are in each component: noise alone, the nominal model, the extended one."""

from collections.abc import Mapping

import numpy as np

from ffgym.diagnosis.evidence.screen import fitted
from ffgym.diagnosis.fit.refine import Fit, Setting
from ffgym.diagnosis.measured import valid_rows
from ffgym.diagnosis.residual import UNITS, Channel, components
from ffgym.diagnosis.result import Level
from ffgym.diagnosis.search.search import Found
from ffgym.types import Array, BoolArray


def without_calibration(setting: Setting, fit: Fit) -> dict[Channel, Array]:
    """Residuals (R, M, C) of a fit, less what calibration errors within their bounds explain."""
    sizes = fitted(fit.evidence, fit.everything, fit.priors)[: fit.n_calibration]
    rest = {channel: rows.copy() for channel, rows in fit.residual.items()}
    for column, size in zip(setting.calibration, sizes, strict=True):
        for (channel, c), rows in column.items():
            if channel in rest:
                rest[channel][:, :, c] -= size * rows
    return rest


def loudness(setting: Setting, rest: Mapping[Channel, Array]) -> dict[tuple[Channel, int], float]:
    """Energy of a residual over that of noise alone, by component."""
    valid = valid_rows(setting.log).astype(np.float64)
    found = {}
    for channel, rows in rest.items():
        for c in range(rows.shape[2]):
            weight = np.broadcast_to(setting.weights[channel, c], valid.shape) * valid
            found[channel, c] = float(np.sum((rows[:, :, c] * weight) ** 2)) / max(int(np.count_nonzero(weight)), 1)
    return found


def levels(setting: Setting, found: Found, floor: Mapping[Channel, Array]) -> tuple[Level, ...]:
    """RMS of every component."""
    before = without_calibration(setting, found.nominal.fit)
    after = without_calibration(setting, found.final.fit)
    valid = valid_rows(setting.log)
    listed = []
    for channel in before:
        for c, name in enumerate(components(channel, setting.log.robot)):
            listed.append(
                Level(
                    channel=channel,
                    component=name,
                    unit=UNITS[channel],
                    noise_floor=_mean_square(floor[channel][:, c][None] + 0 * valid, valid),
                    before=_mean_square(before[channel][:, :, c], valid),
                    after=_mean_square(after[channel][:, :, c], valid),
                )
            )
    return tuple(listed)


def _mean_square(rows: Array, valid: BoolArray) -> float:
    """RMS over valid rows."""
    return float(np.sqrt(np.mean(np.broadcast_to(rows, valid.shape)[valid] ** 2)))
