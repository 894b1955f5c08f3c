"""Friction as a recording shows it: what of the motor torque neither inertia nor gravity explains, thesis (6.12)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.identification.load_torque import load_torque
from ffgym.diagnosis.identification.signals import LowPass, Signals, signals_of
from ffgym.recordings import Recording
from ffgym.robot import RigidArm

FRICTION_LOW_PASS = LowPass(cutoff=100.0)
"""Default filter. A reversal takes 7 to 30 ms in the records of table 6.1, which the thesis' 40 Hz smear: sigma_1 is
then up to 3 % wrong on the built-in robot, 0.4 % at 100 Hz (docs/identification.md)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FrictionTorque:
    r"""Friction of all joints along one recording, motor side, T rows.

    .. math:: \hat f = u - \tau_{inertia} - \tau_{holding}
    """

    signals: Signals
    inertia: Array
    """Torque of rotors and links along the motion [N m], shape (T, N)."""
    holding: Array
    """Torque against gravity and springs [N m], shape (T, N)."""
    valid: BoolArray
    """Rows that count: the filter knows them, and the arm does not swing from an unknown beginning, shape (T,)."""

    @property
    def friction(self) -> Array:
        """Friction torque [N m], shape (T, N)."""
        torque: Array = self.signals.torque - self.inertia - self.holding
        return torque

    def counts(self, joint: int) -> BoolArray:
        """Valid rows that the mask of the recording leaves to one joint, 0 is the first, shape (T,)."""
        return np.asarray(self.valid & self.signals.unmasked[:, joint])


def friction_torque(arm: RigidArm, recording: Recording, low_pass: LowPass | None = None) -> FrictionTorque:
    """Friction torque along a recording.

    Args:
        arm: model of the robot; its friction is not used.
        recording: see `signals_of`.
        low_pass: filter of angles and torque; None is FRICTION_LOW_PASS.

    Raises:
        FFGymError: as `signals_of`.
    """
    signals = signals_of(arm.robot, recording, low_pass or FRICTION_LOW_PASS)
    load = load_torque(arm, signals)
    return FrictionTorque(
        signals=signals, inertia=load.inertia, holding=load.holding, valid=signals.valid & load.settled
    )


def friction_torques(
    arm: RigidArm, recordings: Sequence[Recording], low_pass: LowPass | None = None
) -> list[FrictionTorque]:
    """Friction torque along each of several recordings."""
    return [friction_torque(arm, recording, low_pass) for recording in recordings]
