"""Columns that say the same in different words, as one quantity: motion as positions, torque as motor torque."""

from functools import lru_cache

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.logs.quality.kinship import Signals
from ffgym.logs.quality.log import EXCITED, Log

_WINDOW = 0.01
"""Time [s] over which increments are taken: noise of single rows averages out, no planned motion turns around in it."""

_SLACK = 0.01
"""Difference [rad or m, link side] that servo errors, friction and elasticity may leave between set-points, motors and
links: recorded robots stay below 5 mrad, a joint that sticks in a small motion does too."""

LAG_SPAN = 0.3
"""Largest delay [s] that is looked for: beyond, periodic motions fit themselves again."""


@lru_cache(maxsize=4)
def motion_signals(log: Log) -> Signals:
    """All that says how the joints move, as link-side positions."""
    values = log.motions
    moved = [np.ptp(x, axis=0) > EXCITED for x in values.values()]
    judged = np.any(moved, axis=0) if moved else np.zeros(len(log.joints), dtype=np.bool_)
    return _signals(log, values, _SLACK, judged, noisy=False)


@lru_cache(maxsize=4)
def torque_signals(log: Log) -> Signals:
    """What says how large the motor torque is: measured, commanded, and the sum of the parts of the command."""
    recording = log.recording
    parts = [name for name in ("feedforward", "feedback", "compensation") if recording.has(f"{name}.effort")]
    values = {
        family: recording.joint_array(family) for family in ("motor.effort", "command.effort") if recording.has(family)
    }
    if {"feedforward", "feedback"} <= set(parts):
        values["+".join(f"{part}.effort" for part in parts)] = np.sum(
            [recording.joint_array(f"{part}.effort") for part in parts], axis=0
        )
    moves = np.array(
        [any(np.ptp(x[:, j]) > 0 for x in values.values()) for j in range(len(log.joints))], dtype=np.bool_
    )
    return _signals(log, values, 0.0, moves & log.excited, noisy=True)


def _signals(log: Log, values: dict[str, Array], slack: float, judged: BoolArray, *, noisy: bool) -> Signals:
    window = min(log.rows(_WINDOW), len(log.t) - 1)
    lags = min(max(3, round(LAG_SPAN / log.dt)), len(log.t) // 4)
    ratio = np.asarray(log.recording.header.gear_ratio)
    return Signals(values=values, ratio=ratio, judged=judged, window=window, lags=lags, slack=slack, noisy=noisy)
