"""What the motors of a rigid arm must give for a motion, part by part: the complete inverse dynamics, motor side."""

from dataclasses import dataclass

from ffgym.core.errors import check_shape
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
