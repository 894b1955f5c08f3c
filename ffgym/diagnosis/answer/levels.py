"""How large residuals are in each component: noise alone, the nominal model, the extended one."""

from collections.abc import Mapping

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.fit.setting import Setting
from ffgym.diagnosis.measured import counting_rows, measured_rows
from ffgym.diagnosis.residual import UNITS, Channel, components
from ffgym.diagnosis.result import Level


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
            listed.append(
                Level(
                    channel=channel,
                    component=name,
                    unit=UNITS[channel],
                    measured=_about_mean(measured[channel][:, :, c], valid),
                    noise_floor=_mean_square(floor[channel][:, c][None] + 0 * valid, valid),
                    before=_mean_square(before[channel][:, :, c], valid),
                    after=_mean_square(after[channel][:, :, c], valid),
                )
            )
    return tuple(listed)


def _about_mean(rows: Array, valid: BoolArray) -> float:
    """RMS over rows that count, less their mean."""
    return float(np.std(rows[valid]))


def _mean_square(rows: Array, valid: BoolArray) -> float:
    """RMS over rows that count."""
    return float(np.sqrt(np.mean(np.broadcast_to(rows, valid.shape)[valid] ** 2)))
