"""What the joint elasticity does on its own: static deflection under gravity, and resonances."""

from typing import Literal

import numpy as np

from ffgym.errors import FFGymError, check_shape
from ffgym.robot.arm import RigidArm
from ffgym.types import Array

_TOLERANCE = 1e-14
"""Change of deflection [rad] at which the iteration stops: rounding of angles of order 1 rad."""


def static_deflection(arm: RigidArm, motor_q: Array) -> Array:
    """Deflection under gravity with the motors held at `motor_q`, both link side [rad], shape (T, N).

    Solves K delta = -g(motor_q + delta) by fixed-point iteration; rigid joints have none.

    Raises:
        FFGymError: if the arm is so soft that the iteration does not converge.
    """
    motor_q = check_shape("motor_q", motor_q, (None, arm.robot.n_joints))
    stiffness = arm.robot.drive.joint_stiffness
    deflection = np.zeros_like(motor_q)
    moving = np.ones(len(motor_q), dtype=np.bool_)  # each row stops on its own, whatever the others do
    for _ in range(100):
        update = -arm.gravity_torque(motor_q + deflection) / stiffness
        change = np.abs(update - deflection).max(axis=1)
        deflection = np.where(moving[:, None], update, deflection)
        moving &= change >= _TOLERANCE
        if not moving.any():
            return deflection
    raise FFGymError(
        f"Static deflection does not converge: joint_stiffness = {stiffness} N m/rad is too soft for gravity."
    )


def resonances(arm: RigidArm, q: Array, motors: Literal["locked", "free"] = "locked") -> Array:
    """Undamped resonances [Hz], ascending, at joint angles `q` (N,), link side [rad].

    Args:
        arm: the robot; all joints must be elastic.
        q: joint angles.
        motors: 'locked' holds the rotors still (N modes); 'free' lets them turn (N elastic modes beside N at rest).

    Raises:
        FFGymError: if a joint is rigid.
    """
    drive = arm.robot.drive
    if np.any(drive.is_rigid):
        stiff = [j for j, rigid in zip(arm.robot.joints, drive.is_rigid, strict=True) if rigid]
        raise FFGymError(f"Joints {stiff} are rigid; resonances need a joint_stiffness on every joint.")
    mass = arm.mass_matrix(check_shape("q", q, (arm.robot.n_joints,))[None])[0]
    flexibility = np.diag(1 / drive.joint_stiffness)
    inverse_inertia = np.linalg.inv(mass)
    if motors == "free":
        inverse_inertia = inverse_inertia + drive.inverse @ np.diag(1 / drive.rotor_inertia) @ drive.inverse.T
    squares = np.linalg.eigvals(inverse_inertia @ np.linalg.inv(flexibility)).real
    return np.sort(np.sqrt(np.maximum(squares, 0.0))) / (2 * np.pi)
