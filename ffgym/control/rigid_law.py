"""The existing feed-forward of the robot: torque that a rigid arm would need, without gravity and friction."""

from ffgym.core.types import Array
from ffgym.paths.reference import Reference
from ffgym.robot import RigidArm


def rigid_feedforward(arm: RigidArm, reference: Reference) -> Array:
    r"""Feed-forward torque u_ff, motor side [N m], shape (T, N).

    .. math:: u_{ff} = G^{-T} (M(q) \ddot q + C(q, \dot q) \dot q) + J_m \ddot\theta

    Gravity and friction are left to the feedback, as in the thesis (2.13).
    """
    drive = reference.robot.drive
    links = arm.inverse_dynamics(reference.q, reference.dq, reference.ddq)
    return drive.motor_torque(links) + drive.rotor_inertia * reference.motor_ddq
