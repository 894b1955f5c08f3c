"""Weights of rows: torque that no replay can know, outliers, and a swing at the start count as noise.

Bristles that are not yet torn off follow ways of a few micrometres. Four things keep those from being known: the noise
of a motor that stands, in whose band it may have moved; what a motion has above the band that it was read in, as where
it stops and rings; samples so rare that a reversal lies between them; and how bristles stood when the log began.

Where a motor creeps over some steps of its encoder after a stop, noise moves the reading to and fro at the edge of each
step, and whatever of that leaves the band of `Log.trembling` loosens the bristles a little: always the same way, in all
logs of the motion, by more than the noise of the torque. What is systematic is no fault of the machine.

Noise is the yardstick of a model that lacks one thing. Of a machine whose model misses a little everywhere, most rows
are far above the noise, and the few in which it misses much, as where a motor starts or a filter smears a reversal,
would decide by their squares what the others tell. They count as much as they would at a few times the usual misfit
(Huber 1964, Ann. Math. Statist. 35(1)). Where most rows are as quiet as noise, what stands out is what is looked for,
and stays.

A log that begins right after a move, or while a brake lets go, has the arm swing on: freely, at its own frequencies and
damping. Where the springs' free motions after the first sample leave clearly less of a motion's residual, what they
take away counts as noise.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import scipy

from ffgym.core.types import Array
from ffgym.diagnosis.fit.fit import evaluate, subtract_nuisances
from ffgym.diagnosis.fit.problem import FitProblem
from ffgym.diagnosis.log import Log, assemble_log
from ffgym.diagnosis.noise import Noise, add_noise
from ffgym.diagnosis.normal_equations import Values
from ffgym.diagnosis.perturbation import Perturbation, propagate
from ffgym.diagnosis.replay import Replay
from ffgym.diagnosis.replay.states import friction_on_motors
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.sampling import without_trembling
from ffgym.diagnosis.settings import settings
from ffgym.logs.preparation import LowPass
from ffgym.recordings import Recording


def estimate_unknown_torque(run: Replay, bias: Mapping[Channel, Array]) -> Array:
    """Estimate torque that no replay can know, unsigned, at rows (R, M, N), motor side [N m].

    The `bias` (R, M, C) is what the replay does wrong along a motion that is made up between the samples.
    """
    limits = settings().noise
    log = run.read
    # the motion in half its band
    low_pass, slower = LowPass(cutoff=limits.half_band * log.sampling.motion_filter.cutoff), log.q.copy()
    for i, n in enumerate(log.lengths):
        slower[:n, i] = low_pass(log.q[:n, i], log.dt)
    narrow = _compute_friction(run, log.q, limits.half_band * log.trembling)
    slow = _compute_friction(run, slower, log.trembling)
    begun = _compute_friction(run, log.q, log.trembling, load=1.0)
    changes = [log.sampling(friction - run.bristles.torque) for friction in (narrow, slow, begun)]
    # share of what replays do wrong that is not known, as the motion between the samples is not, `dt` [s] apart
    changes.append(
        (
            min(1.0, log.dt / limits.reversal_time)
            if log.dt < limits.reversals_between_rows * limits.reversal_time
            else 0.0
        )
        * bias["torque"]
    )
    unknown: Array = np.sqrt(np.sum(np.square(changes), axis=0))
    return unknown


def _compute_friction(run: Replay, angle: Array, band: Array, load: float = 0.0) -> Array:
    """Compute friction (T, M, N) [N m] of a motion, with a half-width (N,) of the band that is taken for standing.

    Bristles begin with a `load`, as a share of what tears them off.
    """
    log = run.read
    slip = np.gradient(without_trembling(angle, band), log.dt, axis=0)
    return friction_on_motors(run.robot, slip, run.log.dq, log.dt, load).torque


def downweight(weights: Values, unknown: Mapping[Channel, Array]) -> Values:
    """Lower weights (R, M) by component so that what is unknown (R, M, C), signed or not, counts as noise.

    Weights are one over the noise of each row, 0 for rows that do not count; (M,) or (R, M).
    """
    found = dict(weights)
    for (channel, c), rows in weights.items():
        if channel in unknown and unknown[channel][:, :, c].any():
            # a motion between samples may show in the rows beside it
            about = scipy.ndimage.maximum_filter1d(
                np.abs(unknown[channel][:, :, c]), 2 * settings().noise.rows_beside + 1, axis=0
            )
            found[channel, c] = rows / np.hypot(1.0, rows * about)
    return found


def estimate_misread_friction(exact: Sequence[Recording], clean: Log, run: Replay, step: Array) -> Array:
    """Estimate mean friction of noisy readings beyond that of clean ones, at rows (R, M, N), motor side [N m].

    The noise is that of the band in which a log's reading moves, so that logs with one band have one mean: `exact`
    recordings of the nominal machine over its own motion, the same as a `clean` log with the band of the log that is
    diagnosed, its replay, and the `step` (M, N) of encoders [rad], motor side.
    """
    limits = settings().noise
    drive, none = run.robot.drive, np.zeros(step.shape)
    angle = np.broadcast_to(np.abs(drive.motor_angle(clean.reading_noise)), step.shape)
    noise = Noise(angle=angle, step=step, torque=none, tool=None, link=None, feedback=None)
    rng, total = np.random.default_rng(0), np.zeros_like(run.bristles.torque)
    for _ in range(limits.misread_draws):
        seen = [add_noise(recording, noise, i, rng) for i, recording in enumerate(exact)]
        one = assemble_log(clean.robot, seen, like=clean)
        friction = friction_on_motors(run.robot, one.slip_dq, one.dq, one.dt)
        total += friction.torque - run.bristles.torque
    rows: Array = clean.sampling(total / limits.misread_draws)
    return rows


_NORMAL = 1.4826
"""Standard deviation of a normal distribution over its median absolute value."""


def bound_outliers(weights: Values, residual: Mapping[Channel, Array]) -> Values:
    """Bound weights (R, M) so that no row of a residual (R, M, C) stands out from a misfit everywhere (Huber)."""
    limits = settings().noise
    found = dict(weights)
    for (channel, c), weight in weights.items():
        size = np.abs(weight * residual[channel][:, :, c])
        # usual misfit of rows that count, in standard deviations of the noise
        counting = size[np.broadcast_to(weight, size.shape) > 0]
        usual = _NORMAL * float(np.median(counting)) if counting.size else 0.0
        if usual >= limits.misfit_everywhere:
            found[channel, c] = weight * np.minimum(1.0, limits.outlier * usual / np.maximum(size, 1e-300))
    return found


_BEND = 1e-4
"""Deflection of which free motions are computed [rad]; chosen: any would do, they are linear."""

_INDEPENDENT = 1e-8
"""Relative size of a singular value below which a free motion is that of others."""


def fit_first_swing(problem: FitProblem) -> dict[Channel, Array]:
    """Fit free motions of springs to the residual of a log, (R, M, C) by channel; empty if joints are rigid."""
    run = problem.like
    if run.robot.drive.is_rigid.all():
        return {}
    rest = subtract_nuisances(problem, evaluate(problem, ()))
    # what arms show that are let go or knocked at the first sample: of each elastic joint one of both
    pushes = []
    for j in run.springs.elastic.tolist():
        for sample in (0, 1):  # a load that is gone after the first sample, and one that comes and goes after it
            load = np.zeros_like(run.log.q)
            load[sample, :, j] = run.springs.stiffness[j] * _BEND
            pushes.append(Perturbation(links=load))
    free = propagate(run, pushes)
    keys = [key for key in free[0] if key in problem.weights]
    found = {channel: np.zeros_like(rest[channel]) for channel in dict.fromkeys(channel for channel, _ in keys)}
    # weighted rows of all components of a motion, one after the other, as far as free motions explain them
    for m in range(len(problem.log.recordings)):
        weights = {key: np.broadcast_to(problem.weights[key], free[0][key].shape)[:, m] for key in keys}
        columns = np.stack([np.concatenate([one[k][:, m] * weights[k] for k in keys]) for one in free], axis=1)
        target = np.concatenate([rest[channel][:, m, c] * weights[channel, c] for channel, c in keys])
        sizes = np.linalg.lstsq(columns, target, rcond=_INDEPENDENT)[0]
        if np.sum((target - columns @ sizes) ** 2) > settings().noise.swing_left * np.sum(target**2):
            continue
        for channel, c in keys:
            found[channel][:, m, c] = sum(size * one[channel, c][:, m] for size, one in zip(sizes, free, strict=True))
    return found
