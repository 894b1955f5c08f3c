"""What claims about one axis that follows a sine are decided by."""

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.recordings import Recording
from ffgym.recordings.metrics import friction_miss
from ffgym.studies.one_axis import SETTLED
from scripts.thesis.claims import Check

BEND = 1.0
"""Motor speed [rad/s] below which the thesis sees friction's nonlinearity (5.1.1)."""


def settled(recording: Recording) -> BoolArray:
    """Rows after the start has settled, shape (T,)."""
    return np.asarray(recording.t >= SETTLED)


def axis_miss(recording: Recording, rows: BoolArray | None = None) -> float:
    """RMS of friction minus added torque over RMS friction of one axis, in settled rows; None takes all of them."""
    kept = settled(recording) if rows is None else settled(recording) & rows
    return float(friction_miss(recording, kept)[0])


def feedback_rms(recording: Recording) -> float:
    """RMS feedback torque of one axis [N m], motor side."""
    return float(np.sqrt(np.mean(recording.joint_array("feedback.effort")[settled(recording), 0] ** 2)))


def branches(recording: Recording, family: str, speeds: Array) -> tuple[Array, Array]:
    """Torque of `family` [N m] at motor speeds [rad/s] of the reference while it rises, and while it falls; (K,)."""
    rows = settled(recording)
    speed = recording.joint_array("reference.velocity")[rows, 0]
    torque = recording.joint_array(family)[rows, 0]
    rises = np.gradient(speed) > 0

    def branch(wanted: Array) -> Array:
        order = np.argsort(speed[wanted])
        return np.interp(speeds, speed[wanted][order], torque[wanted][order])

    return branch(rises), branch(~rises)


def static_law_averages(recording: Recording) -> list[Check]:
    """Whether a static law lies nearer to the mean of the two branches of friction than they do themselves."""
    speeds = np.linspace(-BEND, BEND, 41)
    up, down = branches(recording, "friction.effort", speeds)
    added = np.mean(branches(recording, "compensation.effort", speeds), axis=0)
    off = float(np.sqrt(np.mean((added - (up + down) / 2) ** 2)))
    half_width = float(np.sqrt(np.mean(((up - down) / 2) ** 2)))
    return [
        Check(
            where=f"distance to the mean of both branches, half the loop's width, below {BEND:g} rad/s [N m]",
            value=off,
            limit=half_width,
        )
    ]
