"""Torque that no replay can know, as friction remembers motion that the log does not show: it counts as noise.

Bristles that are not yet torn off follow ways of a few micrometres. Four things keep those from being known: the noise
of a motor that stands, in whose band it may have moved; what a motion has above the band that it was read in, as where
it stops and rings; samples so rare that a reversal lies between them; and how bristles stood when the log began.
"""

from collections.abc import Mapping

import numpy as np
from scipy.ndimage import maximum_filter1d

from ffgym.core.types import Array
from ffgym.diagnosis.evidence.stack import Values
from ffgym.diagnosis.identification import LowPass
from ffgym.diagnosis.log.white import without_trembling
from ffgym.diagnosis.replay import Replay
from ffgym.diagnosis.replay.bristles import along_speed
from ffgym.diagnosis.residual import Channel

_HALF = 0.5
"""Share of both bands that is tried beside them: friction that half a band hides is as large as what a whole one does,
to a factor of two; chosen."""

_REVERSAL = 7e-3
"""Time that a reversal takes in a motion without parts above 100 Hz [s]: samples so far apart tell nothing of it."""

_PASSED = 4.0
"""Sample periods, in reversals, from which on these lie between samples; chosen between two recordings: friction of
the ball screw is named at 4 ms with the doubt alone, the late row of the KR300 at 100 ms without it alone."""

_NEAR = 1
"""Rows on either side of one in which a motion between samples may show; chosen."""


def unknown_torque(run: Replay, bias: Mapping[Channel, Array]) -> Array:
    """Torque that may be there or not, unsigned, at rows (R, M, N), motor side [N m].

    Args:
        run: replay of a log.
        bias: of torques, motor side, and of all else, (R, M, C) by channel: what the replay does wrong along a motion
            that is made up between the samples.
    """
    log = run.read
    narrow = _friction(run, log.q, _HALF * log.trembling)
    slow = _friction(run, _slower(run), log.trembling)
    begun = _friction(run, log.q, log.trembling, load=1.0)
    changes = [log.sampling(friction - run.bristles.torque) for friction in (narrow, slow, begun)]
    changes.append(_between_samples(log.dt) * bias["torque"])
    unknown: Array = np.sqrt(np.sum(np.square(changes), axis=0))
    return unknown


def _friction(run: Replay, angle: Array, band: Array, load: float = 0.0) -> Array:
    """Friction (T, M, N) if motors had moved so, to a half-width (N,) of what is taken for standing, [N m].

    Bristles begin with a `load`, as a share of what tears them off.
    """
    log, drive = run.read, run.robot.drive
    slip = np.gradient(without_trembling(angle, band), log.dt, axis=0)
    return along_speed(run.robot.friction, drive.motor_angle(slip), drive.motor_angle(run.log.dq), log.dt, load).torque


def _slower(run: Replay) -> Array:
    """The motion (T, M, N) in half its band, link side [rad]."""
    log = run.read
    low_pass = LowPass(cutoff=_HALF * log.sampling.motion_filter.cutoff)
    angle = log.q.copy()
    for i, n in enumerate(log.lengths):
        angle[:n, i] = low_pass(log.q[:n, i], log.dt)
    return angle


def _between_samples(dt: float) -> float:
    """Share of what replays do wrong that is not known, as the motion between the samples is not, `dt` [s] apart."""
    return min(1.0, dt / _REVERSAL) if dt < _PASSED * _REVERSAL else 0.0


def doubt_rows(weights: Values, unknown: Mapping[Channel, Array]) -> Values:
    """Weights (R, M) by component under which what is unknown counts as noise.

    Args:
        weights: one over the noise of each row, 0 for rows that do not count; (M,) or (R, M).
        unknown: what may be there or not, by channel, (R, M, C), signed or not.
    """
    found = dict(weights)
    for (channel, c), rows in weights.items():
        if channel in unknown and unknown[channel][:, :, c].any():
            about = maximum_filter1d(np.abs(unknown[channel][:, :, c]), 2 * _NEAR + 1, axis=0)
            found[channel, c] = rows / np.hypot(1.0, rows * about)
    return found
