"""First weights of a network from a constant friction torque, as thesis 5.5 proposes for speeds never trained on.

    f(v) = f_c tanh(beta v) + f_v v                 v: motor speed

Given by hand, or estimated from one trial without compensation and no plant parameters: u_c = f(v) + constant, by
non-negative least squares. The constant, one per motion, takes gravity, which changes little over a small motion. u_p
would be the wrong signal to estimate from: the integral takes part of the friction away from it, at low speed most.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from ffgym.agents.trials import Lesson, Trial, run_trial
from ffgym.core.errors import FFGymError, check_number, check_shape
from ffgym.core.types import Array
from ffgym.paths import Reference
from ffgym.simulation import Run

STEEPNESS = 5.0
"""beta [s/rad], thesis 4.1, where the sign of static LuGre is smoothed by it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CoulombPrior:
    """Coulomb and viscous friction with a smooth sign; a network starts as `network.with_curve(prior.torque_at)`."""

    coulomb: Array
    """f_c [N m], motor side, shape (N,)."""
    viscous: Array | float = 0.0
    """f_v [N m s/rad], motor side, shape (N,)."""

    def __post_init__(self) -> None:
        coulomb = check_shape("coulomb", self.coulomb, (None,))
        viscous = check_shape("viscous", np.broadcast_to(self.viscous, coulomb.shape), coulomb.shape)
        for name, unit, values in (("coulomb", "N m", coulomb), ("viscous", "N m s/rad", viscous)):
            for joint, value in enumerate(values):
                check_number(f"{name} of joint {joint + 1}", value, unit=unit, low=0.0)
            object.__setattr__(self, name, values)

    def torque_at(self, motor_dq: Array) -> Array:
        """Compute friction [N m] at motor speed `motor_dq` [rad/s], shape (..., N)."""
        return np.asarray(self.coulomb * np.tanh(STEEPNESS * motor_dq) + self.viscous * motor_dq)

    @classmethod
    def from_trial(cls, references: Sequence[Reference], trial: Trial, viscous: bool = False) -> "CoulombPrior":
        """Estimate friction from one trial without compensation (number 0); see `from_lessons`.

        Raises:
            FFGymError: if there is no reference, or the recordings lack the feedback torque.
        """
        recordings = run_trial(trial, [Run(reference=reference) for reference in references], 0)
        lessons = [
            Lesson.of(reference, recording, "u_c") for reference, recording in zip(references, recordings, strict=True)
        ]
        return cls.from_lessons(lessons, viscous)

    @classmethod
    def from_lessons(cls, lessons: Sequence[Lesson], viscous: bool = False) -> "CoulombPrior":
        """Estimate friction from lessons with the signal u_c, by non-negative least squares.

        Args:
            lessons: each with a constant of its own.
            viscous: also estimate viscous friction; only for motions as fast as the law will run on, since at low
                speeds it cannot be distinguished from the rest and grows without bound beyond them.

        Raises:
            FFGymError: if there is no lesson.
        """
        if not lessons:
            raise FFGymError("There is no lesson to estimate friction from; give one or more references.")
        # regressors and missing torque of each lesson, without their means
        curves, targets = [], []
        for lesson in lessons:
            speed = lesson.motor_dq[lesson.moving]
            columns = [np.tanh(STEEPNESS * speed)] + [speed] * viscous
            curves.append(_centre(np.stack(columns, axis=-1)))  # (T, N, 1 or 2)
            targets.append(_centre((lesson.signal + lesson.added)[lesson.moving]))
        # one fit per joint over all lessons
        n_joints = targets[0].shape[1]
        fits = np.zeros((n_joints, 2))
        for joint in range(n_joints):
            matrix = np.concatenate([part[:, joint] for part in curves])
            target = np.concatenate([part[:, joint] for part in targets])
            fits[joint, : matrix.shape[1]], _ = scipy.optimize.nnls(matrix, target)
        return cls(coulomb=fits[:, 0], viscous=fits[:, 1])


def _centre(rows: Array) -> Array:
    """Subtract the mean over T from `rows` (T, ...): least squares on them is least squares with a free constant."""
    return rows - rows.mean(axis=0)
