"""Whether the documented servo is the one that moved a machine: only then can its torque be compared."""

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.log import Log
from ffgym.diagnosis.measured import valid_rows
from ffgym.diagnosis.replay import servo_feedback
from ffgym.robot import RobotDescription

_NUMBERS = ("servo.position_gain", "servo.velocity_gain", "servo.integral_gain", "servo.control_dt")
"""Entries of a description without which its servo is a stand-in."""

_FORETOLD = 0.5
"""Share of the feedback torque's energy that the documented servo on the measured error foretells, by some factor, of
the machine that has it; chosen: gains that are wrong leave most, set-points that lead by a row or two hardly any."""

UNKNOWN = "the description does not say what the servo is ([servo])"

FOREIGN = "the feedback torque is not that of the documented servo on reference.position, whatever its gains"


def has_servo(robot: RobotDescription) -> bool:
    """Whether the servo of a description is said in it, not stood in for; one without origins knows all it has."""
    return not robot.quantities or all(entry in robot.quantities for entry in _NUMBERS)


def is_foreign(log: Log) -> bool:
    """Whether another controller than the documented one made the feedback torque of most joints."""
    if log.feedback is None or not log.shows_servo:
        return False
    rows, valid = log.sampling, valid_rows(log)
    measured, foretold = (_about_mean(rows(x), valid) for x in (log.feedback, servo_feedback(log, log.robot)))
    both, one, other = (
        np.einsum("sn,sn->n", a, b) for a, b in ((measured, foretold), (measured,) * 2, (foretold,) * 2)
    )
    share = np.divide(both**2, one * other, out=np.ones_like(both), where=one * other > 0)
    return bool(np.median(np.where(both > 0, share, 0.0)) < _FORETOLD)


def _about_mean(rows: Array, valid: BoolArray) -> Array:
    """Valid rows of all motions (R, M, N) about the mean of each motion, (S, N)."""
    parts = [rows[valid[:, m], m] for m in range(rows.shape[1])]
    return np.concatenate([part - part.mean(axis=0) for part in parts if len(part)])
