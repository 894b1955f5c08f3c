"""Friction as a recording shows it: what of the motor torque neither inertia nor gravity explains, thesis (6.12)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.identification.signals import LowPass, Signals, signals_of
from ffgym.recordings import Recording
from ffgym.robot import RigidArm

_PASSES = 2
"""Times that gravity is evaluated, the second time where the arm hangs in its springs; what a third would change is
(gravity's stiffness / joint stiffness)^2 of it, 1e-5 on the built-in robot."""

_AT_REST = 0.05
"""Motor speed below which a record begins at rest [rad/s]: a jump of it swings an arm by less than its friction."""

_SWINGS = 100.0
"""Factor by which a swing must have died out."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LoadTorque:
    """Parts of the motor torque that are not friction, motor side [N m], shape (T, N) each."""

    inertia: Array
    """Rotors and links, with Coriolis and centrifugal parts."""
    holding: Array
    """Gravity, and springs between links."""
    settled: BoolArray
    """Rows in which the arm no longer swings from a beginning that the filter does not know, shape (T,)."""


def load_torque(arm: RigidArm, signals: Signals) -> LoadTorque:
    r"""Torque that a motion of the motors takes without friction, thesis (6.10) for all joints at once.

    With the deflection :math:`\delta = q_a - q` of the links against the motors,

    .. math::
        M(q_a) (\ddot q + \ddot\delta) + C(q_a, \dot q) \dot q + g(q_a) = -(K \delta + d \dot\delta), \quad
        u - \tau_f = J_m \ddot\theta - G^{-T} (K \delta + d \dot\delta)

    which for rigid joints is the inverse dynamics, and for one axis without gravity thesis (6.11). The thesis takes the
    joints as rigid here; on the built-in robot that costs 0.3 N m of friction at 5 Hz and 10 rad/s, more than half of
    the Coulomb torque. Speeds of the deflection in Coriolis and centrifugal parts are neglected.

    Args:
        arm: model of the robot, with its joint stiffness.
        signals: the motion. It should begin at rest: an arm that begins in motion swings from what was before, which
            the record does not say, and its first rows are not `settled`.
    """
    drive = arm.robot.drive
    elastic = np.flatnonzero(~drive.is_rigid)
    deflection = np.zeros_like(signals.q)
    acceleration = np.zeros_like(signals.q)
    for _ in range(_PASSES if len(elastic) else 1):
        q = signals.q + deflection
        holding = arm.holding_torque(q)
        moving = arm.inverse_dynamics(q, signals.dq, signals.ddq)
        if len(elastic):
            mass = arm.mass_matrix(q)
            inner = mass[:, elastic[:, None], elastic]
            deflection[:, elastic], acceleration[:, elastic] = _bent(
                inner,
                drive.joint_damping[elastic],
                drive.joint_stiffness[elastic],
                (moving + holding)[:, elastic],
                holding[0, elastic],
                signals.dt,
            )
            moving = moving + np.einsum("tij,tj->ti", mass, acceleration)
    return LoadTorque(
        inertia=drive.motor_torque(moving) + drive.rotor_inertia * signals.motor_ddq,
        holding=drive.motor_torque(holding),
        settled=signals.t - signals.t[0] >= _swinging(arm, signals),
    )


def _swinging(arm: RigidArm, signals: Signals) -> float:
    """Time that the arm swings at the start [s]: none if it begins at rest, or has no elastic joint."""
    drive = arm.robot.drive
    elastic = np.flatnonzero(~drive.is_rigid)
    if not len(elastic) or np.all(np.abs(signals.motor_dq[0]) < _AT_REST):
        return 0.0
    mass = arm.mass_matrix(signals.q[:1])[0][np.ix_(elastic, elastic)]
    decay = np.linalg.eigvals(np.linalg.solve(mass, np.diag(drive.joint_damping[elastic]))).real / 2
    return float(np.log(_SWINGS) / decay.min()) if decay.min() > 0 else np.inf


def _bent(mass: Array, damping: Array, stiffness: Array, load: Array, at_rest: Array, dt: float) -> tuple[Array, Array]:
    """Deflection and its acceleration (T, E) under `load` (T, E), from equilibrium under the load `at_rest` (E,).

    Newmark's method of constant average acceleration, stable at any step: a resonance above the sample rate follows its
    load, as it should.
    """
    inverse = np.linalg.inv(mass + np.diag(dt / 2 * damping + dt**2 / 4 * stiffness))
    deflection, acceleration = np.empty_like(load), np.zeros_like(load)
    x, rate, change = -at_rest / stiffness, np.zeros_like(load[0]), np.zeros_like(load[0])
    deflection[0] = x
    for k in range(1, len(load)):
        x = x + dt * rate + dt**2 / 4 * change
        rate = rate + dt / 2 * change
        change = inverse[k] @ (-load[k] - damping * rate - stiffness * x)
        x, rate = x + dt**2 / 4 * change, rate + dt / 2 * change
        deflection[k], acceleration[k] = x, change
    return deflection, acceleration


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
