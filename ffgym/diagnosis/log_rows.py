"""All rows of a log side by side, motion after motion: what residuals are sorted by."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array, IntArray
from ffgym.diagnosis.residual import Channel, MotionResidual, Residual


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
    """Rows of a log with the residual of one channel, which all its motions have; none after the last that counts."""
    motions, n = residual.motions, residual.robot.n_joints
    kept = [_length(motion) for motion in motions]
    ends = np.cumsum([motion.t[k - 1] - motion.t[0] for motion, k in zip(motions, kept, strict=True)])
    begins = np.concatenate([[0.0], ends[:-1]])

    def joined(of: Callable[[MotionResidual], Array]) -> Array:
        return np.concatenate([of(motion)[:k] for motion, k in zip(motions, kept, strict=True)])

    def state(name: str) -> Array:
        return joined(lambda motion: np.broadcast_to(getattr(motion.state, name), (len(motion.t), n)))

    return LogRows(
        motion=np.repeat(np.arange(len(motions)), kept),
        time=joined(lambda motion: motion.t - motion.t[0]) + np.repeat(begins, kept),
        residual=joined(lambda motion: np.where(motion.valid[:, None], motion.residual[channel], np.nan)),
        floor=np.repeat(residual.floor[channel], kept, axis=0),
        speed=state("motor_speed"),
        angle=state("motor_angle"),
        position=state("joint_angle"),
        load=state("load_at_motor"),
        travel=joined(lambda motion: motion.since_reversal),
        stood=joined(lambda motion: motion.at_rest_for),
        temperature=state("temperature"),
    )


def _length(motion: MotionResidual) -> int:
    """Rows up to the last that counts; at least one."""
    counting = np.flatnonzero(motion.valid)
    return int(counting[-1]) + 1 if len(counting) else 1
