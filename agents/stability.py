r"""Stability of learning with B-spline networks, thesis (5.5), predicted from the robot's description alone.

Along a given motion, the torque of the feedback is nearly linear in the weights of a joint, and so is one iteration:

.. math::
    u_p(w) = u_p(0) - G B w, \qquad w_+ = w + \gamma N B^T u_p(w) = (I - \gamma L) w + const, \qquad L = N B^T G B

B holds the splines along the motion, N is diagonal with one over the sum of each spline (the identity for updates that
are not normalised, thesis (3.16)), and G is the effect of added
torque on the feedback (`ffgym.agents.feedback_loop`). A pattern of weights that is an eigenvector of L changes by the
factor 1 - gamma lambda in each iteration. Learning is stable while no factor is larger than 1. Thesis 7.2 leaves this
open; `ffgym.agents.changing_motions` has trials that each run another motion.

Run it:

    ffgym train stability --network extended --gamma 0.95

Reported per motion and joint: `largest_rate`, the largest gamma with |1 - gamma lambda| <= 1.001 for all lambda;
`growth`, max |1 - gamma lambda| at the given rate; and the RMS of the learning signal predicted to be left.

Departures from the source: none. Limits: each joint by itself, small deviations from the reference;
`docs/agents/learning_stability.md` compares with simulation.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Self

import numpy as np
import scipy

from ffgym.agents.bspline import BSplineNetwork
from ffgym.agents.learned_motion import LearnedMotion
from ffgym.agents.lffc import LFFC
from ffgym.agents.trials import Signal, SimulatedTrial
from ffgym.core.errors import FFGymError, check_number, check_whole
from ffgym.core.types import Array, ComplexArray, IntArray
from ffgym.paths import Reference
from ffgym.report.learning_plots import LearningCurves
from ffgym.robot import RigidArm
from ffgym.simulation import RECORD_DT

STABLE_GROWTH = 1.001
"""Growth per iteration that still counts as stable. Chosen: doubling takes 700 iterations, more than any training; and
patterns without effect, whose factor is 1 but for rounding, pass."""
_STILL = 1e-9
"""Motor speed [rad/s] of what stands still; chosen, a turn takes centuries."""
MOST_ITERATIONS = 100_000
"""Most iterations that are predicted; chosen, they take seconds for each joint."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LearningMap:
    """Learning of one joint, from T rows in which K of its splines are met."""

    average: "scipy.sparse.csr_array"
    """N B^T, which maps the learning signal to the change of weights at rate 1, shape (K, T)."""
    loss: Array
    """G B, the loss of the learning signal to each weight, shape (T, K)."""
    signal: Array
    """Learning signal with the weights that learning starts from, as predicted, motor side [N m], shape (T,)."""
    splines: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """Numbers of the splines that are met among the weights of the joint, shape (K,)."""

    @cached_property
    def eigenvalues(self) -> ComplexArray:
        """Eigenvalues of L = N B^T G B, shape (K,)."""
        return np.linalg.eigvals(self.average @ self.loss).astype(np.complex128)

    def fastest(self, rate: float) -> complex:
        """Find the eigenvalue of the pattern of weights that grows fastest (or shrinks slowest) at a learning rate."""
        return complex(self.eigenvalues[np.abs(1 - rate * self.eigenvalues).argmax()])

    def growth(self, rate: float) -> float:
        """Compute the factor by which that pattern changes in each iteration; 1 or less is stable."""
        return abs(1 - rate * self.fastest(rate))

    @property
    def largest_rate(self) -> float:
        r"""Largest gamma with :math:`|1 - \gamma \lambda| \le` STABLE_GROWTH for every eigenvalue."""
        real, square = self.eigenvalues.real, np.abs(self.eigenvalues) ** 2
        root = real + np.sqrt(real**2 + square * (STABLE_GROWTH**2 - 1))
        return float(np.divide(root, square, out=np.full(len(root), np.inf), where=square > 0).min())

    def mean_squares(self, rate: float, iterations: int) -> Array:
        """Predict mean squares of the learning signal [(N m)^2], at first and after each of I iterations, (I + 1,)."""
        iterations = check_whole("iterations", iterations, low=0, high=MOST_ITERATIONS)
        weights, history = np.zeros(self.loss.shape[1]), np.full(iterations + 1, np.inf)
        with np.errstate(over="ignore", invalid="ignore"):  # what grows beyond all numbers is infinite from then on
            for i in range(iterations + 1):
                rest = self.signal - self.loss @ weights
                if not np.isfinite(square := np.mean(rest**2)):
                    break
                history[i] = square
                weights = weights + rate * (self.average @ rest)
        return history


@dataclass(frozen=True, kw_only=True, eq=False)
class LearningStability:
    """Prediction of learning along some motions at any rate, joint by joint."""

    joints: tuple[str, ...]
    maps: tuple[LearningMap, ...]
    """Learning map of each joint."""
    cure: str = ""
    """Advice against a pattern that grows at every rate; empty if there is none."""

    @classmethod
    def of(
        cls,
        network: BSplineNetwork,
        arm: RigidArm,
        references: Sequence[Reference],
        *,
        signal: Signal = "u_p",
        record_dt: float = RECORD_DT,
    ) -> Self:
        """Predict the learning of `network`.

        Args:
            network: network with the weights that learning starts from.
            arm: nominal model of the robot.
            references: the motions of one trial.
            signal: learning signal.
            record_dt: time between the rows that are learned from [s]; it divides the control step.

        Raises:
            FFGymError: if nothing moves, joints do not fit, or `record_dt` does not divide the control step.
        """
        for reference in references:
            network.check_joints(reference)
        motions = [LearnedMotion.along(reference, record_dt) for reference in references]
        if not any(np.any(np.abs(motion.motor_dq[motion.learned]) > _STILL) for motion in motions):
            names = [reference.name for reference in references]
            raise FFGymError(f"Nothing can be learned from {names}: nothing moves.")
        # splines of each joint along all motions, those that are met, and the signal's loss to them
        splines = [
            scipy.sparse.vstack([motion.splines(network, joint) for motion in motions])
            for joint in range(network.n_joints)
        ]
        met = [np.flatnonzero(part.sum(axis=0)) for part in splines]
        losses = np.concatenate([motion.losses(network, arm, met, signal) for motion in motions])
        # average and loss of each joint on the splines that are met
        maps = []
        for joint, (part, columns) in enumerate(zip(splines, met, strict=True)):
            own = scipy.sparse.csr_array(part[:, columns])
            scale = 1 / own.sum(axis=0) if network.normalised else np.ones(len(columns))
            average = scipy.sparse.csr_array(scipy.sparse.diags_array(scale) @ own.T)
            loss = losses[:, joint, : len(columns)].copy()
            start = losses[:, joint, -1].copy()
            maps.append(LearningMap(average=average, loss=loss, signal=start, splines=columns))
        # advice by the cause of growth
        cure = ""
        if signal == "e_p":  # the angle lags behind the torque, whatever the rows
            cure = ", learning from u_p may stop it"
        elif record_dt < 0.99 * arm.robot.servo.control_dt:
            cure = ", learning from the samples of the reference alone may stop it"
        return cls(joints=arm.robot.joints, maps=tuple(maps), cure=cure)

    @property
    def largest_rate(self) -> Array:
        """Largest stable learning rate of each joint, shape (N,)."""
        return np.array([each.largest_rate for each in self.maps])

    def growth(self, rate: float) -> Array:
        """Compute the factor by which the fastest growing pattern of each joint changes in an iteration, shape (N,)."""
        check_number("learning rate", rate, low=0.0)
        return np.array([each.growth(rate) for each in self.maps])

    def mean_squares(self, rate: float, iterations: int) -> Array:
        """Predict the mean square of the learning signal [(N m)^2], at first and after each iteration, (I + 1, N)."""
        return np.stack([each.mean_squares(rate, iterations) for each in self.maps], axis=1)

    def warning(self, rate: float) -> str | None:
        """Return a warning if `rate` is above the largest stable one of a joint, else None."""
        limits, growth = self.largest_rate, self.growth(rate)
        above = [f"{joint} {limit:.2g}" for joint, limit in zip(self.joints, limits, strict=True) if rate > limit]
        if not above:
            return None
        worst = int(growth.argmax())
        grows_at_every_rate = self.maps[worst].fastest(rate).real <= 0
        remedy = f"a lower rate only slows it down{self.cure}" if grows_at_every_rate else "lower the rate"
        return (
            f"learning rate {rate:g} is above the largest stable one ({', '.join(above)}): on {self.joints[worst]} a "
            f"pattern of weights grows by {growth[worst] - 1:.1%} in each iteration; {remedy}"
        )


def learning_curves(
    network: BSplineNetwork,
    trial: SimulatedTrial,
    reference: Reference,
    rates: Sequence[float],
    iterations: int,
    *,
    signal: Signal = "u_p",
) -> list[LearningCurves]:
    """Compute the mean square of the learning signal, predicted and simulated, joint by joint, for `learning_figure`.

    Args:
        network: network with the weights that learning starts from.
        trial: simulated trials; their nominal model predicts.
        reference: the motion.
        rates: learning rates; learning at each of them runs to the end, whether it grows or falls.
        iterations: updates after the first trial.
        signal: learning signal.
    """
    stability = LearningStability.of(network, trial.arm, [reference], signal=signal, record_dt=trial.record_dt)
    predicted = np.stack([stability.mean_squares(rate, iterations) for rate in rates])
    procedures = [LFFC(rate=rate, iterations=iterations, signal=signal, patience=iterations + 1) for rate in rates]
    simulated = np.stack([lffc.learn(network, [reference], trial).signal[:, 0] for lffc in procedures])
    return [
        LearningCurves(
            title=f"{joint}, {reference.name}",
            rates=np.array(rates),
            predicted=predicted[:, :, j],
            simulated=simulated[:, :, j],
            eigenvalues=each.eigenvalues,
            largest_rate=each.largest_rate,
        )
        for j, (joint, each) in enumerate(zip(stability.joints, stability.maps, strict=True))
    ]
