"""What the controller that is there gives when the motors lead the arm: its rigid feed-forward, and its servo."""

from agents.elasticity.lead import Lead
from ffgym.robot import RigidArm
from ffgym.types import Array


def given_torque(
    controller: RigidArm, q: Array, motor_dq: Array, motor_ddq: Array, lead: Lead, integral: Array
) -> Array:
    """Torque of the existing controller [N m], beyond gravity at the start, shape (..., N).

    The servo sees the motor ahead of its reference by the lead, and pulls it back; it is in equilibrium at the start.

    Args:
        controller: rigid dynamics and servo that it was made for.
        q: joint position of the reference [rad], shape (..., N).
        motor_dq: motor speed of the reference [rad/s], shape (..., N).
        motor_ddq: motor acceleration of the reference [rad/s^2], shape (..., N).
        lead: how far the motors lead beyond their lead at the start.
        integral: integral of the lead since the start, link side [rad s], shape (..., N).
    """
    drive, servo = controller.robot.drive, controller.robot.servo
    rigid = links_torque(controller, q, motor_dq, motor_ddq, gravity=False) / drive.gear_ratio
    rigid += drive.rotor_inertia * motor_ddq
    error = servo.position_gain * lead.angle + servo.velocity_gain * lead.speed + servo.integral_gain * integral
    return rigid - drive.gear_ratio * error


def links_torque(arm: RigidArm, q: Array, motor_dq: Array, motor_ddq: Array, *, gravity: bool) -> Array:
    """Torque of the links, link side [N m], for a motion of any shape (..., N)."""
    ratio = arm.robot.drive.gear_ratio
    rows = (part.reshape(-1, arm.robot.n_joints) for part in (q, motor_dq / ratio, motor_ddq / ratio))
    return arm.inverse_dynamics(*rows, gravity=gravity).reshape(q.shape)
