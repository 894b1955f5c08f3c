r"""Motion of the links behind elastic joints, from that of the motors and the torque that the links take.

.. math:: K \delta = -\tau(q, \dot q, \ddot q), \quad q_{link} = q + \delta

with positions q of rigid joints at the measured motor angles. Sag and windup are small against the motion, so that the
torque is taken at q, of the parameters that are known so far.
"""

from dataclasses import replace

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.identification.rigid_body.regressor import body_torque
from ffgym.diagnosis.identification.rigid_body.term import Motion
from ffgym.robot import RigidArm, RobotDescription


def rigid_motion(robot: RobotDescription, q: Array, dq: Array, ddq: Array) -> Motion:
    """Motion of an arm with rigid joints; joint positions, speeds and accelerations have shape (T, N)."""
    drive = robot.drive
    return Motion(q=q, dq=dq, ddq=ddq, motor_dq=drive.motor_angle(dq), motor_ddq=drive.motor_angle(ddq))


def elastic_motion(robot: RobotDescription, motion: Motion, bodies: Array, dt: float) -> Motion:
    """The same motion of the motors, with what the joints bend.

    Args:
        robot: its joint stiffness counts, and its springs.
        motion: of an arm with rigid joints, sampled every `dt`.
        bodies: inertial parameters of all bodies, shape (10 B,).
        dt: sample period [s].
    """
    if robot.drive.is_rigid.all():
        return motion
    torque = body_torque(robot, bodies.reshape(-1, 10), motion.q, motion.dq, motion.ddq)
    torque += RigidArm(robot).spring_torque(motion.q)
    bend = -torque / robot.drive.joint_stiffness
    rate = np.gradient(bend, dt, axis=0)
    return replace(motion, q=motion.q + bend, dq=motion.dq + rate, ddq=motion.ddq + np.gradient(rate, dt, axis=0))
