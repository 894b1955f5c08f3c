"""The length of a log that a diagnosis can afford.

Its replays keep tens of arrays of samples, and its search hundreds of columns of rows that are compared. Six axes in
90,000 samples at 1 kHz (90 s) take {MEMORY} and {TIME}; more of them tell hardly more: the protocol `diagnosis`, made
to show every regime, lasts 88 s, and errors of sizes fall with the root of the time alone.
"""

from ffgym.diagnosis.log.sampling import Sampling

SAMPLES = 540_000
"""Samples of all joints together, of all recordings: 90 s of six axes at 1 kHz."""

ROWS = 270_000
"""Rows that are compared, of all joints together: 360 s of six axes at 250 Hz, 450 s at 100 Hz. It is the larger of
both bounds for slow logs, of which each sample is a row."""


def affordable(dt: float, n_joints: int) -> float:
    """Time [s] that all recordings of a log may last together before it is thinned.

    Args:
        dt: sample period [s].
        n_joints: joints of the robot.
    """
    samples, rows = SAMPLES / n_joints, ROWS / n_joints
    stride = Sampling.of(dt, [round(samples)]).stride
    return min(samples, rows * stride) * dt
