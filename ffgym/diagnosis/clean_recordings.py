"""Noise-free recordings of the nominal machine: simulated under its servo, or replayed as it was moved.

A replay of such a recording misses what the replay itself does wrong; that bias is taken off all residuals.

The engine's steps are semi-implicit: in each of them forces know the speed of half a step before, bristles and
integrals the motion of a whole one. All of that is of first order in the step, so that two simulations, one of which
takes steps twice as long, tell what none of any length would do (Richardson's extrapolation). Of a residual at 100
times the noise, that leaves a tenth of the noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from ffgym.core.measures import rms
from ffgym.core.types import Array
from ffgym.diagnosis.clean_replay import replay_finely
from ffgym.diagnosis.computing import FAILED
from ffgym.diagnosis.log import Log
from ffgym.diagnosis.log_columns import build_reference, widen_limits
from ffgym.diagnosis.replay import Replay, predict_feedback
from ffgym.diagnosis.replay.channels import servo_errors
from ffgym.diagnosis.residual_rows import find_valid_rows
from ffgym.diagnosis.settings import settings
from ffgym.logs.preparation import read_motor_side
from ffgym.recordings import Recording
from ffgym.robot import ModelOptions, RobotDescription
from ffgym.simulation import Run, simulate

_NUMBERS = ("servo.position_gain", "servo.velocity_gain", "servo.integral_gain", "servo.control_dt")
"""Entries of a description without which its servo is a stand-in."""

UNKNOWN = "the description does not say what the servo is ([servo])"

FOREIGN = "the feedback torque is not that of the documented servo on reference.position, whatever its gains"


def has_servo(robot: RobotDescription) -> bool:
    """Tell whether a description states its servo; one without origins of its numbers states all that it has."""
    return not robot.quantities or all(entry in robot.quantities for entry in _NUMBERS)


def has_foreign_servo(log: Log) -> bool:
    """Tell whether the feedback torque of most joints is not that of the documented servo on the measured error.

    Neither with the documented gains, by some factor, nor with the three that suit best.
    """
    if log.feedback is None or not log.shows_servo:
        return False
    rows, valid = log.sampling, find_valid_rows(log)

    def about_mean(values: Array) -> Array:
        """Valid rows of all motions about the mean of each motion, (S, N)."""
        parts = [motion[counts] for motion, counts in zip(rows(values).swapaxes(0, 1), valid.T, strict=True)]
        return np.concatenate([part - part.mean(axis=0) for part in parts if len(part)])

    # share of the measured torque that the predicted one explains, by joint; none where they oppose each other
    measured, foretold = about_mean(log.feedback), about_mean(predict_feedback(log, log.robot))
    pairs = (measured, foretold), (measured, measured), (foretold, foretold)
    both, one, other = (np.einsum("sn,sn->n", a, b) for a, b in pairs)
    share = np.divide(both**2, one * other, out=np.ones_like(both), where=one * other > 0)
    limits = settings().replay
    if np.median(np.where(both > 0, share, 0.0)) < limits.servo_explains:
        return True
    # share that error, rate and integral leave with any gains
    errors = np.stack([about_mean(part) for part in servo_errors(log, log.robot)], axis=-1)
    left = [
        _leave_least(torque, regressors) for torque, regressors in zip(measured.T, errors.swapaxes(0, 1), strict=True)
    ]
    return bool(np.median(left) > limits.servo_leaves)


def _leave_least(values: Array, regressors: Array) -> float:
    """Share of the energy of values (S,) that a sum of regressors (S, P) leaves at least; 0 of values without any."""
    scaled = regressors / np.maximum(rms(regressors, axis=0), np.finfo(float).tiny)
    left = values - scaled @ np.linalg.lstsq(scaled, values)[0]
    return float(left @ left) / energy if (energy := float(values @ values)) > 0 else 0.0


_SAME_TIME = 1e-4
"""Share of a sample period by which times of rows may differ and still be the same."""

_SMOOTH = ("motor.position", "link.position", "reference.position", "tcp.position")
"""Families that are curves between samples, not straight lines: places, which masses move along."""

_LONGEST = (2.0, 0.5)
"""Longest step that is simulated in physics steps: the cheaper pair first, then one for machines that are unstable with
a step that is twice as long as they were described with."""


def _simulate(log: Log, run: Replay, longest: float) -> list[Recording]:
    """Simulate with steps of `longest` physics steps and of half of that, and extrapolate to a step of zero."""
    # the same runs with a coarse and a fine step
    robot = widen_limits(run.machine.robot, log.recordings)
    machine = replace(run.machine, robot=robot)
    runs = [Run(reference=build_reference(robot, recording)) for recording in log.recordings]
    steps = [share * run.robot.physics_dt for share in (longest, longest / 2)]
    coarse, fine = (
        simulate(
            runs,
            machine=[machine.later(float(s)) for s in log.started],
            options=ModelOptions(looks=False, physics_dt=step),
            record_dt=_choose_record_dt(robot, max(steps), log.dt),
            n_threads=1,  # a few simulations take twice the processor time on two for a seventh less time
        )
        for step in steps
    )
    # Richardson's extrapolation to a step of zero
    found = []
    for one, other, like in zip(coarse, fine, log.recordings, strict=True):
        columns = {name: 2 * other[name] - values for name, values in one.columns.items()}
        columns["timestamp"] = one["timestamp"]
        found.append(_resample(Recording(columns=columns, header=one.header), like))
    return found


def _choose_record_dt(robot: RobotDescription, step: float, dt: float) -> float:
    """Choose the longest sample period of a simulation that has all samples of a log, whose clock is never exact.

    The shortest one if none has them: what lies between its samples is interpolated then.
    """
    n_steps = round(robot.servo.control_dt / step)
    periods = [n * step for n in range(1, n_steps + 1) if n_steps % n == 0]
    having = [one for one in periods if round(dt / one) and abs(round(dt / one) * one - dt) <= _SAME_TIME * dt]
    return max(having, default=periods[0])


def _resample(exact: Recording, like: Recording) -> Recording:
    """Take the rows and columns of another recording, so that both are processed alike."""
    # nothing is to be interpolated where the times are the same
    columns = {name: values for name, values in exact.columns.items() if name in like.columns}
    since, dt = like.t - like.t[0] + exact.t[0], like.dt
    n = int(np.searchsorted(since, exact.t[-1] + 0.5 * dt))
    if n == len(exact) and np.abs(since[:n] - exact.t).max() <= _SAME_TIME * dt:
        return Recording(columns=columns, header=exact.header)
    # columns at other times, from the rows at which they are known
    t = np.minimum(since[:n], exact.t[-1])
    for name, values in columns.items():
        seen = ~np.isnan(values)
        if name.startswith(_SMOOTH):
            columns[name] = scipy.interpolate.CubicSpline(exact.t[seen], values[seen])(t)
        else:
            columns[name] = np.interp(t, exact.t[seen], values[seen])
    return Recording(columns=columns | {"timestamp": since[:n]}, header=replace(exact.header, phases=()))


@dataclass(frozen=True, kw_only=True, eq=False)
class CleanRecordings:
    """Recordings of the nominal machine, one for each motion of a log."""

    recordings: tuple[Recording, ...]
    simulated: bool
    """True for simulations of the controller along the log's set-points; else the motors move as measured."""


def make_clean_recordings(log: Log, run: Replay) -> CleanRecordings:
    """Make noise-free recordings of the nominal machine in continuous time.

    With set-points, it is simulated under its controller. Without, or where another controller moved the machine, or
    its own would not hold it, it moves as measured, and takes the torque that it takes: what repeats with the motor's
    turns must stay in phase.
    """
    for longest in _LONGEST if log.reference is not None and has_servo(log.robot) else ():
        if longest >= 1 and run.robot.n_substeps % longest:
            continue
        try:
            simulated = _simulate(log, run, longest)
        except FAILED:
            continue  # unstable with such a step, or its servo does not hold it
        if is_same_motion(log, simulated):
            return CleanRecordings(recordings=tuple(simulated), simulated=True)
        break
    return CleanRecordings(recordings=tuple(replay_finely(log, run)), simulated=False)


def is_same_motion(log: Log, exact: Sequence[Recording]) -> bool:
    """Tell whether motors move in clean recordings as they did in the log, on the rows that count."""
    drive = log.robot.drive
    for i, recording in enumerate(exact):
        n = min(len(recording), log.lengths[i])
        angle = read_motor_side(log.robot, recording)[:n]
        missed = (angle - drive.motor_angle(log.q[:n, i]))[log.recordings[i].valid[:n].any(axis=1)]
        if rms(missed, 0).max() > settings().replay.same_motion:
            return False
    return True
