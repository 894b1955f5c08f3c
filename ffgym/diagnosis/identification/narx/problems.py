"""Records that networks are fitted to, errors on them, and what Levenberg-Marquardt minimises for one motor.

Parameters of a motor are one vector, K = H R + 2 H + 1: w row by row, then b, c and d of `NarxModel`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import tanh
from operator import mul
from typing import Protocol

import numpy as np
import scipy

from ffgym.core.errors import FFGymError, check_number, check_shape
from ffgym.core.measures import rms
from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.identification.narx.model import NarxModel, sigmoid


@dataclass(frozen=True, kw_only=True, eq=False)
class Samples:
    """Motor speed and the friction torque that belongs to it, at T even samples of one motion, motor side."""

    dt: float
    """Time between samples [s]."""
    motor_dq: Array
    """Motor speed [rad/s], shape (T, N)."""
    torque: Array
    """Friction torque [N m], shape (T, N)."""
    scored: BoolArray
    """Samples that a fit and its errors count, shape (T,); the others are still simulated and remembered."""
    noise: Array
    """Size of the torque's errors [N m], shape (N,), > 0; a motion with half of it counts four times as much."""

    def __post_init__(self) -> None:
        check_number("dt", self.dt, unit="s", low=0.0, open_low=True)
        shape = check_shape("motor_dq", self.motor_dq, (None, None)).shape
        for name, wanted in {"motor_dq": shape, "torque": shape, "noise": shape[1:]}.items():
            object.__setattr__(self, name, check_shape(name, getattr(self, name), wanted))
        if np.any(self.noise <= 0):
            raise FFGymError(f"noise = {self.noise} of samples for a NARX network must be > 0.")
        marks = np.asarray(self.scored)
        if marks.dtype != np.bool_ or marks.shape != shape[:1]:  # numbers would mean rows as an index
            raise FFGymError(
                f"scored has type {marks.dtype} and shape {marks.shape}, must be bool, one for each of {shape[0]} "
                "samples."
            )
        if not marks.any():
            raise FFGymError(f"scored marks none of the {shape[0]} samples; a fit needs some.")
        object.__setattr__(self, "scored", marks)


def check_records(records: Sequence[Samples], n_weights: int, model: str, fewer: str) -> None:
    """Check that records fit together, and that they can determine the weights of each motor.

    Args:
        records: motions to fit to.
        n_weights: weights of a motor.
        model: name of the model, for the message.
        fewer: parts of the model that a fit to little data has to do without.

    Raises:
        FFGymError: if one of that is not so.
    """
    if not records:
        raise FFGymError(f"There is no motion to fit a {model} to.")
    for name, values in {
        "sample times [s]": {each.dt for each in records},
        "numbers of motors": {each.motor_dq.shape[1] for each in records},
    }.items():
        if len(values) > 1:
            raise FFGymError(f"Motions for one {model} have different {name}: {sorted(values)}. Use one of them.")
    n = sum(int(record.scored.sum()) for record in records)
    if n < n_weights:
        raise FFGymError(
            f"{n} scored samples are too few for a {model} of {n_weights} weights per motor. Score more samples, or "
            f"take fewer {fewer}."
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class Misfit:
    """Distance of a torque from the true one, motor side, shape (N,) each."""

    rms: Array
    """RMS of the difference [N m]."""
    share: Array
    """The same over the RMS of the torque; NaN for a motor that has none."""
    fit: Array
    """100 (1 - |y - estimate| / |y - mean y|) [%], the fit of the System Identification Toolbox: 0 is the mean's. NaN
    for a motor whose torque does not change."""

    @classmethod
    def of(cls, estimate: Array, torque: Array) -> "Misfit":
        """Compare two torques [N m], (T, N) each."""
        error = rms(estimate - torque, 0)
        return cls(rms=error, share=_over(error, rms(torque, 0)), fit=100 * (1 - _over(error, torque.std(axis=0))))


class FrictionModel(Protocol):
    """A model of friction in samples: a network, or a linear one."""

    @property
    def dt(self) -> float:
        """Time between samples [s]."""

    def is_sampled_at(self, dt: float) -> bool:
        """Tell whether samples every `dt` [s] are those that the lags count."""

    def predict(self, motor_dq: Array, torque: Array) -> Array:
        """Torque [N m] one step ahead along motor speeds [rad/s], all (T, N): past outputs are measured `torque`."""

    def simulate(self, motor_dq: Array) -> Array:
        """Torque [N m] along motor speeds [rad/s], both (T, N), from past outputs of its own."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Errors:
    """Errors of a model along one motion, in its scored samples."""

    prediction: Misfit
    """One step ahead, with measured past torques."""
    simulation: Misfit
    """In free run, with its own past torques."""

    @classmethod
    def of(cls, model: FrictionModel, samples: Samples) -> "Errors":
        """Errors of `model`, motor by motor, on samples of its motors and at its sample time."""
        if not model.is_sampled_at(samples.dt):
            raise FFGymError(
                f"The friction model was fitted to samples every {model.dt:g} s, these are {samples.dt:g} s apart; its "
                f"lags are counted in samples. Give it samples every {model.dt:g} s."
            )
        rows, torque = samples.scored, samples.torque
        return cls(
            prediction=Misfit.of(model.predict(samples.motor_dq, torque)[rows], torque[rows]),
            simulation=Misfit.of(model.simulate(samples.motor_dq)[rows], torque[rows]),
        )


def _over(error: Array, size: Array) -> Array:
    return np.divide(error, size, out=np.full_like(error, np.nan), where=size > 0)


STEEPEST = 1e100
"""Largest slope that is passed on: those of a network that amplifies its own errors overflow in a long motion. Chosen
far beyond any that leads somewhere, and small enough to be squared."""


class Prediction:
    """Errors of one motor one step ahead, S scored samples of all records; past outputs are the measured ones."""

    def __init__(self, start: NarxModel, records: Sequence[Samples], joint: int) -> None:
        scale = start.torque_scale
        self._n_neurons = start.biases.shape[1]
        self._phi = np.concatenate([start.phi(r.motor_dq, r.torque)[r.scored] for r in records])[:, joint]
        self._target = np.concatenate([r.torque[r.scored] / scale for r in records])[:, joint]
        self._weight = np.concatenate([np.tile(scale / r.noise, (r.scored.sum(), 1)) for r in records])[:, joint]

    def residual(self, parameters: Array) -> Array:
        """Errors (S,) at parameters (K,) of the motor, in units of the noise."""
        w, b, c, d = split(parameters, self._n_neurons)
        return np.asarray(self._weight * (sigmoid(self._phi @ w.T + b) @ c + d - self._target))

    def jacobian(self, parameters: Array) -> Array:
        """Their derivative by the parameters (S, K)."""
        return self._weight[:, None] * slopes(parameters, self._phi, self._n_neurons)


class Simulation:
    r"""Errors of one motor in free run, S scored samples of all records; past outputs are the network's own.

    The derivative of y(k) then holds those of its past outputs,

    .. math:: s(k) = \partial g / \partial \theta + \sum_j \partial g / \partial y(k - j) \; s(k - j)

    which is a banded triangular system of equations in all s(k).
    """

    def __init__(self, start: NarxModel, records: Sequence[Samples], joint: int) -> None:
        self._n_neurons, self._lags = start.biases.shape[1], np.array(start.regressors.output_lags, dtype=np.intp)
        # of each record the regressors that follow from the speed, the torque in units of its scale, what counts, and
        # that scale over the noise
        self._drives = [
            (
                start.inputs(r.motor_dq)[:, joint],
                r.torque[:, joint] / start.torque_scale[joint],
                r.scored,
                float(start.torque_scale[joint] / r.noise[joint]),
            )
            for r in records
        ]

    def residual(self, parameters: Array) -> Array:
        """Errors (S,) at parameters (K,) of the motor, in units of the noise."""
        return np.concatenate(
            [
                weight * (self._simulate(parameters, inputs) - target)[scored]
                for inputs, target, scored, weight in self._drives
            ]
        )

    def jacobian(self, parameters: Array) -> Array:
        """Their derivative by the parameters (S, K)."""
        parts = []
        for inputs, _, scored, weight in self._drives:
            outputs = self._simulate(parameters, inputs)
            past = [np.concatenate([np.zeros(lag), outputs])[: len(outputs)] for lag in self._lags]
            phi = np.hstack([inputs, np.stack(past, axis=1)])
            parts.append(weight * self._through_time(parameters, phi)[scored])
        return np.concatenate(parts)

    def _simulate(self, parameters: Array, inputs: Array) -> Array:
        """Output (T,) in units of its scale; none at first, as in `NarxModel.simulated`."""
        w, b, c, d = split(parameters, self._n_neurons)
        n_inputs, lags = inputs.shape[1], self._lags.tolist()
        driven, fed_back, gains = (inputs @ w[:, :n_inputs].T + b).tolist(), w[:, n_inputs:].tolist(), c.tolist()
        outputs = [0.0] * (max(lags) + 1)
        for row in driven[1:]:  # plain floats: a call of NumPy costs more than a neuron
            past, total = [outputs[-lag] for lag in lags], float(d)
            for gain, inside, weights in zip(gains, row, fed_back, strict=True):
                total += gain * (0.5 + 0.5 * tanh(0.5 * (inside + sum(map(mul, weights, past)))))
            outputs.append(total)
        return np.array(outputs[max(lags) :])

    def _through_time(self, parameters: Array, phi: Array) -> Array:
        """Derivative s (T, K) of the output in free run, along which regressors are phi (T, R)."""
        w, b, c, _ = split(parameters, self._n_neurons)
        active = sigmoid(phi @ w.T + b)
        gains = (active * (1 - active) * c) @ w[:, -len(self._lags) :]
        bands = np.zeros((self._lags.max() + 1, len(phi)))
        bands[0] = 1.0
        for lag, gain in zip(self._lags, gains.T, strict=True):
            bands[lag, : len(phi) - lag] = -gain[lag:]
        direct = slopes(parameters, phi, self._n_neurons)
        direct[0] = 0.0  # the first output is none, whatever the weights
        found, _ = scipy.linalg.lapack.dtbtrs(
            bands, direct, uplo="L", diag="U"
        )  # without pivots, so that it may overflow but not fail
        return np.nan_to_num(np.clip(found, -STEEPEST, STEEPEST))


def split(parameters: Array, n_neurons: int) -> tuple[Array, Array, Array, Array]:
    """Parameters (K,) of one motor as w (H, R), b (H,), c (H,), d."""
    h = n_neurons
    return (
        parameters[: -2 * h - 1].reshape(h, -1),
        parameters[-2 * h - 1 : -h - 1],
        parameters[-h - 1 : -1],
        parameters[-1],
    )


def slopes(parameters: Array, phi: Array, n_neurons: int) -> Array:
    """Derivative of the output by the parameters at regressors (T, R), shape (T, K)."""
    w, b, c, _ = split(parameters, n_neurons)
    active = sigmoid(phi @ w.T + b)
    slope = active * (1 - active) * c
    by_w = (slope[:, :, None] * phi[:, None, :]).reshape(len(phi), -1)
    return np.hstack([by_w, slope, active, np.ones((len(phi), 1))])
