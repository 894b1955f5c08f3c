"""What a fit leaves, component by component."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.evidence.fitted import fitted
from ffgym.diagnosis.fit.fit import Fit
from ffgym.diagnosis.fit.setting import Setting
from ffgym.diagnosis.measured import valid_rows
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.signatures.parts import Parts

_TOUCHED = 0.01
"""Share of a column's energy per row that counts, weighted by the noise, from which on it touches a component."""

_MUCH = 0.1
"""Share of what is above the noise that a component must have to speak for all, and of its mean to be heard at all."""

Loudness = Mapping[tuple[Channel, int], float]
"""Energy over that of noise alone, by component."""


def without_calibration(setting: Setting, fit: Fit) -> dict[Channel, Array]:
    """Residuals (R, M, C) of a fit, less what calibration errors within their bounds explain.

    Of the hypotheses as they are: beside steps that they did not take, calibration would explain something else.
    """
    sizes = fitted(fit.evidence, fit.calibration_only, fit.priors)
    rest = {channel: rows.copy() for channel, rows in fit.residual.items()}
    for column, size in zip(setting.calibration, sizes, strict=True):
        for (channel, c), rows in column.items():
            if channel in rest:
                rest[channel][:, :, c] -= size * rows
    return rest


def loudness(setting: Setting, rest: Mapping[Channel, Array]) -> Loudness:
    """Energy of a residual over that of noise alone, by component."""
    valid = valid_rows(setting.log).astype(np.float64)
    found = {}
    for channel, rows in rest.items():
        for c in range(rows.shape[2]):
            weight = np.broadcast_to(setting.weights[channel, c], valid.shape) * valid
            found[channel, c] = float(np.sum((rows[:, :, c] * weight) ** 2)) / max(int(np.count_nonzero(weight)), 1)
    return found


def excess_of(setting: Setting, fit: Fit) -> float:
    """Largest energy above that of noise of any component, as a share of that."""
    return max(loudness(setting, without_calibration(setting, fit)).values()) - 1.0


def touched(setting: Setting, columns: list[Parts], *, by_channel: bool = False) -> set[tuple[Channel, int]]:
    """Components in which columns have energy that counts: of all, or of what they have in the same channel."""
    energy: dict[tuple[Channel, int], float] = {}
    for column in columns:
        for key, rows in column.items():
            weight = np.broadcast_to(setting.weights[key], rows.shape)
            counted = max(int(np.count_nonzero(weight)), 1)
            energy[key] = energy.get(key, 0.0) + float(np.sum((weight * rows) ** 2)) / counted
    most = dict.fromkeys((channel for channel, _ in energy), 0.0 if by_channel else sum(energy.values()))
    for (channel, _), value in energy.items() if by_channel else ():
        most[channel] += value
    return {key for key, value in energy.items() if value > _TOUCHED * most[key[0]]}


@dataclass(frozen=True, kw_only=True)
class Removed:
    """What is no longer there in some components."""

    of_excess: float
    """Share of the energy above the noise, which is no more than what is left."""
    of_all: float
    """Share of all energy, noise included."""
    excess: float
    """Share of all energy that was above the noise that the floor allows for."""
    heard: int
    """Components with much above the noise: a tenth of their mean or more."""
    best: float
    """Share that is gone of the component of which most is, among those that have a tenth of all above the noise."""


def removed(
    before: Loudness, after: Loudness, where: set[tuple[Channel, int]], allowed: Loudness | None = None
) -> Removed:
    """What a cause removes from components `where`, beyond what is `allowed` for in each of them.

    Components in which no more is left than that say nothing of it, unless none says more.
    """
    free = dict.fromkeys(where, 0.0) if allowed is None else {key: allowed[key] for key in where}
    judged = {key for key in where if before[key] - 1.0 > free[key]} or where
    gone = sum(_beyond(before[key] - after[key], free[key]) for key in judged)
    total = sum(before[key] for key in judged)
    # there may be less noise than the floor allows for: what is left is then all of it
    above = {key: max(before[key] - min(1.0, after[key]), 0.0) for key in judged}
    most = sum(above.values())
    shares = {
        key: _beyond(before[key] - after[key], free[key]) / max(above[key], 1e-9)
        for key in judged
        if above[key] > _MUCH * most / max(len(judged), 1)
    }
    return Removed(
        of_excess=gone / max(most, 1e-9),
        of_all=gone / max(total, 1e-9),
        excess=max(sum(before[key] - 1.0 for key in judged), 0.0) / max(total, 1e-9),
        heard=len(shares),
        best=max((share for key, share in shares.items() if above[key] >= _MUCH * most), default=0.0),
    )


def _beyond(gone: float, allowed: float) -> float:
    """What is gone more than `allowed` for; nothing is allowed for what has come."""
    return gone if gone < 0 else max(gone - allowed, 0.0)
