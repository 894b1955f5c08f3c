"""The band of a log that a rigid model can be compared in: where its motion lies, and what repeats with its motors.

Of a rigid arm nothing above its planned motion is known but ripple: what else is there, flexible modes and noise of
derivatives, would fill the residual, and no cause could explain much of it. An arm that is described as elastic knows
its modes, and is compared up to the usual band.
"""

import numpy as np
import scipy

from ffgym.core.measures import rms
from ffgym.core.types import Array
from ffgym.diagnosis.log import Log
from ffgym.diagnosis.noise import compute_torque_noise
from ffgym.diagnosis.patterns.periodic import PerTurn
from ffgym.diagnosis.patterns.rows import TO_HALF, collect_pattern_rows
from ffgym.diagnosis.patterns.significance import judge_form
from ffgym.diagnosis.replay import Replay, predict, replay
from ffgym.diagnosis.residual_rows import assemble_residual, compute_residuals, find_counting_rows
from ffgym.diagnosis.sampling import estimate_noise_above_band
from ffgym.diagnosis.settings import settings
from ffgym.simulation.plant import Machine

_SURE, _RIPPLES = 1e-3, 0.1
"""Probability by chance below which, and share of what is above the narrow band from which on, it is ripple."""


def choose_cutoff(log: Log, machine: Machine) -> float:
    """Cut-off [Hz] of what is compared: the usual one, or a lower one above which a rigid model knows nothing."""
    limits = settings().sampling
    usual = log.sampling.cutoff
    if not machine.physical.drive.is_rigid.all():
        return usual
    narrow = max(limits.lowest_cutoff, limits.harmonics * compute_motion_bandwidth(log))
    if limits.narrower * narrow > usual:
        return usual
    run = replay(log.torque_alone, machine)
    # what the model leaves of the torque above the narrow band, rows (R, M, N)
    rest = compute_residuals(run.log, predict(run))["torque"]
    width = TO_HALF / (narrow * run.log.sampling.row_dt)
    above = rest - scipy.ndimage.gaussian_filter1d(rest, width, axis=0, mode="nearest")
    # noise of torque and angle makes as much, at most, where nothing else is there
    floor, counting, ratio = compute_torque_noise(run), find_counting_rows(run.log), []
    for j in range(above.shape[2]):
        over = (above[..., j] / floor[:, j])[counting["torque", j]]
        ratio.append(rms(over) if over.size else 0.0)
    return usual if max(ratio) < limits.above_noise or _is_ripple(run, above) else narrow


def compute_motion_bandwidth(log: Log) -> float:
    """Frequency [Hz] below which nearly all power of the speed of every joint lies, noise of the reading taken off."""
    limits = settings().sampling
    # mean spectrum of the angles, less that of white noise
    total, frequency = 0.0, np.zeros(1)
    longest = max(log.lengths)
    width = min(round(limits.spectrum_segment / log.dt), longest)
    for i, n in enumerate(log.lengths):
        q = log.q[:n, i]
        if n < width // 4:
            continue
        padded = np.concatenate([q, np.repeat(q[-1:], max(0, width - n), axis=0)])
        frequency, power = scipy.signal.welch(padded, fs=1 / log.dt, nperseg=width, axis=0, detrend="constant")
        white = 2 * log.dt * estimate_noise_above_band(q, log.sampling.motion_filter, log.dt) ** 2
        total = total + n * np.maximum(power - white, 0.0)
    # frequency below which nearly all power of every joint's speed lies
    speed = np.asarray(total) * frequency[:, None] ** 2
    speed = speed[:, speed.sum(axis=0) > 0]
    if not speed.size:
        return 0.0
    share = np.cumsum(speed, axis=0) / speed.sum(axis=0)
    return float(frequency[np.argmax(share > limits.motion_power, axis=0)].max())


def _is_ripple(run: Replay, above: Array) -> bool:
    """Tell whether torque (R, M, N) repeats with the turns of a motor, on halves of motions that were not used."""
    residual = assemble_residual(run.log, run, {"torque": above}, {"torque": compute_torque_noise(run)})
    rows = collect_pattern_rows(residual, "torque", np.random.default_rng(0))
    if rows is None:
        return False
    values = rows.centre(rows.values)
    energy = np.maximum(np.sum(values**2, axis=0), np.finfo(np.float64).tiny)
    for j in range(values.shape[1]):
        trial = judge_form(PerTurn(joint=j), rows, values, [j])
        if trial.p[j] < _SURE and trial.gain[:, j].sum() > _RIPPLES * energy[j]:
            return True
    return False
