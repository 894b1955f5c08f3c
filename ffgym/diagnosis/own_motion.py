"""Motions of the nominal machine under its controller, along the set-points of a log, in continuous time.

The engine's steps are semi-implicit: in each of them forces know the speed of half a step before, bristles and
integrals the motion of a whole one. All of that is of first order in the step, so that two simulations, one of which
takes steps twice as long, tell what none of any length would do (Richardson's extrapolation). Of a residual at 100
times the noise, that leaves a tenth of the noise.
"""

from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from ffgym.core.types import Array
from ffgym.diagnosis.failures import FAILED
from ffgym.diagnosis.log import Log
from ffgym.diagnosis.log.reference import reference_of, roomy
from ffgym.diagnosis.replay import Replay
from ffgym.recordings import Recording
from ffgym.robot import ModelOptions, RobotDescription
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Machine

_SAME_TIME = 1e-4
"""Share of a sample period by which times of rows may differ and still be the same."""

_THREADS = 1
"""Of the engine: a few simulations, one physics step at a time, take twice the CPU on two for a seventh less time."""

_SMOOTH = ("motor.position", "link.position", "reference.position", "tcp.position")
"""Families that are curves between samples, not straight lines: places, which masses move along."""

_LONGER, _SHORTER = (2, 1), (1, 2)
"""Longest step that is simulated in physics steps, as a ratio: the cheaper pair first, then one for machines that are
unstable with a step that is twice as long as they were described with."""


def own_motion(log: Log, run: Replay) -> list[Recording] | None:
    """What the nominal machine would have recorded; None if it cannot be simulated, as its servo does not hold it.

    Args:
        log: with set-points.
        run: its replay on the nominal machine.
    """
    for times, parts in (_LONGER, _SHORTER):
        if times == 1 or run.robot.n_substeps % times == 0:
            try:
                return _simulated(log, run, times / parts)
            except FAILED:
                continue  # unstable with such a step
    return None


def _simulated(log: Log, run: Replay, longest: float) -> list[Recording]:
    """By steps of `longest` physics steps, and of half of it, extrapolated to none."""
    robot = roomy(run.machine.robot, log.recordings)
    machine = Machine(robot=robot, effects=run.machine.effects, climate=run.machine.climate)
    runs = [Run(reference=reference_of(robot, recording)) for recording in log.recordings]
    steps = [share * run.robot.physics_dt for share in (longest, longest / 2)]
    coarse, fine = (
        simulate(
            runs,
            machine=[machine.later(float(s)) for s in log.started],
            options=ModelOptions(looks=False, physics_dt=step),
            record_dt=_record_dt(robot, max(steps), log.dt),
            n_threads=_THREADS,
        )
        for step in steps
    )
    found = [_extrapolated(*pair) for pair in zip(coarse, fine, strict=True)]
    return [_like(one, recording) for one, recording in zip(found, log.recordings, strict=True)]


def _extrapolated(coarse: Recording, fine: Recording) -> Recording:
    """Recordings by a step and by half of it, extrapolated to no step; their times are the same."""
    columns = {name: 2 * fine[name] - values for name, values in coarse.columns.items()}
    return Recording(columns=columns | {"timestamp": coarse["timestamp"]}, header=coarse.header)


def _record_dt(robot: RobotDescription, step: float, dt: float) -> float:
    """The longest sample period of a simulation that has all samples of a log, whose clock is never exact.

    The shortest one if none has them: what lies between its samples is interpolated then.
    """
    n_steps = round(robot.servo.control_dt / step)
    periods = [n * step for n in range(1, n_steps + 1) if n_steps % n == 0]
    return max((period for period in periods if _divides(period, dt)), default=periods[0])


def _divides(period: float, dt: float) -> bool:
    """Tell whether every sample of a log, `dt` apart, is one of a simulation's."""
    times = round(dt / period)
    return times >= 1 and abs(times * period - dt) <= _SAME_TIME * dt


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
    """A column at other times, from the rows at which it is known."""
    values = recording[name]
    seen = ~np.isnan(values)
    if name.startswith(_SMOOTH):
        smooth: Array = CubicSpline(recording.t[seen], values[seen])(t)
        return smooth
    straight: Array = np.interp(t, recording.t[seen], values[seen])
    return straight
