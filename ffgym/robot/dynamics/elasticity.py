"""What the joint elasticity does on its own: static deflection under load, and resonances."""

from typing import Literal

import numpy as np

from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.types import Array
from ffgym.robot.dynamics.arm import RigidArm

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
