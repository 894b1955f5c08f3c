"""Motors that stand or creep, read with noise and in steps: what that does to the friction of a replay, on average.

Where a motor creeps over some steps of its encoder after a stop, noise moves the reading to and fro at the edge of each
step, and whatever of that leaves the band of `Log.trembling` loosens the bristles a little: always the same way, in all
logs of the motion, by more than the noise of the torque. What is systematic is no fault of the machine.
"""

from collections.abc import Sequence

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.log import Log, log_of
from ffgym.diagnosis.noise import Noise, noisy
from ffgym.diagnosis.replay import Replay
from ffgym.diagnosis.replay.bristles import along_speed
from ffgym.recordings import Recording

DRAWS = 4
"""Draws of the reading's noise; from one to the next it differs by a seventh of its mean, where that is large."""


def misread_friction(exact: Sequence[Recording], clean: Log, run: Replay, step: Array) -> Array:
    """Friction in a replay of noisy readings beyond that of exact ones, mean at rows (R, M, N), motor side [N m].

    The noise is that of the band in which a log's reading moves, so that logs with one band have one mean.

    Args:
        exact: the nominal machine over its own motion.
        clean: the same as a log, with the band of the log that is diagnosed.
        run: its replay.
        step: of the encoders [rad], motor side, (M, N).
    """
    drive, none = run.robot.drive, np.zeros(step.shape)
    angle = np.broadcast_to(np.abs(drive.motor_angle(clean.reading_noise)), step.shape)
    noise = Noise(angle=angle, step=step, torque=none, tool=None, link=None, feedback=None)
    rng, total = np.random.default_rng(0), np.zeros_like(run.bristles.torque)
    for _ in range(DRAWS):
        seen = [noisy(recording, noise, i, rng) for i, recording in enumerate(exact)]
        one = log_of(clean.robot, seen, like=clean)
        friction = along_speed(run.robot.friction, drive.motor_angle(one.slip_dq), drive.motor_angle(one.dq), one.dt)
        total += friction.torque - run.bristles.torque
    rows: Array = clean.sampling(total / DRAWS)
    return rows
