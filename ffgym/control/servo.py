"""The parts of the existing controller's torque, as the engine's `pid` adds them up in each step."""

from dataclasses import dataclass

from ffgym.core.types import Array
from ffgym.robot.parts import Servo


@dataclass(frozen=True, kw_only=True, eq=False)
class ServoTorque:
    """Feedback torque and its integral part, motor side [N m], any shape (..., N)."""

    u_fb: Array
    """All of the feedback, thesis' u_c."""
    u_i: Array
    """Its integral part."""

    @property
    def u_p(self) -> Array:
        """What is left without the integral part, u_p = u_fb - u_i: the learning signal of chapter 5."""
        return self.u_fb - self.u_i


def servo_torque(servo: Servo, error: Array, error_rate: Array, integral: Array) -> ServoTorque:
    r"""Feedback torque before the drive's limit, motor side.

    .. math:: u_c = K_p e + K_v \dot e + u_I, \quad u_I = K_i \int e \, dt

    Args:
        servo: gains.
        error: position error e = reference - measured [rad], shape (..., N).
        error_rate: speed error [rad/s], shape (..., N).
        integral: integral of the position error [rad s], shape (..., N).
    """
    u_i = servo.integral_gain * integral
    return ServoTorque(u_fb=servo.position_gain * error + servo.velocity_gain * error_rate + u_i, u_i=u_i)
