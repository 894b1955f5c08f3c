"""Fits of NARX networks by Levenberg-Marquardt from random weights, thesis 6.2.3."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, get_args

import numpy as np
import scipy

from ffgym.core.errors import check_choice, check_whole
from ffgym.core.measures import rms
from ffgym.core.types import Array
from ffgym.diagnosis.identification.narx.model import NarxModel, joint_models
from ffgym.diagnosis.identification.narx.problems import Prediction, Samples, Simulation, check_records, split
from ffgym.diagnosis.identification.narx.regressors import Regressors

Focus = Literal["prediction", "simulation"]
"""What errors are minimised: one step ahead, as in the thesis, or in free run."""


N_EVALUATIONS = 1000
"""Residual evaluations at most; thesis 6.2.3 allows as many iterations."""


@dataclass(frozen=True, kw_only=True)
class Structure:
    """Regressors and size; the default is thesis (6.20)."""

    regressors: Regressors = field(default_factory=Regressors)
    n_neurons: int = 3
    """Thesis 6.2.1."""

    def __post_init__(self) -> None:
        check_whole("n_neurons", self.n_neurons, low=1)

    @property
    def n_weights(self) -> int:
        """Parameters K of one motor: w, b, c and d of `NarxModel`."""
        return self.n_neurons * (self.regressors.count + 2) + 1


def fit_network(
    records: Sequence[Samples],
    structure: Structure,
    rng: np.random.Generator,
    *,
    focus: Focus = "prediction",
    n_evaluations: int = N_EVALUATIONS,
) -> NarxModel:
    """Network from one start per motor.

    Args:
        records: motions to fit to.
        structure: regressors and size.
        rng: draws the first weights.
        focus: "simulation" goes on from the fit of "prediction"; without past outputs they are the same.
        n_evaluations: residual evaluations at most, of each focus.

    Raises:
        FFGymError: if there is no record, records do not fit together, they have fewer scored samples than a motor has
            weights, or a number is out of range.
    """
    check_records(records, structure.n_weights, "NARX network", "neurons or regressors")
    check_choice("focus", focus, get_args(Focus))
    check_whole("n_evaluations", n_evaluations, low=1)
    model = _minimise(_random(records, rng, structure), records, Prediction, n_evaluations)
    if focus == "simulation" and structure.regressors.output_lags:
        model = _minimise(model, records, Simulation, n_evaluations)
    return model


def best_simulating(
    records: Sequence[Samples],
    structure: Structure,
    rng: np.random.Generator,
    n_starts: int,
    *,
    focus: Focus = "prediction",
    n_evaluations: int = N_EVALUATIONS,
) -> NarxModel:
    """Fit `n_starts` times, and take for each motor the network that simulates `records` best: others may drift."""
    check_whole("n_starts", n_starts, low=1)
    fits = [fit_network(records, structure, rng, focus=focus, n_evaluations=n_evaluations) for _ in range(n_starts)]
    costs = []
    for model in fits:
        errors = [((model.simulate(r.motor_dq) - r.torque)[r.scored] / r.noise) ** 2 for r in records]
        costs.append(np.concatenate(errors).mean(axis=0))
    return joint_models(fits, np.array(costs).argmin(axis=0))


def _random(records: Sequence[Samples], rng: np.random.Generator, structure: Structure) -> NarxModel:
    """Weights before a fit: slopes of about the size of the regressors, as those are of size 1."""
    n = records[0].torque.shape[1]
    speed = np.max([np.abs(record.motor_dq).max(axis=0) for record in records], axis=0)
    torque = np.max([rms(record.torque, 0) for record in records], axis=0)
    shape = (n, structure.n_neurons, structure.regressors.count)
    return NarxModel(
        input_weights=2.0 * rng.normal(size=shape),
        biases=rng.normal(size=shape[:2]),
        output_weights=rng.normal(size=shape[:2]),
        offset=np.zeros(n),
        speed_scale=np.where(speed > 0, speed, 1.0),  # a motor that stands still has no size
        torque_scale=np.where(torque > 0, torque, 1.0),
        regressors=structure.regressors,
        dt=records[0].dt,
    )


def _minimise(
    start: NarxModel,
    records: Sequence[Samples],
    problem_of: type[Prediction] | type[Simulation],
    n_evaluations: int,
) -> NarxModel:
    """The network from `start` with the least squares of a problem, motor by motor."""
    h, found = start.biases.shape[1], []
    for joint in range(start.n_joints):
        problem = problem_of(start, records, joint)
        fit = scipy.optimize.least_squares(
            problem.residual, _pack(start, joint), problem.jacobian, method="lm", max_nfev=n_evaluations
        )
        found.append(split(fit.x, h))
    w, b, c, d = (np.array(part) for part in zip(*found, strict=True))
    return replace(start, input_weights=w, biases=b, output_weights=c, offset=d)


def _pack(model: NarxModel, joint: int) -> Array:
    parts = (model.input_weights, model.biases, model.output_weights, model.offset)
    return np.concatenate([np.ravel(part[joint]) for part in parts])
