"""The length of a log that a diagnosis can afford.

Its replays keep tens of arrays of samples, and its search hundreds of columns of rows that are compared. An hour of six
axes at 1 kHz, thinned to 83 s, takes 2.6 GB and two minutes on one core; of 120 s it takes 4 GB. More of them tell
hardly more: the protocol `diagnosis`, made to show every regime, lasts 88 s, and errors of sizes fall with the root of
the time alone.
"""

from ffgym.diagnosis.log.sampling import Sampling

SAMPLES = 540_000
"""Samples of all joints and recordings together: 90 s of six axes at 1 kHz, with which a diagnosis stays below 3 GB."""

ROWS = 270_000
"""Rows that are compared, of all joints together: 360 s of six axes at 250 Hz, 450 s at 100 Hz. It is the one that
counts for slow logs, of which each sample is a row."""


def affordable(dt: float, n_joints: int) -> float:
    """Time [s] that all recordings of a log may last together before it is thinned.

    Args:
        dt: sample period [s].
        n_joints: joints of the robot.
    """
    samples, rows = SAMPLES / n_joints, ROWS / n_joints
    stride = Sampling.of(dt, [round(samples)]).stride
    return min(samples, rows * stride) * dt
