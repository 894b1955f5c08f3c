"""Friction as a recording shows it: what of the motor torque neither inertia nor gravity explains, thesis (6.12)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.core.errors import check_class
from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.identification.signals import Signals, signals_of
from ffgym.diagnosis.settings import settings
from ffgym.logs.preparation import LowPass
from ffgym.recordings import Recording
from ffgym.robot import RigidArm

_SHARE = 1e-3
"""Share of the links' masses, or of the joint stiffness, in difference quotients of the torque, nearly linear in it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FrictionTorque:
    r"""Friction of all joints along one recording, motor side, T rows.

    .. math:: \hat f = u - \tau_{inertia} - \tau_{holding}
    """

    signals: Signals
    inertia: Array
    """Torque of rotors and links along the motion [N m], shape (T, N)."""
    by_inertia: Array
    """Derivative of that torque by a common share of both [N m], with what it changes of the deflection, (T, N)."""
    by_links: Array
    """The same by a share of the links alone [N m], shape (T, N)."""
    by_springs: Array
    """The same by a share of the stiffness of elastic joints [N m], shape (T, N)."""
    shaken: Array
    """Inertia of rotors and of links that noise of the motor angle shakes, motor side [kg m^2], shape (2, N): links
    behind a spring stand still."""
    holding: Array
    """Torque against gravity and springs [N m], shape (T, N)."""
    valid: BoolArray
    """Rows that count: the filter knows them, and the arm does not swing from an unknown beginning, shape (T,)."""
    arm: RigidArm
    """Model of the arm."""
    links: Array | None = None
    """Joint positions that encoders behind the elasticity measure, link side [rad or m], shape (T, N), NaN for joints
    without one; None if no joint has one."""
    tool: Array | None = None
    """Tool position that a tracker measures [m], shape (T, 3), NaN between its samples; None without a tracker."""

    @property
    def friction(self) -> Array:
        """Friction torque [N m], shape (T, N)."""
        torque: Array = self.signals.torque - self.inertia - self.holding
        return torque

    def counts(self, joint: int) -> BoolArray:
        """Valid rows that the mask of the recording leaves to one joint, 0 is the first, shape (T,)."""
        return np.asarray(self.valid & self.signals.unmasked[:, joint])


@dataclass(frozen=True, kw_only=True, eq=False)
class ModelError:
    """Errors of the model of the arm that were found beside friction, and belong to no friction model."""

    inertia: Array
    """Share of rotors and links that is missing, shape (N,)."""
    links: Array
    """Share of the links that is missing beyond that, shape (N,)."""
    springs: Array
    """Share of the joint stiffness that is missing, shape (N,)."""
    offset: Array
    """Mean torque that nothing explains [N m], motor side, shape (N,)."""

    def torque(self, along: FrictionTorque) -> Array:
        """Compute the torque that counts as friction by these errors [N m], shape (T, N)."""
        inertia = self.inertia * along.by_inertia + self.links * along.by_links
        missing: Array = inertia + self.springs * along.by_springs + self.offset
        return missing


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
        low_pass: filter of angles and torque; None is one at `sampling.motion_cutoff`.
    """
    check_class("arm", arm, RigidArm, "RigidArm(robot) makes one of a description")
    limits = settings().friction
    signals = signals_of(arm.robot, recording, low_pass or LowPass(cutoff=settings().sampling.motion_cutoff))
    drive = arm.robot.drive
    elastic = np.flatnonzero(~drive.is_rigid)
    stiffness, damping = drive.joint_stiffness[elastic], drive.joint_damping[elastic]
    # torque of links that hang in their springs
    deflection = np.zeros_like(signals.q)
    for remaining in range(limits.gravity_passes if len(elastic) else 1)[::-1]:
        q = signals.q + deflection
        holding = arm.holding_torque(q)
        moving = arm.inverse_dynamics(q, signals.dq, signals.ddq)
        by_links, by_springs = moving, np.zeros_like(moving)
        if len(elastic):
            mass = arm.mass_matrix(q)
            inner = mass[:, elastic[:, None], elastic]
            # the arm as it is described, and at last with links a little heavier and springs a little stiffer too
            shares = np.array([[1.0, 1.0], [1 + _SHARE, 1.0], [1.0, 1 + _SHARE]][: 1 if remaining else 3])
            links, springs = shares[:, :1], shares[:, 1:] * stiffness
            load = links * moving[:, None, elastic] + holding[:, None, elastic]
            inertias = links[..., None] * inner[:, None]
            bent, acceleration = _bent(inertias, damping, springs, load, holding[0, elastic], signals.dt)
            deflection[:, elastic] = bent[:, 0]
            swung = links * np.einsum("tij,tsj->tsi", mass[:, :, elastic], acceleration)
            if not remaining:
                by_links = moving + (swung[:, 1] - swung[:, 0]) / _SHARE
                by_springs = (swung[:, 2] - swung[:, 0]) / _SHARE
            moving = moving + swung[:, 0]
    # time that the arm swings at the start: none if it begins at rest, or has no elastic joint
    swinging = 0.0
    if len(elastic) and np.any(np.abs(signals.motor_dq[0]) >= settings().patterns.rest):
        mass = arm.mass_matrix(signals.q[:1])[0][np.ix_(elastic, elastic)]
        decay = np.linalg.eigvals(np.linalg.solve(mass, np.diag(damping))).real.min() / 2
        swinging = float(np.log(limits.swing_decay) / decay) if decay > 0 else np.inf
    # what noise of the motor angle shakes: the rotor, and links that are rigidly behind it
    rotors = drive.rotor_inertia * signals.motor_ddq
    # joints that move at once with each motor
    along = np.where(drive.is_rigid, drive.joint_angle(np.eye(arm.robot.n_joints)), 0.0)
    mass = arm.mass_matrix(signals.q[:: max(1, len(signals.q) // limits.poses)]).mean(axis=0)
    links = np.einsum("ij,jk,ik->i", along, mass, along)
    return FrictionTorque(
        signals=signals,
        shaken=np.stack([np.broadcast_to(drive.rotor_inertia, links.shape), links]),
        inertia=drive.motor_torque(moving) + rotors,
        by_inertia=drive.motor_torque(by_links) + rotors,
        by_links=drive.motor_torque(by_links),
        by_springs=drive.motor_torque(by_springs),
        holding=drive.motor_torque(holding),
        valid=signals.valid & (signals.t - signals.t[0] >= swinging),
        arm=arm,
        links=recording.joint_array("link.position") if recording.has("link.position") else None,
        tool=recording.vector("tcp.position") if recording.has("tcp.position") else None,
    )


def _bent(mass: Array, damping: Array, stiffness: Array, load: Array, at_rest: Array, dt: float) -> tuple[Array, Array]:
    """Deflection and its acceleration (T, S, E) under loads (T, S, E), from equilibrium under the load `at_rest` (E,).

    `mass` and `stiffness` are those of each of the S arms, shapes (T, S, E, E) and (S, E).

    Newmark's method of constant average acceleration, stable at any step: a resonance above the sample rate follows its
    load, as it should.
    """
    # matrix of the implicit step, which changes with the pose
    softening = dt / 2 * damping + dt**2 / 4 * stiffness
    inverse = np.linalg.inv(mass + softening[:, :, None] * np.eye(softening.shape[1]))
    deflection, acceleration = np.empty_like(load), np.zeros_like(load)
    x, rate, change = -at_rest / stiffness, np.zeros_like(load[0]), np.zeros_like(load[0])
    deflection[0] = x
    half, quarter = dt / 2, dt**2 / 4
    for k in range(1, len(load)):
        # predict from the acceleration before, then solve for the new one and correct
        x = x + dt * rate + quarter * change
        rate = rate + half * change
        change = np.matmul(inverse[k], (-load[k] - damping * rate - stiffness * x)[..., None])[..., 0]
        x, rate = x + quarter * change, rate + half * change
        deflection[k], acceleration[k] = x, change
    return deflection, acceleration


def friction_torques(arm: RigidArm, recordings: Sequence[Recording]) -> list[FrictionTorque]:
    """Friction torque along each of several recordings."""
    return [friction_torque(arm, recording) for recording in recordings]
