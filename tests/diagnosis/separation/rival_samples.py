"""Pairs of causes that look alike in many motions, at practical sizes, and how a log tells them apart."""

from functools import cache

import numpy as np

from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.log import assemble_log
from ffgym.diagnosis.replay import predict, replay
from ffgym.diagnosis.residual_rows import compute_residuals, find_valid_rows
from ffgym.diagnosis.sampling import Sampling
from ffgym.effects import EFFECTS
from ffgym.effects.parameters import Parameter
from ffgym.robot import RigidArm, load_robot
from ffgym.simulation import LaserTracker, Resolver, TorqueSensor
from ffgym.simulation.plant import Machine

SAMPLE_DT = 0.004
_NOISE = 0.002
"""White noise of the torque, as a share of each drive's peak torque."""
_TRACKER_NOISE = 7e-6


@cache
def arm_of(robot):
    return RigidArm(load_robot(robot))


def sensors_of(robot):
    torque = TorqueSensor(noise=_NOISE * robot.drive.peak_torque)
    tracker = () if robot.tool is None else (LaserTracker(noise=_TRACKER_NOISE, period=SAMPLE_DT),)
    return (Resolver(bits=20), torque, *tracker)


def noise_of(robot):
    """RMS of each channel behind the low-pass of a long log."""
    passed = np.sqrt(2 * SAMPLE_DT * Sampling.of(SAMPLE_DT, [100_000]).cutoff)
    noise = {"torque": passed * _NOISE * robot.drive.peak_torque}
    return noise if robot.tool is None else noise | {"tool": np.full(3, passed * _TRACKER_NOISE)}


def cause(name, joint):
    """An effect with half of its largest plausible size."""
    kind = EFFECTS[name]
    values = {n: np.array(_value(p)) for n, p in kind.parameters().items()}
    return Hypothesis(kind=kind, joint=joint, source=None, values=values)


def _value(p: Parameter) -> float:
    if p.role != "size":
        return p.default if p.default is not None else p.neutral if p.role == "phase" else 0.5 * (p.low + p.high)
    farthest = p.high if abs(p.high - p.neutral) >= abs(p.low - p.neutral) else p.low
    return p.neutral + 0.5 * (farthest - p.neutral)


def log_ratio(recordings, nominal: Machine, right, wrong) -> float:
    """Log-likelihood ratio of one cause to another, as fitted before, from recordings of a machine with the first."""
    log = assemble_log(nominal.robot, recordings)
    noise, valid = noise_of(nominal.robot), find_valid_rows(log)
    energy = []
    for one in (right, wrong):
        rest = compute_residuals(log, predict(replay(log, one.on(nominal))))
        energy.append(sum(float(np.sum((rest[c][valid] / rms) ** 2)) for c, rms in noise.items()))
    return 0.5 * (energy[1] - energy[0])
