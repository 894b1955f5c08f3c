"""Joint speeds and accelerations of a tool motion."""

import numpy as np

from ffgym.core.types import Array
from ffgym.robot.dynamics.arm import RigidArm
from ffgym.robot.inverse_kinematics.newton import solve_twist
from ffgym.robot.inverse_kinematics.posture import Posture


def joint_rates(arm: RigidArm, q: Array, seed: Array, twist: Array, twist_rate: Array) -> tuple[Array, Array]:
    """Joint speeds and accelerations, shape (T, N) each, along joint positions that `solve_path` returned.

    Args:
        arm: the robot.
        q: joint positions of the path [rad or m], shape (T, N).
        seed: joint positions that `solve_path` was given, shape (N,).
        twist: speed of the TCP [m/s] and, unless the orientation is free, of tool0 [rad/s], shape (T, 6) or (T, 3).
        twist_rate: its time derivative, same shape.
    """
    n_rows = twist.shape[1]
    posture = Posture.near(arm, seed, turning=n_rows == 6)
    jacobian = arm.jacobian(q)
    slopes, away = posture.demands(jacobian, q)
    dq = solve_twist(slopes, np.hstack([twist, np.zeros_like(away)]))
    change = twist_rate - arm.bias_acceleration(q, dq)[:, :n_rows]
    return dq, solve_twist(slopes, np.hstack([change, posture.bend(jacobian, q, dq)]))
