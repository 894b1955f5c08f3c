"""Friction as a recording shows it: what of the motor torque neither inertia nor gravity explains, thesis (6.12)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.identification.signals import Signals, signals_of
from ffgym.logs.preparation import LowPass
from ffgym.recordings import Recording
from ffgym.robot import RigidArm

AT_REST = 0.05
"""Motor speed below which a joint counts as at rest [rad/s]: a third of the Stribeck velocity of the thesis, well above
what an encoder of 16 bit shows at rest, and a jump that swings an arm by less than its friction."""

_PASSES = 2
"""Times that gravity is evaluated, the second time where the arm hangs in its springs; what a third would change is
(gravity's stiffness / joint stiffness)^2 of it, 1e-5 on the built-in robot."""

_SWINGS = 100.0
"""Factor by which a swing must have died out."""

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
    r"""Friction torque along a recording, thesis (6.10) for all joints at once.

    With the deflection :math:`\delta = q_a - q` of the links against the motors,

    .. math::
        M(q_a) (\ddot q + \ddot\delta) + C(q_a, \dot q) \dot q + g(q_a) = -(K \delta + d \dot\delta), \quad
        u - \tau_f = J_m \ddot\theta - G^{-T} (K \delta + d \dot\delta)

    which for rigid joints is the inverse dynamics, and for one axis without gravity thesis (6.11). The thesis takes the
    joints as rigid here; on the built-in robot that costs 0.3 N m of friction at 5 Hz and 10 rad/s, more than half of
    the Coulomb torque. Speeds of the deflection in Coriolis and centrifugal parts are neglected.

    Args:
        arm: model of the robot, with its joint stiffness; its friction is not used.
        recording: see `signals_of`. It should begin at rest: an arm that begins in motion swings from what was before,
            which the record does not say, and its first rows do not count.
        low_pass: filter of angles and torque; None is FRICTION_LOW_PASS.
    """
    signals = signals_of(arm.robot, recording, low_pass or FRICTION_LOW_PASS)
    drive = arm.robot.drive
    elastic = np.flatnonzero(~drive.is_rigid)
    stiffness, damping = drive.joint_stiffness[elastic], drive.joint_damping[elastic]
    deflection, acceleration = np.zeros_like(signals.q), np.zeros_like(signals.q)
    for _ in range(_PASSES if len(elastic) else 1):
        q = signals.q + deflection
        holding = arm.holding_torque(q)
        moving = arm.inverse_dynamics(q, signals.dq, signals.ddq)
        if len(elastic):
            mass = arm.mass_matrix(q)
            inner, load = mass[:, elastic[:, None], elastic], (moving + holding)[:, elastic]
            bent = _bent(inner, damping, stiffness, load, holding[0, elastic], signals.dt)
            deflection[:, elastic], acceleration[:, elastic] = bent
            moving = moving + np.einsum("tij,tj->ti", mass, acceleration)
    # time that the arm swings at the start: none if it begins at rest, or has no elastic joint
    swinging = 0.0
    if len(elastic) and np.any(np.abs(signals.motor_dq[0]) >= AT_REST):
        mass = arm.mass_matrix(signals.q[:1])[0][np.ix_(elastic, elastic)]
        decay = np.linalg.eigvals(np.linalg.solve(mass, np.diag(damping))).real.min() / 2
        swinging = float(np.log(_SWINGS) / decay) if decay > 0 else np.inf
    return FrictionTorque(
        signals=signals,
        inertia=drive.motor_torque(moving) + drive.rotor_inertia * signals.motor_ddq,
        holding=drive.motor_torque(holding),
        valid=signals.valid & (signals.t - signals.t[0] >= swinging),
    )


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


def friction_torques(arm: RigidArm, recordings: Sequence[Recording]) -> list[FrictionTorque]:
    """Friction torque along each of several recordings."""
    return [friction_torque(arm, recording) for recording in recordings]
