"""Motor torque of a motion, part by part, and effects of joint elasticity: deflection and resonances."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.types import Array
from ffgym.robot.dynamics.arm import RigidArm


@dataclass(frozen=True, kw_only=True, eq=False)
class MotorTorque:
    """Parts of the motor torque that a motion takes, motor side [N m], shape (T, N) each."""

    inertia: Array
    """Links: M(q) ddq + C(q, dq) dq."""
    gravity: Array
    """Links, held at rest."""
    springs: Array
    """Springs between links, held at rest."""
    rotors: Array
    """Motors and gear inputs: J_m times motor acceleration."""
    friction: Array
    """Friction at steady speed."""

    @property
    def total(self) -> Array:
        """Sum of all parts [N m], shape (T, N)."""
        return self.inertia + self.gravity + self.springs + self.rotors + self.friction


def motor_torque(arm: RigidArm, q: Array, dq: Array, ddq: Array) -> MotorTorque:
    r"""Torque that moves a rigid arm along a motion.

    .. math:: u = G^{-T} (M(q) \ddot q + C(q, \dot q) \dot q + g(q) + s(q)) + J_m \ddot\theta + \tau_f(\dot\theta)

    with motor angles :math:`\theta = G q` and friction of the description at steady speed. For another friction law
    replace that part: `dataclasses.replace(torque, friction=...)`.

    Args:
        arm: the robot.
        q: joint positions, link side [rad], shape (T, N).
        dq: joint speeds, link side [rad/s], shape (T, N).
        ddq: joint accelerations, link side [rad/s^2], shape (T, N).

    Raises:
        FFGymError: if a shape does not fit.
    """
    drive = arm.robot.drive
    q = check_shape("q", q, (None, arm.robot.n_joints))
    return MotorTorque(
        inertia=drive.motor_torque(arm.inverse_dynamics(q, dq, ddq)),
        gravity=drive.motor_torque(arm.gravity_torque(q)),
        springs=drive.motor_torque(arm.spring_torque(q)),
        rotors=drive.rotor_inertia * drive.motor_angle(ddq),
        friction=arm.robot.friction.steady_torque(drive.motor_angle(dq)),
    )


_TOLERANCE = 1e-14
"""Change of deflection [rad] at which the iteration stops: rounding of angles of order 1 rad."""


def static_deflection(arm: RigidArm, motor_q: Array) -> Array:
    """Deflection under gravity and springs between links with the motors held at `motor_q`, link side [rad], (T, N).

    Solves K delta = -h(motor_q + delta), with the holding torque h, by fixed-point iteration; rigid joints have none.

    Raises:
        FFGymError: if the arm is so soft that the iteration does not converge.
    """
    motor_q = check_shape("motor_q", motor_q, (None, arm.robot.n_joints))
    stiffness = arm.robot.drive.joint_stiffness
    deflection = np.zeros_like(motor_q)
    moving = np.ones(len(motor_q), dtype=np.bool_)  # each row stops on its own, whatever the others do
    for _ in range(100):
        update = -arm.holding_torque(motor_q + deflection) / stiffness
        change = np.abs(update - deflection).max(axis=1)
        deflection = np.where(moving[:, None], update, deflection)
        moving &= change >= _TOLERANCE
        if not moving.any():
            return deflection
    raise FFGymError(
        f"Static deflection does not converge: joint_stiffness = {stiffness} N m/rad is too soft for gravity."
    )


def resonances(arm: RigidArm, q: Array, motors: Literal["locked", "free"] = "locked") -> Array:
    """Undamped resonances [Hz], ascending, at joint positions `q` (N,), link side: one per elastic joint.

    Args:
        arm: the robot; springs between links are left out.
        q: joint positions.
        motors: 'locked' holds the rotors still; 'free' lets them turn, so that the motions at rest are left out.
    """
    drive = arm.robot.drive
    mass = arm.mass_matrix(check_shape("q", q, (arm.robot.n_joints,))[None])[0]
    elastic = np.flatnonzero(~drive.is_rigid)
    inertia = mass[np.ix_(elastic, elastic)]
    if motors == "free":  # what the elastic joints feel when the motors give way
        rotors = drive.matrix.T @ np.diag(drive.rotor_inertia) @ drive.matrix
        inertia = inertia - mass[elastic] @ np.linalg.solve(mass + rotors, mass[:, elastic])
    squares = np.linalg.eigvals(np.linalg.solve(inertia, np.diag(drive.joint_stiffness[elastic]))).real
    return np.sort(np.sqrt(np.maximum(squares, 0.0))) / (2 * np.pi)
