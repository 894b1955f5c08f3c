"""Random smooth motions of the joints, for training that should not depend on one path."""

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_shape, check_whole
from ffgym.core.types import Array
from ffgym.paths.joint_space import joint_path
from ffgym.paths.motion import MAX_STEPS, JointPath, Segment, standstill

FREQUENCIES = (0.3, 5.0)
"""Range of the sines [Hz]; chosen: around the 1 and 3 Hz of the thesis' one-axis test, below the first resonance."""


def random_multisine(
    rng: np.random.Generator,
    centre: Array,
    peak_speed: Array,
    duration: float,
    *,
    n_sines: int = 4,
    ramp: float = 0.4,
    dwell: float = 0.1,
    dt: float = 0.004,
    name: str = "random motion",
) -> JointPath:
    r"""Sum of sines of random frequency and phase on every joint, faded in and out, with rests at both ends.

    .. math:: q_j = c_j + a_j w(t) \sum_i \sin(2 \pi f_{ij} t + \varphi_{ij})

    Frequencies are drawn log-uniformly from FREQUENCIES; a_j makes the largest speed of the joint `peak_speed`; the
    fade w is a quintic, so that position, speed and acceleration are continuous.

    Args:
        rng: randomness.
        centre: joint angles about which it moves, where it starts and ends, link side [rad], shape (N,).
        peak_speed: largest speed of each joint, link side [rad/s], >= 0, shape (N,).
        duration: of the whole motion [s].
        n_sines: sines per joint.
        ramp: time of fading in, and of fading out [s].
        dwell: rest at both ends [s].
        dt: sample time [s], at most `ramp`.
        name: name of the motion.

    Raises:
        FFGymError: if an argument is out of range, or `duration` is too short for the ramps.
    """
    centre = check_shape("centre", centre, (None,))
    peak_speed = check_shape("peak_speed", peak_speed, centre.shape)
    n_sines = check_whole("n_sines", n_sines, low=1)
    ramp = check_number("ramp", ramp, unit="s", low=0.0, open_low=True)
    dwell = check_number("dwell", dwell, unit="s", low=0.0, open_low=True)
    duration = check_number("duration", duration, unit="s")
    dt = check_number("dt", dt, unit="s", low=0.0, high=ramp, open_low=True)
    if centre.size == 0:
        raise FFGymError("centre is empty, must hold one angle in rad for each joint.")
    if np.any(peak_speed < 0):
        raise FFGymError(f"peak_speed = {peak_speed} rad/s must be >= 0 on every joint.")
    moving = duration - 2 * dwell
    if moving < 2 * ramp:
        raise FFGymError(f"duration = {duration} s must be at least two ramps and two rests, {2 * (ramp + dwell):g} s.")
    if duration > MAX_STEPS * dt:
        raise FFGymError(f"duration = {duration} s must be at most {MAX_STEPS:g} steps of dt = {dt} s.")
    omega = 2 * np.pi * np.exp(rng.uniform(np.log(FREQUENCIES[0]), np.log(FREQUENCIES[1]), size=(n_sines, len(centre))))
    phase = rng.uniform(0, 2 * np.pi, size=omega.shape)

    def unscaled(tau: Array) -> tuple[Array, Array, Array]:
        angle = omega * tau[:, None, None] + phase
        sines = np.sin(angle)
        series = tuple(part.sum(axis=1) for part in (sines, omega * np.cos(angle), -(omega**2) * sines))
        return faded(series, tau, moving, ramp)

    fastest = np.abs(unscaled(np.arange(0.0, moving, dt))[1]).max(axis=0)
    size = peak_speed / fastest

    def evaluate(tau: Array) -> tuple[Array, Array, Array]:
        q, dq, ddq = unscaled(tau)
        return centre + size * q, size * dq, size * ddq

    segments = [
        standstill("rest 0", centre, dwell),
        Segment(label="random sines", kind="motion", duration=moving, evaluate=evaluate),
        standstill("rest 1", centre, dwell),
    ]
    return joint_path(name, segments, dt)


def faded(series: tuple[Array, ...], tau: Array, moving: float, ramp: float) -> tuple[Array, Array, Array]:
    """A motion and its first two derivatives, (T, N) each, multiplied by a fade that is 1 but for its two ends.

    Args:
        series: position, velocity and acceleration at times `tau` (T,) since the start [s].
        tau: within [0, moving].
        moving: when it ends [s].
        ramp: time of fading in, and of fading out [s].
    """
    fade, fade_rate, fade_change = (part[:, None] for part in _fade(tau, moving, ramp))
    sine, rate, change = series
    return (
        fade * sine,
        fade_rate * sine + fade * rate,
        fade_change * sine + 2 * fade_rate * rate + fade * change,
    )


def _fade(tau: Array, moving: float, ramp: float) -> tuple[Array, Array, Array]:
    """A factor that rises from 0 to 1 within `ramp` [s] and falls at the end, and its first two derivatives."""
    rising = tau < moving / 2
    x = np.clip(np.where(rising, tau, moving - tau) / ramp, 0.0, 1.0)
    sign = np.where(rising, 1.0, -1.0)
    return (
        x**3 * (10 - 15 * x + 6 * x**2),
        sign / ramp * 30 * x**2 * (1 - x) ** 2,
        60 * x * (1 - x) * (1 - 2 * x) / ramp**2,
    )
