"""Motions given for the joints: the sine of the one-axis test, and constant speed for friction curves."""

from collections.abc import Sequence

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_shape
from ffgym.core.types import Array
from ffgym.paths.circles import smooth_ramp
from ffgym.paths.motion import JointPath, Segment, sample, standstill


def joint_sine(
    amplitude: Sequence[float] | Array,
    frequency: float,
    duration: float,
    *,
    centre: Sequence[float] | Array | None = None,
    dt: float = 0.004,
    name: str = "sine",
) -> JointPath:
    r"""Sine on every joint, :math:`q = q_0 + A \sin(2 \pi f t)`, thesis (4.7)-(4.8). It starts at full speed, as there.

    Args:
        amplitude: A, link side [rad], shape (N,); 0 keeps a joint still.
        frequency: f [Hz], > 0.
        duration: [s], > 0.
        centre: q_0, link side [rad], shape (N,); None is zero.
        dt: sample time [s].
        name: name of the motion.

    Raises:
        FFGymError: if an argument is out of range.
    """
    amplitude = check_shape("amplitude", amplitude, (None,))
    if amplitude.size == 0:
        raise FFGymError("amplitude is empty, must hold one amplitude in rad for each joint.")
    middle = np.zeros_like(amplitude) if centre is None else check_shape("centre", centre, amplitude.shape)
    omega = 2 * np.pi * check_number("frequency", frequency, unit="Hz", low=0.0, open_low=True)
    duration = check_number("duration", duration, unit="s", low=0.0, open_low=True)

    def evaluate(tau: Array) -> tuple[Array, Array, Array]:
        phase = omega * tau[:, None]
        return (
            middle + amplitude * np.sin(phase),
            amplitude * omega * np.cos(phase),
            -amplitude * omega**2 * np.sin(phase),
        )

    segment = Segment(label=f"sine {frequency:g} Hz", kind="motion", duration=duration, evaluate=evaluate)
    return joint_path(name, [segment], dt)


def constant_velocity(
    velocity: Sequence[float] | Array,
    duration: float,
    *,
    start: Sequence[float] | Array | None = None,
    ramp: float = 0.2,
    dwell: float = 0.3,
    dt: float = 0.004,
    name: str = "constant velocity",
) -> JointPath:
    """Every joint runs at constant speed, after and before smooth ramps with bounded jerk, and rests at both ends.

    Args:
        velocity: joint speed, link side [rad/s], shape (N,); negative runs backwards, 0 keeps a joint still.
        duration: time at constant speed [s], > 0.
        start: joint angles at the start, link side [rad], shape (N,); None is zero.
        ramp: time to reach the speed, and to stop again [s], > 0.
        dwell: rest at both ends [s], > 0.
        dt: sample time [s].
        name: name of the motion.

    Raises:
        FFGymError: if an argument is out of range, or no joint moves.
    """
    velocity = check_shape("velocity", velocity, (None,))
    if not np.any(velocity):
        raise FFGymError("velocity is zero on every joint; give at least one joint a speed in rad/s, link side.")
    first = np.zeros_like(velocity) if start is None else check_shape("start", start, velocity.shape)
    duration = check_number("duration", duration, unit="s", low=0.0, open_low=True)
    ramp = check_number("ramp", ramp, unit="s", low=0.0, open_low=True)
    dwell = check_number("dwell", dwell, unit="s", low=0.0, open_low=True)
    at_speed = first + velocity * ramp / 2
    last = at_speed + velocity * (duration + ramp / 2)

    def speed_up(tau: Array) -> tuple[Array, Array, Array]:
        travelled, rate, change = smooth_ramp(tau, ramp, 1.0)
        return first + np.outer(travelled, velocity), np.outer(rate, velocity), np.outer(change, velocity)

    def run(tau: Array) -> tuple[Array, Array, Array]:
        still = np.zeros((len(tau), len(velocity)))
        return at_speed + np.outer(tau, velocity), still + velocity, still

    def slow_down(tau: Array) -> tuple[Array, Array, Array]:
        travelled, rate, change = smooth_ramp(ramp - tau, ramp, 1.0)
        return last - np.outer(travelled, velocity), np.outer(rate, velocity), -np.outer(change, velocity)

    segments = [
        standstill("rest 0", first, dwell),
        Segment(label="speed up", kind="lead_in", duration=ramp, evaluate=speed_up),
        Segment(label="constant speed", kind="motion", duration=duration, evaluate=run),
        Segment(label="slow down", kind="lead_out", duration=ramp, evaluate=slow_down),
        standstill("rest 1", last, dwell),
    ]
    return joint_path(name, segments, dt)


def joint_path(name: str, segments: list[Segment], dt: float) -> JointPath:
    """Sampled motion of the joints that runs through `segments`."""
    t, q, dq, ddq, phases = sample(segments, dt)
    return JointPath(name=name, t=t, q=q, dq=dq, ddq=ddq, phases=phases)
