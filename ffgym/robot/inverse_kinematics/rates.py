"""Joint speeds and accelerations of a tool motion."""

from ffgym.robot.arm import RigidArm
from ffgym.robot.inverse_kinematics.hold import Hold
from ffgym.robot.inverse_kinematics.newton import solve_twist
from ffgym.types import Array


def joint_rates(arm: RigidArm, q: Array, twist: Array, twist_rate: Array) -> tuple[Array, Array]:
    """Joint speeds and accelerations, shape (T, N) each, along joint positions that `solve_path` returned.

    Args:
        arm: the robot.
        q: joint positions of the path [rad or m], shape (T, N).
        twist: speed of the TCP [m/s] and, unless the orientation is free, of tool0 [rad/s], shape (T, 6) or (T, 3).
        twist_rate: its time derivative, same shape.
    """
    n_rows = twist.shape[1]
    hold = Hold.at_poses(arm, q[:1], turning=n_rows == 6).repeated(len(q))
    jacobian = arm.jacobian(q)[:, :n_rows]
    speed, matrix = hold.extend(twist, jacobian)
    dq = solve_twist(matrix, speed)
    change, _ = hold.extend(twist_rate - arm.bias_acceleration(q, dq)[:, :n_rows], jacobian)
    return dq, solve_twist(matrix, change)
