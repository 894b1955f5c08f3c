"""Sums of given sines on the joints: excitation for identification."""

from collections.abc import Sequence

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_shape
from ffgym.core.types import Array
from ffgym.paths.joint_space import joint_path
from ffgym.paths.motion import JointPath, Segment, standstill
from ffgym.paths.random_motion import faded


def multisine(
    centre: Sequence[float] | Array,
    amplitude: Array,
    frequencies: Sequence[float] | Array,
    phases: Array,
    duration: float,
    *,
    ramp: float = 0.4,
    dwell: float = 0.3,
    dt: float = 0.004,
    name: str = "multisine",
) -> JointPath:
    r"""Sum of sines on every joint, faded in and out, with rests at both ends.

    .. math:: q_j = c_j + w(t) \sum_i a_{ij} \sin(2 \pi f_i t + \varphi_{ij})

    Args:
        centre: c, joint positions about which it moves, where it starts and ends, link side [rad or m], shape (N,).
        amplitude: a, link side [rad or m], shape (F, N); 0 keeps a joint still.
        frequencies: f [Hz], > 0, shape (F,).
        phases: phi [rad], shape (F, N), e.g. from `schroeder_phases`.
        duration: of the sines with their fades [s], at least two ramps.
        ramp: time of fading in, and of fading out [s], > 0.
        dwell: rest at both ends [s], > 0.
        dt: sample time [s], at most `ramp`.
        name: name of the motion.

    Raises:
        FFGymError: if an argument is out of range, or `duration` is too short for the ramps.
    """
    centre = check_shape("centre", centre, (None,))
    frequencies = check_shape("frequencies", frequencies, (None,))
    if not len(centre) or not len(frequencies) or np.any(frequencies <= 0):
        raise FFGymError(f"frequencies = {frequencies.tolist()} Hz must be > 0, at least one, for at least one joint.")
    ramp = check_number("ramp", ramp, unit="s", low=0.0, open_low=True)
    dt = check_number("dt", dt, unit="s", low=0.0, high=ramp, open_low=True)
    check_below_nyquist(frequencies, dt)
    shape = (len(frequencies), len(centre))
    amplitude, phases = check_shape("amplitude", amplitude, shape), check_shape("phases", phases, shape)
    duration = check_number("duration", duration, unit="s", low=2 * ramp)
    dwell = check_number("dwell", dwell, unit="s", low=0.0, open_low=True)
    omega = 2 * np.pi * frequencies[:, None]

    def evaluate(tau: Array) -> tuple[Array, Array, Array]:
        angle = omega * tau[:, None, None] + phases
        sines, cosines = amplitude * np.sin(angle), amplitude * np.cos(angle)
        series = (sines.sum(axis=1), (omega * cosines).sum(axis=1), -(omega**2 * sines).sum(axis=1))
        q, dq, ddq = faded(series, tau, duration, ramp)
        return centre + q, dq, ddq

    segments = [
        standstill("rest 0", centre, dwell),
        Segment(label="sines", kind="motion", duration=duration, evaluate=evaluate),
        standstill("rest 1", centre, dwell),
    ]
    return joint_path(name, segments, dt)


def check_below_nyquist(frequencies: Array, dt: float) -> None:
    """Check that samples every `dt` [s] show what runs at `frequencies` [Hz], shape (F,).

    Raises:
        FFGymError: if one is not below half the sample rate.
    """
    if not np.all(frequencies < 0.5 / dt):
        raise FFGymError(
            f"frequencies = {frequencies.tolist()} Hz must be below half the sample rate, which is {0.5 / dt:g} Hz at "
            f"dt = {dt} s."
        )


def schroeder_phases(n_sines: int, n_joints: int) -> Array:
    r"""Phases [rad] that keep the peak of a sum of equal harmonics low, shape (F, N).

    .. math:: \varphi_{ij} = -\pi \frac{i (i - 1)}{F} - 2 \pi i \frac{j}{N}, \quad i = 1..F, \; j = 0..N - 1

    The second part delays joint j by j / N of the period, so that no two joints move alike.

    Reference:
        Schroeder (1970), IEEE Trans. Information Theory 16(1), 85-89.
    """
    i, j = np.arange(1, n_sines + 1)[:, None], np.arange(n_joints)
    return -np.pi * i * (i - 1) / n_sines - 2 * np.pi * i * j / n_joints
