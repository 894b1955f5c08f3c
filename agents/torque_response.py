"""Linear response of the controlled robot to a small added torque, and the torque correction that is optimal for it.

The model comes from the nominal description: motors (rotor inertia, servo with its integral) and links (mass matrix,
joint stiffness and damping) at one posture, all joints coupled. Of friction, on motors and links, only the viscous part
is in it: bristles are bent while a motor slides and hold it like springs where it turns back. There, a model without
bristles answers slow torques 1 + sigma_0 / K_p = 3 to 8 times as much as the machine, so that corrections by its
inverse are too small rather than too large.

The correction is the step of norm-optimal learning control (Amann, Owens, Rogers (1996), Iterative learning control
using optimal feedback and feedforward actions, Int. J. Control 65(2)): the minimum over all samples of a motion is
found by one pass backward and one forward in time, with the gain of a Riccati equation. Departure: the gain is the
stationary one, as if the machine rested on after the motion.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy

from ffgym.core.errors import FFGymError, check_choice, check_number
from ffgym.core.measures import interpolate, rms_length
from ffgym.core.types import Array
from ffgym.paths import Reference
from ffgym.recordings import Recording
from ffgym.recordings.metrics import motor_error, standstill_offset
from ffgym.robot import RigidArm, RobotDescription

Target = Literal["motor", "tcp"]
TARGETS: tuple[Target, ...] = ("motor", "tcp")
"""Observed positions: motors [rad], motor side, m = N numbers; or the TCP [m], world, m = 3."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TorqueResponse:
    r"""Answer y to torque samples u every `dt` that are joined by straight lines, exact at the samples.

    .. math:: s_{k+1} = A s_k + B u_k, \quad y_k = C s_k + D u_k

    The state s is the physical one less the effect of u_k already within the step that leads to t[k]: a straight
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
        """Linearise the robot at joint angles `q` (N,), link side [rad].

        Raises:
            FFGymError: if the target is unknown, or is the TCP of a robot without tool.
        """
        check_choice("target", target, TARGETS)
        system, push = _motion(arm, q)
        states, motors = push.shape
        dt = arm.robot.servo.control_dt
        # exact discretisation for torque that runs straight between samples
        ramp = np.zeros((states + 2 * motors, states + 2 * motors))  # state, torque, and its slope per step
        ramp[:states, :states], ramp[:states, states : states + motors] = system * dt, push * dt
        ramp[states : states + motors, states + motors :] = np.eye(motors)
        step = scipy.linalg.expm(ramp)[:states]
        transition, held, ramped = np.split(step, [states, states + motors], axis=1)
        # output: motor positions or TCP
        links = _links(arm.robot)
        rows = (
            arm.robot.drive.matrix @ np.eye(*links.shape) if target == "motor" else arm.jacobian(q[None])[0, :3] @ links
        )
        observed = np.hstack([rows, np.zeros((len(rows), states - links.shape[1]))])
        return cls(
            transition=transition,
            entry=transition @ ramped + (held - ramped),
            output=observed,
            direct=observed @ ramped,
        )

    def along(self, torque: Array) -> Array:
        """Simulate the answer (T, m) to torque samples (T, N) [N m], from rest."""
        state = np.zeros(len(self.transition))
        answer = np.empty((len(torque), len(self.output)))
        for k, u in enumerate(torque):
            answer[k] = self.output @ state + self.direct @ u
            state = self.transition @ state + self.entry @ u
        return answer


def _motion(arm: RigidArm, q: Array) -> tuple[Array, Array]:
    """Build A and B of ds/dt = A s + B u; s holds positions, their rates, and the integrals of the position error.

    Positions are those of motors (divided by gear ratio) and deflections; a link turns by their sum.
    """
    robot = arm.robot
    drive, servo = robot.drive, robot.servo
    elastic = ~drive.is_rigid
    # inertia, stiffness and damping on positions
    links = _links(robot)
    inertia = links.T @ arm.mass_matrix(q[None])[0] @ links
    inertia += _blocks(robot, drive.rotor_inertia, np.zeros(elastic.sum()))
    stiffness = _blocks(robot, servo.position_gain, drive.joint_stiffness[elastic])
    on_arm, viscous = robot.arm_share, robot.friction.viscous
    damping = _blocks(robot, servo.velocity_gain + (1 - on_arm) * viscous, drive.joint_damping[elastic])
    damping += links.T @ np.diag(on_arm * viscous * drive.gear_ratio**2) @ links
    motors = np.eye(robot.n_joints, len(inertia)).T @ drive.matrix.T  # motor torque on positions; transposed, angles
    # servo integrals, where there are some
    kept = servo.integral_gain > 0
    integrals = motors[:, kept] * servo.integral_gain[kept]
    # first-order form
    n, m = len(inertia), int(kept.sum())
    system = np.zeros((2 * n + m, 2 * n + m))
    system[:n, n : 2 * n] = np.eye(n)
    system[n : 2 * n] = np.linalg.solve(inertia, np.hstack([-stiffness, -damping, integrals]))
    system[2 * n :, :n] = -motors[:, kept].T
    push = np.zeros((2 * n + m, robot.n_joints))
    push[n : 2 * n] = np.linalg.solve(inertia, motors)
    return system, push


def _links(robot: RobotDescription) -> Array:
    """Map motor angles and deflections to link angles: their sum; rigid joints have no deflection."""
    return np.hstack([np.eye(robot.n_joints), np.eye(robot.n_joints)[:, ~robot.drive.is_rigid]])


def _blocks(robot: RobotDescription, motors: Array, deflections: Array) -> Array:
    """Build the matrix on positions of coefficients of motors, motor side (N,), and of deflections, link side."""
    gear = robot.drive.matrix
    return scipy.linalg.block_diag(gear.T @ (motors[:, None] * gear), np.diag(deflections))


@dataclass(frozen=True, kw_only=True, eq=False)
class NormOptimalStep:
    r"""Least-squares correction :math:`\Delta u` of the torque for an error e, y the answer of the model.

    .. math:: \min_{\Delta u} \sum_k \frac{|e_k - y_k|^2}{\epsilon^2} + \sum_k \sum_i \frac{\Delta u_{k,i}^2}{f_{c,i}^2}
    """

    closed: Array
    """Transition of the model under the optimal feedback, A - B K, shape (S, S)."""
    gain: Array
    """Optimal feedback K, shape (N, S)."""
    entry: Array
    """B, shape (S, N)."""
    inverse: Array
    """Inverse of the cost of a torque, its consequences included, shape (N, N)."""
    from_error: Array
    """Gradient of the cost by the torque of an error's own sample, D^T / epsilon^2, shape (N, m)."""
    to_costate: Array
    """Gradient of the cost by the state before an error, (C - D K)^T / epsilon^2, shape (S, m)."""

    @classmethod
    def of(cls, response: TorqueResponse, tolerance: float, torque_scale: Array) -> "NormOptimalStep":
        """Solve the Riccati equation.

        Args:
            response: the model.
            tolerance: error epsilon that weighs as much as a correction of one `torque_scale`, unit of the error.
            torque_scale: f_c, e.g. the motors' Coulomb friction [N m], shape (N,).

        Raises:
            FFGymError: if the tolerance is not positive, or there is no solution.
        """
        tolerance = check_number("tolerance", tolerance, unit="rad or m", low=0.0, open_low=True)
        a, b, c, d = response.transition, response.entry, response.output, response.direct
        c_weighted, d_weighted = c.T / tolerance**2, d.T / tolerance**2
        own = np.diag(1 / torque_scale**2) + d_weighted @ d
        try:
            cost = scipy.linalg.solve_discrete_are(a, b, c_weighted @ c, own, s=c_weighted @ d)
        except scipy.linalg.LinAlgError as error:
            raise FFGymError(
                f"No torque correction can be computed: {error} The servo must hold every motor (position_gain > 0), "
                f"and the tolerance of {tolerance} must be neither far too small nor far too large."
            ) from error
        inverse = np.asarray(np.linalg.inv(own + b.T @ cost @ b), dtype=np.float64)
        gain = inverse @ (d_weighted @ c + b.T @ cost @ a)
        return cls(
            closed=a - b @ gain,
            gain=gain,
            entry=b,
            inverse=inverse,
            from_error=d_weighted,
            to_costate=c_weighted - gain.T @ d_weighted,
        )

    def correction(self, error: Array) -> Array:
        """Compute the torque to add [N m], shape (T, N), for an error (T, m); zero at sample 0, where none is set."""
        asked, before = error @ self.from_error.T, error @ self.to_costate.T
        # backward in time: costate
        costate = np.zeros(len(self.closed))
        push = np.zeros_like(asked)
        for k in range(len(error) - 1, 0, -1):
            push[k] = self.inverse @ (self.entry.T @ costate + asked[k])
            costate = self.closed.T @ costate + before[k]
        # forward in time: optimal feedback on the state
        state = np.zeros(len(self.closed))
        correction = np.zeros_like(push)
        for k in range(1, len(error)):
            correction[k] = push[k] - self.gain @ state
            state = self.closed @ state + self.entry @ push[k]
        return correction


def task_error(recording: Recording, reference: Reference, target: Target) -> Array:
    """Compute the error, reference minus measured, at every sample of the reference, shape (T, m).

    Motors [rad], motor side, m = N; or the TCP [m], world, m = 3, without its offset at the first standstill.

    Raises:
        FFGymError: if the recording lacks a column, or is not of this reference.
    """
    if target == "motor":
        return at_samples(motor_error(recording), recording, reference)
    away = recording.vector("tcp.position") - recording.vector("tcp_reference.position")
    return at_samples(standstill_offset(recording) - away, recording, reference)


def at_samples(rows: Array, recording: Recording, reference: Reference) -> Array:
    """Average recorded rows around each control sample, (T, m); the weight falls to 0 one sample away.

    Weights are symmetric, so that they add no delay. Rows with NaN, which a tracker did not see, are interpolated
    first.

    Raises:
        FFGymError: if the recording is not of this reference, or has no row that was seen.
    """
    per_sample = round(reference.robot.servo.control_dt / recording.dt)
    if len(rows) != (len(reference.t) - 1) * per_sample + 1:
        raise FFGymError(
            f"Recording {recording.header.segment!r} of {len(rows)} rows every {recording.dt:g} s is not of the "
            f"motion {reference.name!r}, which lasts {reference.duration:g} s."
        )
    seen = ~np.isnan(rows).any(axis=1)
    if not seen.any():
        raise FFGymError(f"Recording {recording.header.segment!r} has no row in which the TCP was seen.")
    if not seen.all():
        rows = interpolate(recording.t, recording.t[seen], rows[seen])
    weights = np.convolve(np.ones(per_sample), np.ones(per_sample)) / per_sample**2
    padded = np.pad(rows, ((per_sample - 1, per_sample - 1), (0, 0)), mode="edge")
    return np.stack([np.convolve(column, weights, mode="valid")[::per_sample] for column in padded.T], axis=1)


def circle_rms(error: Array, reference: Reference) -> dict[str, float]:
    """Compute the RMS length of an error (T, m) on each circle, by label; on the whole motion where there is none."""
    circles = [phase for phase in reference.phases if phase.kind == "circle"]
    if not circles:
        return {"motion": rms_length(error)}
    inside = {phase.label: (reference.t >= phase.start) & (reference.t < phase.end) for phase in circles}
    return {label: rms_length(error[rows]) for label, rows in inside.items()}
