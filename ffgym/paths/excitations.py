"""Motions given for the joints: sines, constant speeds, random smooth motions, speed ladders and triangles."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_shape, check_whole
from ffgym.core.types import Array
from ffgym.paths.circles import smooth_ramp
from ffgym.paths.motion import MAX_STEPS, JointPath, Segment, sample, standstill
from ffgym.recordings import PhaseKind


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
        check_below_nyquist(np.array([frequency]), dt)  # a sample time beyond the motion is named before
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
    run = SpeedStep(velocity=velocity, duration=duration, label="constant speed")
    return speed_steps(first, [run], ramp=ramp, dwell=dwell, dt=dt, name=name)


def joint_path(name: str, segments: list[Segment], dt: float) -> JointPath:
    """Sampled motion of the joints that runs through `segments`."""
    t, q, dq, ddq, phases = sample(segments, dt)
    return JointPath(name=name, t=t, q=q, dq=dq, ddq=ddq, phases=phases)


FREQUENCIES = (0.3, 5.0)
"""Range of the sines [Hz]; chosen: around the 1 and 3 Hz of the thesis' one-axis test, below the first resonance."""


def random_multisine(
    rng: np.random.Generator,
    centre: Array,
    peak_speed: Array,
    duration: float,
    *,
    n_sines: int = 4,
    frequencies: tuple[float, float] = FREQUENCIES,
    ramp: float = 0.4,
    dwell: float = 0.1,
    dt: float = 0.004,
    name: str = "random motion",
) -> JointPath:
    r"""Sum of sines of random frequency and phase on every joint, faded in and out, with rests at both ends.

    .. math:: q_j = c_j + a_j w(t) \sum_i \sin(2 \pi f_{ij} t + \varphi_{ij})

    Frequencies are drawn log-uniformly; a_j makes the largest speed of the joint `peak_speed`; the
    fade w is a quintic, so that position, speed and acceleration are continuous.

    Args:
        rng: randomness.
        centre: joint angles about which it moves, where it starts and ends, link side [rad], shape (N,).
        peak_speed: largest speed of each joint, link side [rad/s], >= 0, shape (N,).
        duration: of the whole motion [s].
        n_sines: sines per joint.
        frequencies: lowest and highest frequency [Hz].
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
    lowest, highest = (check_number("frequency", each, unit="Hz", low=0.0, open_low=True) for each in frequencies)
    omega = 2 * np.pi * np.exp(rng.uniform(np.log(lowest), np.log(highest), size=(n_sines, len(centre))))
    phase = rng.uniform(0, 2 * np.pi, size=omega.shape)

    def sines(tau: Array) -> tuple[Array, ...]:
        return _sines(omega, phase, 1.0, tau)

    times = np.arange(0.0, moving, dt)
    size = peak_speed / np.abs(_fade(sines(times), times, moving, ramp)[1]).max(axis=0)
    return _make_faded_path(name, "random sines", centre, size, sines, moving, ramp=ramp, dwell=dwell, dt=dt)


def _fade(series: tuple[Array, ...], tau: Array, moving: float, ramp: float) -> tuple[Array, Array, Array]:
    """Fade a motion and its two derivatives, (T, N) each, at times `tau` (T,), in at 0 and out at `moving` [s]."""
    # a factor that rises from 0 to 1 within the ramp and falls at the end, and its first two derivatives
    rising = (tau < moving / 2)[:, None]
    x = np.clip(np.where(rising, tau[:, None], moving - tau[:, None]) / ramp, 0.0, 1.0)
    fade = x**3 * (10 - 15 * x + 6 * x**2)
    fade_rate = np.where(rising, 1.0, -1.0) / ramp * 30 * x**2 * (1 - x) ** 2
    fade_change = 60 * x * (1 - x) * (1 - 2 * x) / ramp**2
    sine, rate, change = series
    return (
        fade * sine,
        fade_rate * sine + fade * rate,
        fade_change * sine + 2 * fade_rate * rate + fade * change,
    )


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

    def sines(tau: Array) -> tuple[Array, ...]:
        return _sines(omega, phases, amplitude, tau)

    return _make_faded_path(name, "sines", centre, 1.0, sines, duration, ramp=ramp, dwell=dwell, dt=dt)


def _sines(omega: Array, phases: Array, amplitude: Array | float, tau: Array) -> tuple[Array, Array, Array]:
    """Sum of sines of angular frequencies and phases (F, N) at times `tau` (T,), and its derivatives, (T, N) each."""
    angle = omega * tau[:, None, None] + phases
    sines, cosines = amplitude * np.sin(angle), amplitude * np.cos(angle)
    return sines.sum(axis=1), (omega * cosines).sum(axis=1), -(omega**2 * sines).sum(axis=1)


def _make_faded_path(
    name: str,
    label: str,
    centre: Array,
    size: Array | float,
    series: Callable[[Array], tuple[Array, ...]],
    moving: float,
    *,
    ramp: float,
    dwell: float,
    dt: float,
) -> JointPath:
    """Motion about `centre`, `size` times a series that is faded in and out, with rests before and after."""

    def evaluate(tau: Array) -> tuple[Array, Array, Array]:
        q, dq, ddq = _fade(series(tau), tau, moving, ramp)
        return centre + size * q, size * dq, size * ddq

    sines = Segment(label=label, kind="motion", duration=moving, evaluate=evaluate)
    return joint_path(name, [standstill("rest 0", centre, dwell), sines, standstill("rest 1", centre, dwell)], dt)


def check_below_nyquist(frequencies: Array, dt: float) -> None:
    """Check that samples every `dt` [s] show what runs at `frequencies` [Hz], shape (F,)."""
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

    It begins at `start`, link side [rad or m], shape (N,); times are in s, > 0.
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

    def evaluate(tau: Array) -> tuple[Array, Array, Array]:
        still = np.zeros((len(tau), len(start)))
        return start + np.outer(tau, step.velocity), still + step.velocity, still

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
