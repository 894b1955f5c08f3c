r"""How fast B-spline networks may learn, from the robot's description alone: stability of thesis (5.5).

Along a given motion, what the feedback has to give is nearly linear in the weights of a joint, and so is one iteration:

.. math::
    u_p(w) = u_p(0) - G B w, \qquad w_+ = w + \gamma N B^T u_p(w) = (I - \gamma L) w + const, \qquad L = N B^T G B

B holds the splines along the motion, N is diagonal with one over the sum of each spline, and G is what added torque
takes off the feedback (`ffgym.agents.stability.feedback_loop`). A pattern of weights that is an eigenvector of L
changes by the factor 1 - gamma lambda in each iteration. Learning is stable while no factor is larger than 1. Thesis
7.2 leaves this open.

Run it:

    ffgym stability --network extended --gamma 0.95

Reported per motion and joint: `largest_rate`, the largest gamma with |1 - gamma lambda| <= 1.001 for all lambda;
`growth`, max |1 - gamma lambda| at the given rate; and the RMS of the learning signal predicted to be left.

Departures from the source: none. Limits: each joint by itself, small deviations from the reference; how far this
carries, `docs/agents/learning_stability.md` shows against simulation.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from ffgym.agents.bspline import BSplineNetwork
from ffgym.agents.common.trials import Signal
from ffgym.agents.stability.iteration_map import LearningMap, learning_maps
from ffgym.core.errors import check_number
from ffgym.core.types import Array
from ffgym.paths import Reference
from ffgym.robot import RigidArm
from ffgym.simulation import RECORD_DT


@dataclass(frozen=True, kw_only=True, eq=False)
class LearningStability:
    """What learning along some motions will do at any rate, joint by joint."""

    joints: tuple[str, ...]
    maps: tuple[LearningMap, ...]
    """One per joint."""
    cure: str = ""
    """What may stop a pattern that grows at every rate; empty if nothing is known."""

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
        """Predict how `network` will learn.

        Args:
            network: with the weights that learning starts from.
            arm: nominal model of the robot.
            references: the motions of one trial.
            signal: what is learned from.
            record_dt: time between the rows that are learned from [s]; it divides the control step.

        Raises:
            FFGymError: if nothing moves, joints do not fit, or `record_dt` does not divide the control step.
        """
        maps = learning_maps(network, arm, references, signal, record_dt)
        cure = _cure(signal, has_rows_between=record_dt < 0.99 * arm.robot.servo.control_dt)
        return cls(joints=arm.robot.joints, maps=maps, cure=cure)

    @property
    def largest_rate(self) -> Array:
        """Largest stable learning rate of each joint, shape (N,)."""
        return np.array([each.largest_rate for each in self.maps])

    def growth(self, rate: float) -> Array:
        """Factor by which the fastest growing pattern of each joint changes in an iteration, shape (N,)."""
        check_number("learning rate", rate, low=0.0)
        return np.array([each.growth(rate) for each in self.maps])

    def mean_squares(self, rate: float, iterations: int) -> Array:
        """Predicted mean square of the learning signal [(N m)^2], at first and after each iteration, (I + 1, N)."""
        return np.stack([each.mean_squares(rate, iterations) for each in self.maps], axis=1)

    def warning(self, rate: float) -> str | None:
        """One sentence if `rate` is above the largest stable one of a joint, else None."""
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


def _cure(signal: Signal, *, has_rows_between: bool) -> str:
    if signal == "e_p":  # the angle lags behind the torque, whatever the rows
        return ", learning from u_p may stop it"
    return ", learning from the samples of the reference alone may stop it" if has_rows_between else ""
