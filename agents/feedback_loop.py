"""Linear model of the servo loops along a reference: effect of a small added torque on the feedback of each motor.

Each motor stands for itself, with the link behind it, and moves a little (by theta) off the motion that follows the
reference exactly. Motor side, with w = d theta / dt, and deflection d of the joint:

    J_m dw/dt             = tau - K_p theta - K_v w - K_i int(theta) - tau_f + K d + D dd/dt
    J_l (dw/dt + d2d/dt2) = -K d - D dd/dt - tau_a

tau_f is LuGre friction, linear in small deviations of speed and bristle; its slopes change along the reference, so that
bristles hold a motor where it turns back, and hardly at all where it slides. tau_a is the share of it behind the
elasticity, with bristles of its own, by the speed of the link. J_l is the diagonal of the mass matrix at
the mean posture, as if the other joints stood still; couplings between axes are left out. The servo is that of
`ffgym.control.setpoints`.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from ffgym.agents.trials import SIGNALS, Signal
from ffgym.core.errors import check_choice
from ffgym.core.types import Array
from ffgym.robot import RigidArm, RobotDescription, Servo
from ffgym.robot.friction import LuGreParameters

_STATES = 6
_ANGLE, _RATE, _INTEGRAL, _BRISTLE, _DEFLECTION, _DEFLECTION_RATE = range(_STATES)
"""State of a motor: deviations from the reference, motor side. Bristles on the arm follow where there are some."""
_ARM_BRISTLE = _STATES


@dataclass(frozen=True, kw_only=True, eq=False)
class FeedbackLoop:
    """The loops of N motors between R rows: x[k + 1] = transition[k] x[k] + entry[k] tau, tau midway between rows."""

    servo: Servo
    transition: Array
    """Shape (R - 1, N, S, S): S is 6, or 7 with friction on an arm."""
    entry: Array
    """Shape (R - 1, N, S, 1)."""

    @classmethod
    def along(cls, arm: RigidArm, q: Array, motor_dq: Array, z: Array, dt: float, *, on_arm: bool = False) -> Self:
        """Linearise the loops about motor speeds `motor_dq` [rad/s] and bristles `z` [rad]; by the trapezoidal rule.

        Args:
            arm: nominal model of the robot.
            q: posture that stands for the whole motion, link side [rad], shape (N,).
            motor_dq: shape (R, N).
            z: shape (R, N), see `nominal_bristles`.
            dt: time between rows [s].
            on_arm: True for the effect of torque on the links instead of the motors.
        """
        link_inertia = np.diag(arm.mass_matrix(q[None])[0])
        system, push = _equations(arm.robot, link_inertia, _midway(motor_dq), _midway(z))
        if on_arm:
            push = _push_on_arm(arm.robot, link_inertia, push)
        one, half = np.eye(system.shape[-1]), system * (dt / 2)
        known = np.concatenate([one + half, np.broadcast_to(push * dt, (*system.shape[:-1], 1))], axis=-1)
        step = np.linalg.solve(one - half, known)
        # copies, so that each of the many small products in `loss` reads memory in order
        return cls(servo=arm.robot.servo, transition=step[..., :-1].copy(), entry=step[..., -1:].copy())

    def loss(self, torque: Array, signal: Signal = "u_p") -> Array:
        """Compute the learning signal's loss to added torque [N m]; both motor side, shape (R, N, K) for K torques."""
        check_choice("learning signal", signal, SIGNALS)
        # gains from state to learning signal
        read = np.zeros((len(self.servo.position_gain), 1, self.transition.shape[-1]))
        read[:, 0, _ANGLE] = self.servo.position_gain
        if signal != "e_p":
            read[:, 0, _RATE] = self.servo.velocity_gain
        if signal == "u_c":
            read[:, 0, _INTEGRAL] = self.servo.integral_gain
        # response of the loops, row by row
        midway = _midway(torque)[:, :, None]
        state = np.zeros((*self.transition.shape[1:3], torque.shape[2]))
        loss = np.zeros_like(torque)
        for k, transition in enumerate(self.transition):
            state = transition @ state + self.entry[k] * midway[k]
            loss[k + 1] = (read @ state)[:, 0]
        return loss


def nominal_bristles(friction: LuGreParameters, motor_dq: Array, dt: float) -> Array:
    """Integrate bristle deflection [rad] of motors at speeds (R, N) [rad/s] every `dt` [s]; relaxed at first."""
    keep, gain = friction.exact_bristle_factors(_midway(motor_dq), dt)
    z = np.zeros_like(motor_dq)
    for k in range(len(keep)):
        z[k + 1] = keep[k] * z[k] + gain[k]
    return z


def _equations(robot: RobotDescription, link_inertia: Array, motor_dq: Array, z: Array) -> tuple[Array, Array]:
    """Build system (..., N, S, S) and push (N, S, 1) of dx/dt = system x + push tau at speeds and bristles (..., N)."""
    # inertias and spring of each joint, motor side; a rigid joint turns its link with the rotor
    drive, servo, friction = robot.drive, robot.servo, robot.friction
    elastic, square = ~drive.is_rigid, drive.gear_ratio**2
    link = link_inertia / square
    rotor = drive.rotor_inertia + np.where(elastic, 0.0, link)
    stiffness, damping = (np.where(elastic, x, 0.0) / square for x in (drive.joint_stiffness, drive.joint_damping))
    by_speed, by_bristle = friction.bristle_rate_slopes(z, motor_dq)

    # torque on the motor per unit of each state; it has what the arm leaves of the friction
    behind = bool(np.any(robot.arm_share))
    states, own = _STATES + behind, 1 - robot.arm_share
    torque = np.zeros((*motor_dq.shape, states))
    torque[..., _ANGLE] = -servo.position_gain
    torque[..., _RATE] = -(servo.velocity_gain + own * friction.viscous + own * friction.bristle_damping * by_speed)
    torque[..., _INTEGRAL] = -servo.integral_gain
    torque[..., _BRISTLE] = -own * (friction.bristle_stiffness + friction.bristle_damping * by_bristle)
    torque[..., _DEFLECTION] = stiffness
    torque[..., _DEFLECTION_RATE] = damping

    # equations of motion: integrators, bristles, motor, and deflection behind it
    system, push = np.zeros((*motor_dq.shape, states, states)), np.zeros((robot.n_joints, states, 1))
    system[..., _ANGLE, _RATE] = system[..., _INTEGRAL, _ANGLE] = system[..., _DEFLECTION, _DEFLECTION_RATE] = 1.0
    system[..., _BRISTLE, _RATE], system[..., _BRISTLE, _BRISTLE] = by_speed, by_bristle
    system[..., _RATE, :] = torque / rotor[:, None]
    push[:, _RATE, 0] = 1 / rotor
    system[..., elastic, _DEFLECTION_RATE, :] = -system[..., elastic, _RATE, :]
    system[..., _DEFLECTION_RATE, _DEFLECTION] -= stiffness / link
    system[..., _DEFLECTION_RATE, _DEFLECTION_RATE] -= damping / link
    push[elastic, _DEFLECTION_RATE] = -push[elastic, _RATE]
    if behind:
        # bristles by the speed of the link, and their torque on it
        speed = [_RATE, _DEFLECTION_RATE]
        system[..., _ARM_BRISTLE, speed] = by_speed[..., None]
        system[..., _ARM_BRISTLE, _ARM_BRISTLE] = by_bristle
        by_rate = robot.arm_share * (friction.viscous + friction.bristle_damping * by_speed)
        by_bend = robot.arm_share * (friction.bristle_stiffness + friction.bristle_damping * by_bristle)
        system[..., _DEFLECTION_RATE, speed] -= (by_rate / link)[..., None]
        system[..., _DEFLECTION_RATE, _ARM_BRISTLE] -= by_bend / link
    return system, push


def _push_on_arm(robot: RobotDescription, link_inertia: Array, push: Array) -> Array:
    """Build the push (N, S, 1) of torque on links, motor side; a rigid joint turns them with its motor."""
    on_link = np.zeros_like(push)
    on_link[:, _DEFLECTION_RATE, 0] = robot.drive.gear_ratio**2 / link_inertia
    return np.where(robot.drive.is_rigid[:, None, None], push, on_link)


def _midway(rows: Array) -> Array:
    return (rows[1:] + rows[:-1]) / 2
