r"""Iterative learning that carries over to other motions: corrections are weights of basis functions of the reference.

Idea and source: torque learned sample by sample (`ffgym.agents.iterative`) is right for one motion. Where it is written
in basis functions of the reference, u = base + Psi(r) theta, learning finds theta, and any other motion r has a torque
at once (van de Wijdeven and Bosgra 2010, Int. J. Control 83(12), Using basis functions in iterative learning control;
Bolder and Oomen 2015, IEEE Trans. Control Syst. Technol. 23(2)). Trial j runs the motions with theta_j, measures the
way of the tool, e_j, and

    theta_{j+1} = argmin_theta  sum_k |e_j - G Psi (theta - theta_j)|_k^2 / epsilon^2 + |theta|^2 / p^2

with G the linear response of the nominal model (`ffgym.agents.torque_response`), epsilon as in
`ffgym.agents.iterative`, and p the prior spread of a weight.

Basis functions of a motor are torques that the nominal model knows along the reference: bristle friction, viscous
friction, inertia of the rotor, and what the links need beyond the start. A weight of 0.1 means a tenth more of it than
the model believes. Those that also bend the spring behind the motor ask for another lead x / K of the motor, which the
servo answers with its position, speed and integral parts; this torque is a basis function of its own.

Run it:

    python -m scripts.adaptation --adapters ilc_basis

Logged: nothing; the law returned is the one after the last trial.

Departures from the sources: the base is elastic feed-forward; weights go through the nominal response, not one that
was measured.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.agents.flexible_joints import links_torque
from ffgym.agents.iterative import TOLERANCES
from ffgym.agents.torque_response import TorqueResponse, task_error
from ffgym.agents.trials import Trial, run_trial
from ffgym.control import DynamicLuGreExact, FeedForwardLaw
from ffgym.core.errors import check_shape
from ffgym.core.types import Array
from ffgym.paths import Reference
from ffgym.robot import RigidArm
from ffgym.simulation import Run

N_BASIS = 7
"""Number B of basis functions of each motor: four torques, and the leads of three of them."""
PRIOR_SPREAD = 0.3
"""p, in parts of what the nominal model believes; chosen: friction, stiffness and masses differ by that much."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class BasisLaw(FeedForwardLaw):
    """Torque of a base law and weighted basis functions of the reference."""

    arm: RigidArm
    """Nominal model, whose torques basis functions are."""
    base: FeedForwardLaw
    weights: Array
    """Weights theta, shape (N, B)."""
    name: str = "ilc_basis"

    def __post_init__(self) -> None:
        check_shape("weights of basis functions", self.weights, (self.arm.robot.n_joints, N_BASIS))

    def torque(self, reference: Reference) -> Array:
        """Return the torque at every sample, motor side [N m], shape (T, N)."""
        added = np.einsum("tnb,nb->tn", basis_torques(self.arm, reference), self.weights)
        return self.base.torque(reference) + added


def basis_torques(arm: RigidArm, reference: Reference) -> Array:
    """Compute basis functions of every motor along a reference, motor side [N m], (T, N, B); zero at sample 0."""
    robot, drive, servo, dt = arm.robot, arm.robot.drive, arm.robot.servo, reference.robot.servo.control_dt
    viscous = robot.friction.viscous * reference.motor_dq
    bristles = DynamicLuGreExact(robot.friction).torque(reference) - viscous
    links = links_torque(arm, reference.q, reference.motor_dq, reference.motor_ddq, load=True)
    links = drive.motor_torque(links - links[0])
    rotor = drive.rotor_inertia * reference.motor_ddq
    # what the servo answers to a lead of the motor, by which a torque of the motor side bends the spring
    bent = np.stack([bristles, viscous, links]) * (drive.gear_ratio**2 / drive.joint_stiffness)
    leads = (
        servo.position_gain * bent
        + servo.velocity_gain * np.gradient(bent, dt, axis=1)
        + servo.integral_gain * np.cumsum(bent, axis=1) * dt
    )
    basis = np.stack([bristles, viscous, rotor, links, *leads], axis=2)
    basis[0] = 0.0
    return np.asarray(basis)


def learn_basis_weights(
    arm: RigidArm, base: FeedForwardLaw, references: Sequence[Reference], trial: Trial, trials: int
) -> BasisLaw:
    """Learn the weights of basis functions from the tool's errors in a number of trials of some motions.

    Raises:
        FFGymError: if a recording lacks the tool.
    """
    basis = [basis_torques(arm, reference) for reference in references]
    regressors = [_respond(arm, reference, each) for reference, each in zip(references, basis, strict=True)]
    epsilon = TOLERANCES["tcp"]
    law = BasisLaw(arm=arm, base=base, weights=np.zeros((arm.robot.n_joints, N_BASIS)))
    # least squares of the weights, errors above their prior
    prior = np.eye(law.weights.size) / PRIOR_SPREAD
    matrix = np.concatenate([*(each / epsilon for each in regressors), prior])
    for number in range(trials):
        recordings = run_trial(trial, [Run(reference=reference, law=law) for reference in references], number)
        errors = [
            task_error(recording, reference, "tcp").ravel() / epsilon
            for recording, reference in zip(recordings, references, strict=True)
        ]
        wanted = np.concatenate([*errors, -prior @ law.weights.ravel()])
        step = np.linalg.lstsq(matrix, wanted)[0]
        law = BasisLaw(arm=arm, base=base, weights=law.weights + step.reshape(law.weights.shape))
    return law


def _respond(arm: RigidArm, reference: Reference, basis: Array) -> Array:
    """Compute the tool's answer to each basis function, shape (3 T, N B)."""
    middle = (reference.q.min(axis=0) + reference.q.max(axis=0)) / 2
    response = TorqueResponse.of(arm, middle, "tcp")
    samples, motors, size = basis.shape
    answers = np.empty((samples, 3, motors, size))
    for motor in range(motors):
        for k in range(size):
            torque = np.zeros((samples, motors))
            torque[:, motor] = basis[:, motor, k]
            answers[:, :, motor, k] = response.along(torque)
    return answers.reshape(3 * samples, motors * size)
