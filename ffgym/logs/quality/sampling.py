"""Checks of the sampling rate against what moves: the first resonance of the arm, and the motion itself."""

from collections.abc import Iterator

import numpy as np
from scipy.signal import welch

from ffgym.logs.quality.check import Check, NotJudgedError, Seen
from ffgym.logs.quality.log import Log
from ffgym.robot import resonances

_SAMPLES = 10
"""Samples that a period needs to be seen with its shape; two are needed to be seen at all."""


def first_resonance(log: Log) -> float:
    """First resonance of the arm on its springs [Hz], in the middle of the log.

    Raises:
        NotJudgedError: if robot or positions are not known, or the robot has no springs.
    """
    if log.robot is None or log.q is None or log.robot.n_joints != len(log.joints):
        raise NotJudgedError("it needs the robot and positions")
    if log.robot.drive.is_rigid.all():
        raise NotJudgedError("all joints of the robot are rigid")
    return float(resonances(log.arm, log.q[len(log.q) // 2])[0])


def bandwidth(log: Log) -> tuple[float, str]:
    """Frequency [Hz] below which 90 % of the power of the speed lie, and the joint where that is highest.

    Raises:
        NotJudgedError: if no joint moves, or the log is too short.
    """
    if log.dq is None or not log.excited.any():
        raise NotJudgedError("no joint moves")
    if len(log.t) < 64:
        raise NotJudgedError("there are fewer than 64 rows")
    speed = log.dq[:, log.excited]
    frequency, power = welch(
        speed / np.maximum(speed.std(axis=0), 1e-300), fs=1 / log.dt, nperseg=min(4096, len(speed)), axis=0
    )
    share = np.cumsum(power, axis=0) / np.maximum(power.sum(axis=0), 1e-300)
    held = frequency[np.argmax(share > 0.9, axis=0)]
    j = int(np.argmax(held))
    return float(held[j]), log.joints[int(np.flatnonzero(log.excited)[j])]


def _resonance(log: Log) -> Iterator[Seen]:
    first, rate = first_resonance(log), 1 / log.dt
    assert log.robot is not None
    message = (
        f"timestamp: {rate:.4g} samples a second are {rate / first:.3g} in a period of the first resonance of "
        f"{log.robot.name}, {first:.3g} Hz, must be {_SAMPLES} at least. Log faster; elastic effects cannot be judged."
    )
    yield Seen(value=_SAMPLES * first / rate, message=message, columns=("timestamp",))


def _bandwidth(log: Log) -> Iterator[Seen]:
    held, joint = bandwidth(log)
    message = (
        f"timestamp: 10 % of the speed of joint {joint} lie above {held:.3g} Hz, {1 / (held * log.dt):.3g} "
        f"samples a period, must be {_SAMPLES} at least. Log faster, or move more gently."
    )
    yield Seen(value=_SAMPLES * held * log.dt, message=message, columns=("timestamp",), joint=joint)


SAMPLING = (
    Check(
        name="rate_for_resonance",
        figure="First resonance times 10 over the sampling rate",
        unit="1",
        flag=1.0,
        why="ten samples a period show the shape of an oscillation; fewer alias its harmonics",
        judge=_resonance,
    ),
    Check(
        name="rate_for_motion",
        figure="Bandwidth of the motion (90 % of the power of the speed) times 10 over the sampling rate",
        unit="1",
        flag=1.0,
        why="accelerations are differences of differences; with fewer samples they are mostly error",
        judge=_bandwidth,
    ),
)
"""Checks of the sampling rate."""
