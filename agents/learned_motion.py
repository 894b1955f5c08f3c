"""Splines along a motion that a network learns from, and the signal's losses to their weights; see `stability`."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil
from typing import TYPE_CHECKING, Self

import numpy as np

from ffgym.agents.bspline import BSplineNetwork
from ffgym.agents.feedback_loop import FeedbackLoop, nominal_bristles
from ffgym.agents.trials import Signal
from ffgym.control import Setpoints
from ffgym.control.setpoints import torque_at_rows
from ffgym.core.errors import FFGymError, check_number
from ffgym.core.types import Array, IntArray
from ffgym.paths import Reference
from ffgym.robot import RigidArm

if TYPE_CHECKING:
    import scipy

_STEPS = 4
"""Least number of model steps in a control step (1 ms). Chosen: four times as many change no largest stable rate on the
test motions by more than 0.5 %."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LearnedMotion:
    """One reference at the R rows of the model."""

    reference: Reference
    rows_per_step: int
    """Rows in a control step."""
    motor_dq: Array
    """[rad/s], shape (R, N)."""
    motor_ddq: Array
    """[rad/s^2], shape (R, N)."""
    q: Array
    """[rad], link side, shape (R, N)."""
    learned: IntArray
    """Rows that are learned from, shape (T,): those of a recording, without standstill."""

    @classmethod
    def along(cls, reference: Reference, record_dt: float) -> Self:
        """Sample a reference every `record_dt`, and between these rows if the model needs more."""
        servo = reference.robot.servo
        check_number("record_dt", record_dt, unit="s", low=0.0, open_low=True)
        most = reference.robot.n_substeps  # no recording has more rows in a control step
        recorded = round(min(servo.control_dt / record_dt, most + 1.0))
        if not 1 <= recorded <= most or abs(recorded * record_dt - servo.control_dt) > 1e-9:
            raise FFGymError(
                f"record_dt = {record_dt} s must divide control_dt = {servo.control_dt} s into {most} parts at most."
            )
        stride = ceil(_STEPS / recorded)
        setpoints = Setpoints(
            position=reference.motor_q[None],
            velocity=reference.motor_dq[None],
            torque=reference.motor_ddq[None],  # straight lines between samples, as lessons see it
            dt=servo.control_dt,
        )
        motor_q, motor_dq, motor_ddq = setpoints.at_rows(recorded * stride)
        rows = np.arange(0, motor_dq.shape[1], stride)
        t, moving = np.arange(len(rows), dtype=np.float64) * record_dt, np.zeros(len(rows), dtype=np.bool_)
        for phase in reference.phases:  # as in lessons
            if phase.kind != "standstill":
                moving |= (t >= phase.start) & (t < phase.end)
        return cls(
            reference=reference,
            rows_per_step=recorded * stride,
            motor_dq=motor_dq[0],
            motor_ddq=motor_ddq[0],
            q=reference.robot.drive.joint_angle(motor_q[0]),
            learned=rows[moving],
        )

    def splines(self, network: BSplineNetwork, joint: int) -> "scipy.sparse.csr_array":
        """Return the splines of a joint at the rows that are learned from, shape (T, S)."""
        motion = (self.motor_dq, self.motor_ddq, network.locate(self.q))
        return network.design_matrix(*(part[self.learned, joint] for part in motion))

    def losses(self, network: BSplineNetwork, arm: RigidArm, met: Sequence[IntArray], signal: Signal) -> Array:
        """Compute the signal's loss to each weight that is met, zeros, and last the signal at first; (T, N, K + 1).

        The signal at first is the loss to friction that the network does not compensate.
        """
        reference, friction = self.reference, arm.robot.friction
        dt = reference.robot.servo.control_dt / self.rows_per_step
        z = nominal_bristles(friction, self.motor_dq, dt)
        # torque of each spline, and last the friction that the network does not compensate
        torque = np.zeros((*reference.q.shape, max(len(columns) for columns in met) + 1))
        for joint, columns in enumerate(met):
            samples = (reference.motor_dq, reference.motor_ddq, network.locate(reference.q))
            splines = network.design_matrix(*(part[:, joint] for part in samples))
            torque[:, joint, : len(columns)] = splines[:, columns].toarray()
        torque[:, :, -1] = -network.torque(reference)
        torque[0] = 0.0  # no torque is computed before t = 0
        between = torque_at_rows(torque.reshape(len(torque), -1), self.rows_per_step).reshape(-1, *torque.shape[1:])
        total, share = friction.torque(z, self.motor_dq), arm.robot.arm_share
        between[:, :, -1] += (1 - share) * total
        # response of the feedback loops to all of them, and to friction behind the elasticity
        motion = (arm, reference.q.mean(axis=0), self.motor_dq, z, dt)
        losses = FeedbackLoop.along(*motion).loss(between, signal)
        if np.any(share):
            behind = FeedbackLoop.along(*motion, on_arm=True).loss((share * total)[:, :, None], signal)
            losses[:, :, -1] += behind[:, :, 0]
        return losses[self.learned]
