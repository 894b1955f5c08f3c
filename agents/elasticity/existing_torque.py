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
    rigid = drive.motor_torque(links_torque(controller, q, motor_dq, motor_ddq, load=False))
    rigid += drive.rotor_inertia * motor_ddq
    angle, speed, sum_of_angle = (drive.motor_angle(part) for part in (lead.angle, lead.speed, integral))
    return rigid - (servo.position_gain * angle + servo.velocity_gain * speed + servo.integral_gain * sum_of_angle)


def links_torque(arm: RigidArm, q: Array, motor_dq: Array, motor_ddq: Array, *, load: bool) -> Array:
    """Torque of the links, link side [N m], for a motion of any shape (..., N).

    `load` adds what must be carried at rest too: gravity, and springs between links.
    """
    drive = arm.robot.drive
    motion = (q, drive.joint_angle(motor_dq), drive.joint_angle(motor_ddq))
    rows = [part.reshape(-1, arm.robot.n_joints) for part in motion]
    torque = arm.inverse_dynamics(*rows, gravity=load)
    if load:
        torque += arm.spring_torque(rows[0])
    return torque.reshape(q.shape)
