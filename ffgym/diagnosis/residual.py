"""Residuals of measured motions: measured minus predicted, channel by channel, with the noise floor beside them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.effects import State
from ffgym.robot import RobotDescription

Channel = Literal["torque", "tool", "link", "servo"]
"""Signals that are compared: `torque` of each motor over its measured motion, motor side [N m]; `tool`, tracked
position against that of the model behind the measured motors [m], x, y, z of the world; `link`, angle of each link by
an encoder behind the gearbox [rad]; `servo`, feedback torque of each motor against the documented servo on the measured
error [N m]."""

UNITS: Mapping[Channel, str] = {"torque": "N m", "tool": "m", "link": "rad", "servo": "N m"}
"""Unit of each channel; `torque`, `servo`: motor side, `link`: link side."""


def components(channel: Channel, robot: RobotDescription) -> tuple[str, ...]:
    """Names of what a channel has columns for: joints, or axes of the world."""
    return ("x", "y", "z") if channel == "tool" else tuple(robot.joints)


@dataclass(frozen=True, kw_only=True, eq=False)
class MotionResidual:
    """Measured minus predicted along one motion, R rows at even times, filtered without delay."""

    motion: str
    """Name of the motion, that of the recording's segment."""
    t: Array
    """Time since the motion began [s], shape (R,)."""
    valid: BoolArray
    """Rows that count: the filter knows them, and no sample is missing; shape (R,)."""
    measured: Mapping[Channel, Array]
    """(R, N) each, or (R, 3); only channels that the log has."""
    predicted: Mapping[Channel, Array]
    """The same channels by the model."""
    state: State
    """Motion, load and temperature by measured motors and the model, (R, N) each."""
    motor_acceleration: Array
    """[rad/s^2], motor side, shape (R, N)."""
    since_reversal: Array
    """Travel of each motor since it last turned or started after a rest [rad], motor side, >= 0, shape (R, N)."""
    at_rest_for: Array
    """Time for which each motor has stood before its present move began [s]; 0 if it only turned; shape (R, N)."""
    judged: Mapping[Channel, BoolArray] = field(default_factory=dict)
    """Rows in which the model claims to know a component, shape (R, N) or (R, 3); all, where a channel is not named."""

    @property
    def residual(self) -> dict[Channel, Array]:
        """Measured minus predicted by channel; NaN where a sample is missing, or the model claims to know nothing."""
        return {
            channel: np.where(self.judged.get(channel, True), self.measured[channel] - self.predicted[channel], np.nan)
            for channel in self.measured
        }


@dataclass(frozen=True, kw_only=True, eq=False)
class Residual:
    """Residuals of all motions of a log, and how large noise alone would make them."""

    robot: RobotDescription
    motions: tuple[MotionResidual, ...]
    floor: Mapping[Channel, Array]
    """RMS of each component, shape (M, N) or (M, 3) for M motions, of the nominal model replayed over itself with this
    log's noise: what a model without any fault would leave."""
    cutoff: float
    """Low-pass that all channels went through [Hz]."""

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Channels that all motions have."""
        return tuple(c for c in UNITS if all(c in motion.measured for motion in self.motions))
