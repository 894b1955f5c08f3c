"""What the nominal machine would have recorded, without noise: simulated under its controller, or as it was moved."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.diagnosis.as_moved import as_moved
from ffgym.diagnosis.log import Log
from ffgym.diagnosis.own_motion import own_motion
from ffgym.diagnosis.replay import Replay
from ffgym.diagnosis.servo import has_servo
from ffgym.recordings import Recording

_SAME_MOTION = 0.03
"""RMS angle of a motor [rad] by which a simulated motion may miss the measured one. Under the documented servo, faults
of joints, drives and loads make it miss by a third of that at most; another servo by twice that or more, and reversals
are some milliseconds off then."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Exact:
    """Recordings of the nominal machine, one for each motion of a log."""

    recordings: tuple[Recording, ...]
    simulated: bool
    """Whether they are of its controller along the log's set-points; else the motors move as measured."""


def exact_recordings(log: Log, run: Replay) -> Exact:
    """What the nominal machine would have recorded in continuous time, without noise.

    With set-points, it is simulated under its controller. Without, or where another controller moved the machine, or
    its own would not hold it, it moves as measured, and takes the torque that it takes: what repeats with the motor's
    turns must stay in phase.

    Args:
        log: what was measured.
        run: its replay on the nominal machine.
    """
    if log.reference is not None and has_servo(log.robot):
        simulated = own_motion(log, run)
        if simulated is not None and is_same_motion(log, simulated):
            return Exact(recordings=tuple(simulated), simulated=True)
    return Exact(recordings=tuple(as_moved(log, run)), simulated=False)


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
