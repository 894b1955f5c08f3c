"""Channels whose samples are written late."""

from collections.abc import Sequence

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.log import Log
from ffgym.effects import ClockEffect
from ffgym.effects.effect import Effect

FAMILY = {"torque": "motor.effort", "link": "link.position"}
"""Family of columns that each channel is read from."""


def late(values: Array, channel: str, effects: Sequence[Effect], log: Log) -> Array:
    """Values (T, M, N) of a channel as `effects` let them be written; the same array if none concerns it."""
    for effect in effects:
        if isinstance(effect, ClockEffect) and FAMILY.get(channel) in effect.families:
            values = np.stack([_late(values[:, i], effect, log, len(r)) for i, r in enumerate(log.recordings)], axis=1)
    return values


def in_step(values: Array, channel: str, effects: Sequence[Effect], dt: float) -> Array:
    """Measured values (T, ...) of a channel as they were sampled, beside positions of the same instants."""
    for effect in effects:
        if isinstance(effect, ClockEffect) and FAMILY.get(channel) in effect.families:
            values = effect.in_step(values, dt)
    return values


def _late(values: Array, effect: ClockEffect, log: Log, n: int) -> Array:
    """One motion, whose padding stays."""
    written = values.copy()
    written[:n] = effect.late(values[:n], log.dt)
    return written
