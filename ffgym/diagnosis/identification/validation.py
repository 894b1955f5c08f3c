"""How well friction parameters explain recordings that were not used to find them, thesis 6.1.3."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.control import DynamicLuGreExact
from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.identification.friction_data import FrictionTorque
from ffgym.diagnosis.identification.sliding_data import FORGOTTEN
from ffgym.robot.friction import LuGreParameters

MOVING = 0.05
"""Motor speed that a joint must reach in a record for it to count [rad/s]."""


@dataclass(frozen=True, kw_only=True)
class Validation:
    """What parameters leave of one joint's friction torque in one record, motor side."""

    segment: str
    joint: str
    rms_friction: float
    """Of the friction torque about its mean [N m]."""
    rms_error: float
    """Of friction torque minus model [N m]."""

    @property
    def share(self) -> float:
        """Share of the variance that the model explains; negative if it is worse than a constant."""
        return 1 - (self.rms_error / self.rms_friction) ** 2


def predicted_friction(friction: LuGreParameters, torque: FrictionTorque) -> Array:
    """Friction of a LuGre model along the measured speeds, filtered as they are [N m], shape (T, N), thesis (6.16)."""
    law = DynamicLuGreExact(friction, n_substeps=1)
    signals = torque.signals
    return signals.low_pass(law.along(signals.motor_dq, signals.dt), signals.dt)


def validate(
    friction: LuGreParameters,
    torques: Sequence[FrictionTorque],
    *,
    inertia_error: Array | None = None,
    offset: Array | None = None,
) -> list[Validation]:
    """Errors of friction parameters, record by record, for the joints that move in each.

    Args:
        friction: parameters of all joints.
        torques: friction along recordings.
        inertia_error: share of the model's inertial torque that is missing, shape (N,); None is none. What was found
            about the model of the arm counts for old and new parameters alike.
        offset: torque that is no friction [N m], shape (N,); None is none.
    """
    found = []
    for torque in torques:
        missing = 0.0 if inertia_error is None else inertia_error * torque.inertia
        measured = torque.friction - missing - (0.0 if offset is None else offset)
        error = measured - predicted_friction(friction, torque)
        forgotten = _forgotten(friction, torque)
        for j, joint in enumerate(torque.signals.robot.joints):
            scored = torque.counts(j) & forgotten[:, j]
            if scored.any() and np.abs(torque.signals.motor_dq[scored, j]).max() > MOVING:
                found.append(
                    Validation(
                        segment=torque.signals.segment,
                        joint=joint,
                        rms_friction=float(measured[scored, j].std()),
                        rms_error=float(np.sqrt(np.mean(error[scored, j] ** 2))),
                    )
                )
    return found


def _forgotten(friction: LuGreParameters, torque: FrictionTorque) -> BoolArray:
    """Rows from where bristles of each joint have forgotten how they began, shape (T, N); at rest they never do."""
    way = np.cumsum(np.abs(torque.signals.motor_dq), axis=0) * torque.signals.dt
    forgotten: BoolArray = way > FORGOTTEN * friction.static / friction.bristle_stiffness
    return forgotten
