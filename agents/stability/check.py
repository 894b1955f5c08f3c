"""Prediction beside simulation: what learning at several rates does to the learning signal, iteration by iteration."""

from collections.abc import Sequence

import numpy as np

from ffgym.agents.bspline import BSplineNetwork
from ffgym.agents.common.trials import Signal, SimulatedTrial
from ffgym.agents.learning.lffc import LFFC
from ffgym.agents.stability.limits import LearningStability
from ffgym.paths import Reference
from ffgym.report.learning.learning_plot import LearningCurves


def learning_curves(
    network: BSplineNetwork,
    trial: SimulatedTrial,
    reference: Reference,
    rates: Sequence[float],
    iterations: int,
    *,
    signal: Signal = "u_p",
) -> list[LearningCurves]:
    """Predicted and simulated mean square of the learning signal, joint by joint, for `learning_figure`.

    Args:
        network: with the weights that learning starts from.
        trial: simulates motions; its nominal model predicts.
        reference: the motion.
        rates: learning rates; learning at each of them is left alone, whether it grows or falls.
        iterations: updates after the first trial.
        signal: what is learned from.
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
