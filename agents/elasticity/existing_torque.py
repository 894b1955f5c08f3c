"""What the controller that is there gives when the motors lead the arm: its rigid feed-forward, and its servo."""

import numpy as np

from ffgym.agents.elasticity.lead import Lead
from ffgym.core.types import Array
from ffgym.robot import RigidArm


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


def wound_up(integral: Array, controller: RigidArm, load: Array) -> Array:
    """Integral of the lead as the servo knows it: its own integral ends where it alone would give the peak torque.

    Args:
        integral: integral of the lead since the start, link side [rad s], shape (..., N).
        controller: rigid dynamics and servo of the existing controller.
        load: what the links weigh at the start, which the servo's integral carries there, link side [N m], (..., N).
    """
    drive, gain = controller.robot.drive, controller.robot.servo.integral_gain
    reach = np.divide(drive.peak_torque, gain, out=np.full_like(gain, np.inf), where=gain > 0)
    carried = np.divide(drive.motor_torque(load), gain, out=np.zeros_like(load), where=gain > 0)
    turned = drive.motor_angle(integral)
    ended = np.clip(turned, carried - reach, carried + reach)
    beyond = np.any(ended != turned, axis=-1, keepdims=True)
    return np.where(beyond, drive.joint_angle(ended), integral)


def wound_up_sums(increments: Array, controller: RigidArm, load: Array) -> Array:
    """Running sums of `increments` (T, N) [rad s] from 0 on, each as `wound_up` leaves it, shape (T + 1, N)."""
    sums = np.zeros((len(increments) + 1, increments.shape[1]))
    np.cumsum(increments, axis=0, out=sums[1:])
    if np.array_equal(wound_up(sums, controller, np.broadcast_to(load, sums.shape)), sums):
        return sums
    for k, increment in enumerate(increments):
        sums[k + 1] = wound_up(sums[k] + increment, controller, load)
    return sums


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
