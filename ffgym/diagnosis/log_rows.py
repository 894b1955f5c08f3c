"""All rows of a log side by side, motion after motion: what residuals are sorted by."""

from dataclasses import dataclass

import numpy as np

from ffgym.diagnosis.residual import Channel, MotionResidual, Residual
from ffgym.effects import State
from ffgym.types import Array, IntArray


@dataclass(frozen=True, kw_only=True, eq=False)
class LogRows:
    """Rows of all motions, R in all, of one channel with C components; N joints."""

    motion: IntArray
    """Place of the motion in the log, shape (R,)."""
    time: Array
    """Time since the first motion began, pauses left out [s], shape (R,)."""
    residual: Array
    """Measured minus predicted, in the unit of the channel, shape (R, C); NaN in rows that do not count."""
    floor: Array
    """Noise floor of each row's motion, shape (R, C)."""
    speed: Array
    """Motor speed [rad/s], shape (R, N)."""
    angle: Array
    """Motor angle [rad], shape (R, N)."""
    position: Array
    """Joint position behind the gearbox, link side [rad], shape (R, N)."""
    load: Array
    """What the motor bears of the load behind the gearbox, motor side [N m], shape (R, N)."""
    travel: Array
    """Travel of each motor since it turned [rad], shape (R, N)."""
    stood: Array
    """How long each motor had stood when its move began [s], shape (R, N)."""
    temperature: Array
    """[degC], shape (R, N)."""


def log_rows(residual: Residual, channel: Channel) -> LogRows:
    """Rows of a log with the residual of one channel, which all its motions have."""
    motions = residual.motions
    ends = np.cumsum([motion.t[-1] - motion.t[0] for motion in motions])
    begins = np.concatenate([[0.0], ends[:-1]])
    rows = [len(motion.t) for motion in motions]
    return LogRows(
        motion=np.repeat(np.arange(len(motions)), rows),
        time=np.concatenate([motion.t - motion.t[0] + begin for motion, begin in zip(motions, begins, strict=True)]),
        residual=np.concatenate([_counting(motion, channel) for motion in motions]),
        floor=np.repeat(residual.floor[channel], rows, axis=0),
        speed=_joined(residual, "motor_speed"),
        angle=_joined(residual, "motor_angle"),
        position=_joined(residual, "joint_angle"),
        load=_joined(residual, "load_at_motor"),
        travel=np.concatenate([motion.since_reversal for motion in motions]),
        stood=np.concatenate([motion.at_rest_for for motion in motions]),
        temperature=_joined(residual, "temperature"),
    )


def _counting(motion: MotionResidual, channel: Channel) -> Array:
    """Residual of a motion, NaN in rows that do not count."""
    return np.where(motion.valid[:, None], motion.residual[channel], np.nan)


def _joined(residual: Residual, name: str) -> Array:
    """An entry of the states of all motions, shape (R, N)."""
    n = residual.robot.n_joints
    return np.concatenate([_spread(motion.state, name, (len(motion.t), n)) for motion in residual.motions])


def _spread(state: State, name: str, shape: tuple[int, int]) -> Array:
    return np.broadcast_to(getattr(state, name), shape)
