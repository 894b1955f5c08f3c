"""What the nominal machine would have recorded, without noise: simulated under its controller, or as it was moved."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from ffgym.diagnosis.log import Log
from ffgym.diagnosis.log.reference import reference_of
from ffgym.diagnosis.replay import Replay
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription
from ffgym.simulation import Run, simulate
from ffgym.types import Array

_SAME_MOTION = 0.1
"""RMS angle of a motor [rad] by which a simulated motion may miss the measured one. The documented servo of a robot
misses it by a thirtieth of that, whatever ails its joints; a quarter of a period of what repeats 16 times per turn."""

_SAME_TIME = 1e-4
"""Share of a sample period by which times of rows may differ and still be the same."""

_THREADS = 1
"""Of the engine: a few simulations, one physics step at a time, take twice the CPU on two for a seventh less time."""

_SMOOTH = ("motor.position", "link.position", "reference.position")
"""Families that are curves between samples, not straight lines: they are differentiated twice."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Exact:
    """Recordings of the nominal machine, one for each motion of a log."""

    recordings: tuple[Recording, ...]
    simulated: bool
    """Whether they are of its controller along the log's set-points; else the motors move as measured."""


def exact_recordings(log: Log, run: Replay) -> Exact:
    """What the nominal machine would have recorded, without noise.

    With set-points, it is simulated under its controller. Without, or where another controller moved the machine,
    it moves as measured, and takes the torque that it takes: what repeats with the motor's turns must stay in phase.

    Args:
        log: what was measured.
        run: its replay on the nominal machine.
    """
    if log.reference is not None:
        simulated = _simulated(log, run)
        if is_same_motion(log, simulated):
            return Exact(recordings=tuple(simulated), simulated=True)
    return Exact(recordings=tuple(_as_moved(log, run, i) for i in range(len(log.recordings))), simulated=False)


def is_same_motion(log: Log, exact: Sequence[Recording]) -> bool:
    """Whether motors move in exact recordings as they did in a log, where that counts."""
    drive = log.robot.drive
    for i, recording in enumerate(exact):
        n = min(len(recording), log.lengths[i])
        angle = recording.joint_array("motor.position")[:n]
        angle = drive.motor_angle(angle) if recording.header.position_side == "link" else angle
        missed = (angle - drive.motor_angle(log.q[:n, i]))[log.recordings[i].valid[:n].any(axis=1)]
        if np.sqrt(np.mean(missed**2, axis=0)).max() > _SAME_MOTION:
            return False
    return True


def _simulated(log: Log, run: Replay) -> list[Recording]:
    """Along the set-points, under the documented controller."""
    references = [reference_of(log.robot, recording) for recording in log.recordings]
    machines = [run.machine.later(float(s)) for s in log.started]
    period = _simulated_dt(log.robot, log.dt)
    found = simulate([Run(reference=r) for r in references], machine=machines, record_dt=period, n_threads=_THREADS)
    return [_like(one, recording) for one, recording in zip(found, log.recordings, strict=True)]


def _simulated_dt(robot: RobotDescription, dt: float) -> float:
    """The longest sample period of a simulation that is no longer than that of a log, whose clock is never exact."""
    steps = [n for n in range(1, robot.n_substeps + 1) if robot.n_substeps % n == 0]
    periods = [n * robot.physics_dt for n in steps]
    return max((period for period in periods if period <= (1 + _SAME_TIME) * dt), default=periods[0])


def _like(exact: Recording, like: Recording) -> Recording:
    """The rows and columns of another recording: what one must be derived from, the other must, too."""
    names = [name for name in exact.columns if name in like.columns]
    since, dt = like.t - like.t[0] + exact.t[0], like.dt
    n = int(np.searchsorted(since, exact.t[-1] + 0.5 * dt))
    if n == len(exact) and np.abs(since[:n] - exact.t).max() <= _SAME_TIME * dt:
        return Recording(columns={name: exact[name] for name in names}, header=exact.header)
    t = np.minimum(since[:n], exact.t[-1])
    columns = {name: _at(exact, name, t) for name in names}
    return Recording(columns=columns | {"timestamp": since[:n]}, header=replace(exact.header, phases=()))


def _at(recording: Recording, name: str, t: Array) -> Array:
    """A column at other times; what is not known at some rows is straight between those at which it is."""
    values = recording[name]
    if name.startswith(_SMOOTH):
        smooth: Array = CubicSpline(recording.t, values)(t)
        return smooth
    seen = ~np.isnan(values)
    straight: Array = np.interp(t, recording.t[seen], values[seen])
    return straight


def _as_moved(log: Log, run: Replay, i: int) -> Recording:
    recording, joints = log.recordings[i], log.robot.joints
    n = len(recording)
    angle = log.robot.drive.motor_angle(log.q)
    columns = {"timestamp": recording.t}
    for j, joint in enumerate(joints):
        columns[f"motor.position.{joint}"] = angle[:n, i, j]
        columns[f"motor.effort.{joint}"] = run.torque[:n, i, j]
        if log.link is not None:
            columns[f"link.position.{joint}"] = run.link_q[:n, i, j]
    header = replace(recording.header, position_side="motor", torque_semantics="motor_side", hold="sampled")
    return Recording(columns=columns, header=header)
