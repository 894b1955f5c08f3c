"""Slip elements: memory of a motor's last turn and of how far it has come since, which is what friction remembers."""

import numpy as np

from ffgym.core.types import Array

WIDTHS = np.array([0.002, 0.004, 0.008, 0.016, 0.032])
"""Motor travel [rad] after which an element slips. Chosen: octaves around 8 mrad, over which the bristles of the
built-in robots bend; five cover presliding between a quarter and four times of that, and which of them matter is
learned."""


def advanced(slip: Array, dq: Array, next_dq: Array, dt: float, widths: Array = WIDTHS) -> Array:
    r"""Elements (..., N, W), from -1 to 1, a step of `dt` [s] later; the motor speed runs straight between (..., N).

    Each is a spring that slips beyond its width w, the stop operator of Prandtl's model of presliding friction:

    .. math:: s_+ = \min(\max(s + \Delta q / w, -1), 1)

    A weighted sum of them is a hysteresis loop with memory of the loops within it (Krasnosel'skii & Pokrovskii 1989,
    "Systems with Hysteresis").
    """
    return _slipped(slip, _steps(dq, next_dq, dt, widths))


def along(motor_dq: Array, dt: float, widths: Array = WIDTHS) -> Array:
    """Elements along motor speeds (T, N) [rad/s] sampled every `dt` [s], shape (T, N, W); relaxed at the start."""
    start = np.zeros((*motor_dq.shape[1:], len(widths)))
    return np.concatenate([start[None], _slipped_along(start, _steps(motor_dq[:-1], motor_dq[1:], dt, widths))])


def advanced_along(dq: Array, dt: float, widths: Array) -> Array:
    """Elements after each of T steps at speeds (T, ..., N), relaxed before; as `advanced` step by step."""
    steps = _steps(dq, dq, dt, widths)
    return _slipped_along(np.zeros(steps.shape[1:]), steps)


def _slipped_along(slip: Array, steps: Array) -> Array:
    """Elements after each of the `steps` (T, ..., W), from `slip` on."""
    found = steps.copy()
    for now in found:
        now += slip
        np.maximum(now, -1.0, out=now)
        np.minimum(now, 1.0, out=now)
        slip = now
    return found


def _steps(dq: Array, next_dq: Array, dt: float, widths: Array) -> Array:
    """Travel in widths, (..., N, W)."""
    travel = 0.5 * dt * (dq + next_dq)
    return np.asarray(travel[..., None] / widths)


def _slipped(slip: Array, step: Array) -> Array:
    return np.minimum(np.maximum(slip + step, -1.0), 1.0)  # np.clip takes three times as long in a loop
