"""Joints that run at one constant speed after another: speed ladders and triangles, for friction."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_shape, check_whole
from ffgym.core.types import Array
from ffgym.paths.circles import smooth_ramp
from ffgym.paths.joint_space import joint_path
from ffgym.paths.motion import JointPath, Segment, standstill
from ffgym.recordings import PhaseKind

PEAK = 0.3125
"""Way that a joint still goes before it turns, in a reversal from v to -v within T, in units of v T: the integral of
1 - 2 (3 x^2 - 2 x^3) to x = 1/2."""


MOST_PERIODS = 1000
"""Most periods of a triangle; more are surely a slip."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SpeedStep:
    """A time at constant speed, or at rest."""

    velocity: Array
    """Link side [rad/s or m/s], shape (N,)."""
    duration: float
    """[s], > 0."""
    label: str


def speed_steps(
    start: Array, steps: Sequence[SpeedStep], *, ramp: float, dwell: float, dt: float, name: str
) -> JointPath:
    """Constant speeds one after the other, with ramps of bounded jerk between them and rests at both ends.

    Args:
        start: joint positions at the start, link side [rad or m], shape (N,).
        steps: one or more.
        ramp: time of each change of speed [s], > 0.
        dwell: rest at both ends [s], > 0.
        dt: sample time [s].
        name: name of the motion.

    Raises:
        FFGymError: if a time is not positive.
    """
    ramp = check_number("ramp", ramp, unit="s", low=0.0, open_low=True)
    dwell = check_number("dwell", dwell, unit="s", low=0.0, open_low=True)
    still = np.zeros_like(start)
    q, before = start, still
    segments = [standstill("rest 0", start, dwell)]
    for step in steps:
        check_number(f"duration of {step.label}", step.duration, unit="s", low=0.0, open_low=True)
        segments += [_change(q, before, step.velocity, ramp), _run(q + ramp * (before + step.velocity) / 2, step)]
        q, before = q + ramp * (before + step.velocity) / 2 + step.duration * step.velocity, step.velocity
    segments.append(_change(q, before, still, ramp))
    segments.append(standstill("rest 1", q + ramp * before / 2, dwell))
    return joint_path(name, segments, dt)


def speed_ladder(
    start: Sequence[float] | Array,
    velocities: Array,
    travel: Array,
    *,
    longest: float = 10.0,
    ramp: float = 0.2,
    dwell: float = 0.3,
    dt: float = 0.004,
    name: str = "ladder",
) -> JointPath:
    """One joint after the other runs at constant speeds, each forwards and back to where it was, thesis (6.2)-(6.3).

    Half the difference of the torques of both directions is friction: gravity is the same in both.

    Args:
        start: joint positions at the start and the end, link side [rad or m], shape (N,).
        velocities: speeds of each joint, link side [rad/s or m/s], >= 0, shape (K, N); 0 skips a step of a joint.
        travel: way of each joint at constant speed, link side [rad or m], > 0, shape (N,).
        longest: time after which a slow run turns back [s], > 0.
        ramp: time of each change of speed [s], > 0.
        dwell: rest at both ends and where a joint has come back [s], > 0.
        dt: sample time [s].
        name: name of the motion.

    Raises:
        FFGymError: if an argument is out of range, or no joint moves.
    """
    start = check_shape("start", start, (None,))
    velocities = check_shape("velocities", velocities, (None, len(start)))
    travel = check_shape("travel", travel, start.shape)
    longest = check_number("longest", longest, unit="s", low=0.0, open_low=True)
    if np.any(velocities < 0) or not np.any(velocities) or np.any(travel <= 0):
        raise FFGymError("A ladder needs speeds >= 0, one of them > 0, and a travel > 0 for every joint.")
    steps = []
    for j in range(len(start)):
        for i, speed in enumerate(velocities[:, j]):
            if speed > 0:
                duration, label = min(travel[j] / speed, longest), f"joint {j + 1} step {i + 1}"
                velocity = speed * np.eye(len(start))[j]
                steps.append(SpeedStep(velocity=velocity, duration=duration, label=f"{label} forwards"))
                steps.append(SpeedStep(velocity=-velocity, duration=duration, label=f"{label} back"))
                steps.append(SpeedStep(velocity=0 * velocity, duration=dwell, label=f"{label} rest"))
    return speed_steps(start, steps[:-1], ramp=ramp, dwell=dwell, dt=dt, name=name)


def triangle(
    centre: Sequence[float] | Array,
    amplitude: Array,
    period: float,
    n_periods: int = 2,
    *,
    ramp: float = 0.2,
    dwell: float = 0.3,
    dt: float = 0.004,
    name: str = "triangle",
) -> JointPath:
    """Joints move to and fro at constant speed, with rounded reversals of bounded jerk; for presliding and hysteresis.

    Args:
        centre: joint positions in the middle, where it starts and ends, link side [rad or m], shape (N,).
        amplitude: largest way from the centre, link side [rad or m], shape (N,); 0 keeps a joint still.
        period: time of one to and fro [s], more than 4 ramps.
        n_periods: how many of them.
        ramp: time of each reversal [s], > 0.
        dwell: rest at both ends [s], > 0.
        dt: sample time [s].
        name: name of the motion.

    Raises:
        FFGymError: if an argument is out of range, or no joint moves.
    """
    centre = check_shape("centre", centre, (None,))
    amplitude = check_shape("amplitude", amplitude, centre.shape)
    ramp = check_number("ramp", ramp, unit="s", low=0.0, open_low=True)
    period = check_number("period", period, unit="s", low=4 * ramp, open_low=True)
    n_periods = check_whole("n_periods", n_periods, low=1, high=MOST_PERIODS)
    if not np.any(amplitude):
        raise FFGymError("amplitude is zero on every joint; give at least one joint an amplitude.")
    half = period / 2 - ramp  # at constant speed, between two reversals
    velocity = 2 * amplitude / (half + 2 * PEAK * ramp)
    ends = float((half + 2 * PEAK * ramp) / 2 - (0.5 + PEAK) * ramp)  # from the centre, after a ramp from rest
    durations = [ends, *[half] * (2 * n_periods - 1), ends]
    steps = [
        SpeedStep(velocity=(-1) ** i * velocity, duration=duration, label=f"slope {i + 1}")
        for i, duration in enumerate(durations)
    ]
    return speed_steps(centre, steps, ramp=ramp, dwell=dwell, dt=dt, name=name)


def _run(start: Array, step: SpeedStep) -> Segment:
    """Constant speed from `start`."""
    still = np.zeros((1, len(start)))

    def evaluate(tau: Array) -> tuple[Array, Array, Array]:
        rows = np.zeros((len(tau), len(start)))
        return start + np.outer(tau, step.velocity), rows + step.velocity, rows + still

    kind: PhaseKind = "motion" if np.any(step.velocity) else "standstill"
    return Segment(label=step.label, kind=kind, duration=step.duration, evaluate=evaluate)


def _change(start: Array, before: Array, after: Array, ramp: float) -> Segment:
    """Speed changes from `before` to `after`, from `start`."""

    def evaluate(tau: Array) -> tuple[Array, Array, Array]:
        travelled, rate, change = smooth_ramp(tau, ramp, 1.0)
        rise = after - before
        return (
            start + np.outer(np.clip(tau, 0.0, ramp), before) + np.outer(travelled, rise),
            before + np.outer(rate, rise),
            np.outer(change, rise),
        )

    from_rest, to_rest = not np.any(before), not np.any(after)
    kind: PhaseKind = "lead_in" if from_rest else "lead_out" if to_rest else "motion"
    label = "speed up" if from_rest else "slow down" if to_rest else "reversal"
    if from_rest and to_rest:
        label, kind = "rest", "standstill"
    return Segment(label=label, kind=kind, duration=ramp, evaluate=evaluate)
