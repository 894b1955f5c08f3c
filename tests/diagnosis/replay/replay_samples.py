"""Motions of an elastic arm under its controller on machines with effects, and what replays leave of them."""

from dataclasses import replace
from functools import cache

import numpy as np

from ffgym.diagnosis.log import assemble_log
from ffgym.diagnosis.replay import predict, replay
from ffgym.diagnosis.residual_rows import compute_residuals
from ffgym.paths import joint_reference, multisine
from ffgym.robot import load_robot
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Climate, Machine

WARM = Climate(ambient=20.0, rise=np.array([25.0]), time_constant=1200.0, running_since=3600.0)
SAMPLE_DT = 0.002


@cache
def nominal():
    return Machine(robot=load_robot("two_link"), climate=WARM)


@cache
def reference():
    amplitude = np.array([[0.05, 0.05], [0.025, 0.025]])
    phases = np.array([[0.0, 1.3], [2.6, 3.9]])
    path = multisine([0.3, 0.5], amplitude, [0.9, 2.1], phases, 0.9, ramp=0.3, dwell=0.1)
    return joint_reference(nominal().robot, path)


def recorded(machines, sample_dt=SAMPLE_DT):
    """One exact recording of each of several machines, by name."""
    runs = [Run(reference=reference())] * len(machines)
    found = simulate(runs, machine=list(machines.values()), record_dt=sample_dt, n_threads=1)
    return {
        name: replace(recording, header=replace(recording.header, segment=name))
        for name, recording in zip(machines, found, strict=True)
    }


def rows_left(log, machine):
    """Residuals of a log beside the replay of a machine."""
    return compute_residuals(log, predict(replay(log, machine)))


def small(kind, robot, share=0.01):
    """An effect on all joints with sizes at a share of what is plausible, and usual shapes."""
    values = {}
    for name, p in kind.parameters().items():
        if p.role == "size":
            farthest = max((p.low, p.high), key=lambda x: abs(x - p.neutral))
            values[name] = p.neutral + share * (farthest - p.neutral)
        else:
            values[name] = p.default if p.default is not None else p.low + 0.2 * (p.high - p.low)
        if p.per == "pair":
            values[name] = values[name] * (1 - np.eye(robot.n_joints))
    return kind.on(robot, **values)


def with_effect(*effects):
    return replace(nominal(), effects=effects)


def left(recordings, machine):
    """Log of recordings, and what a machine's replay leaves of it."""
    log = assemble_log(nominal().robot, recordings)
    return log, rows_left(log, machine)
