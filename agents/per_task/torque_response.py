"""How the controlled robot answers a small added torque: a linear model from the nominal description.

Motors (rotor inertia, servo with its integral, viscous friction) and links (mass matrix, joint stiffness and damping)
at one posture, all joints coupled. Of friction, only the viscous part is in it: bristles are bent while a motor slides
and hold it like springs where it turns back. There, a model without bristles answers slow torques 1 + sigma_0 / K_p =
3 to 8 times as much as the machine, so that corrections by its inverse are too small rather than too large.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.linalg import block_diag, expm

from ffgym.core.errors import check_choice
from ffgym.core.types import Array
from ffgym.robot import RigidArm, RobotDescription

Target = Literal["motor", "tcp"]
TARGETS: tuple[Target, ...] = ("motor", "tcp")
"""What is observed: motor positions [rad], motor side, m = N numbers; or the TCP position [m], world, m = 3."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TorqueResponse:
    r"""Answer y to torque samples u every `dt` that are joined by straight lines, exact at the samples.

    .. math:: s_{k+1} = A s_k + B u_k, \quad y_k = C s_k + D u_k

    The state s is the physical one less what u_k has done to it already within the step that leads to t[k]: a straight
    line makes the torque of a sample act before the sample.
    """

    transition: Array
    """A, shape (S, S)."""
    entry: Array
    """B, shape (S, N)."""
    output: Array
    """C, shape (m, S)."""
    direct: Array
    """D, shape (m, N)."""

    @classmethod
    def of(cls, arm: RigidArm, q: Array, target: Target) -> "TorqueResponse":
        """Model at joint angles `q` (N,), link side [rad].

        Raises:
            FFGymError: if the target is unknown, or is the TCP of a robot without tool.
        """
        check_choice("target", target, TARGETS)
        system, push = _motion(arm, q)
        states, motors = push.shape
        dt = arm.robot.servo.control_dt
        ramp = np.zeros((states + 2 * motors, states + 2 * motors))  # state, torque, and its slope per step
        ramp[:states, :states], ramp[:states, states : states + motors] = system * dt, push * dt
        ramp[states : states + motors, states + motors :] = np.eye(motors)
        step = expm(ramp)[:states]
        transition, held, ramped = np.split(step, [states, states + motors], axis=1)
        observed = _observed(arm, q, target, states)
        return cls(
            transition=transition,
            entry=transition @ ramped + (held - ramped),
            output=observed,
            direct=observed @ ramped,
        )

    def along(self, torque: Array) -> Array:
        """Answer (T, m) to torque samples (T, N) [N m], from rest."""
        state = np.zeros(len(self.transition))
        answer = np.empty((len(torque), len(self.output)))
        for k, u in enumerate(torque):
            answer[k] = self.output @ state + self.direct @ u
            state = self.transition @ state + self.entry @ u
        return answer


def _motion(arm: RigidArm, q: Array) -> tuple[Array, Array]:
    """Matrices of ds/dt = A s + B u; s holds positions, their rates, and the integrals of the position error.

    Positions are those of motors (divided by gear ratio) and deflections; a link turns by their sum.
    """
    robot = arm.robot
    drive, servo = robot.drive, robot.servo
    elastic = ~drive.is_rigid
    links = _links(robot)
    inertia = links.T @ arm.mass_matrix(q[None])[0] @ links
    inertia += _blocks(robot, drive.rotor_inertia, np.zeros(elastic.sum()))
    stiffness = _blocks(robot, servo.position_gain, drive.joint_stiffness[elastic])
    damping = _blocks(robot, servo.velocity_gain + robot.friction.viscous, drive.joint_damping[elastic])
    motors = np.eye(robot.n_joints, len(inertia)).T @ drive.matrix.T  # motor torque on positions; transposed, angles
    kept = servo.integral_gain > 0
    integrals = motors[:, kept] * servo.integral_gain[kept]
    n, m = len(inertia), int(kept.sum())
    system = np.zeros((2 * n + m, 2 * n + m))
    system[:n, n : 2 * n] = np.eye(n)
    system[n : 2 * n] = np.linalg.solve(inertia, np.hstack([-stiffness, -damping, integrals]))
    system[2 * n :, :n] = -motors[:, kept].T
    push = np.zeros((2 * n + m, robot.n_joints))
    push[n : 2 * n] = np.linalg.solve(inertia, motors)
    return system, push


def _observed(arm: RigidArm, q: Array, target: Target, states: int) -> Array:
    """Rows that read the target from the state, shape (m, states)."""
    links = _links(arm.robot)
    motors = arm.robot.drive.matrix @ np.eye(*links.shape)
    rows = motors if target == "motor" else arm.jacobian(q[None])[0, :3] @ links
    return np.hstack([rows, np.zeros((len(rows), states - links.shape[1]))])


def _links(robot: RobotDescription) -> Array:
    """Link angles from motor angles and deflections: their sum; rigid joints have no deflection."""
    return np.hstack([np.eye(robot.n_joints), np.eye(robot.n_joints)[:, ~robot.drive.is_rigid]])


def _blocks(robot: RobotDescription, motors: Array, deflections: Array) -> Array:
    """Matrix on positions, of coefficients of the motors, motor side (N,), and of the deflections, link side."""
    gear = robot.drive.matrix
    return block_diag(gear.T @ (motors[:, None] * gear), np.diag(deflections))
