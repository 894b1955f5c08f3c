"""Linear models of friction, ARX and output error, on the regressors of the networks; thesis (3.5)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final, get_args

import numpy as np
import scipy

from ffgym.core.errors import check_choice, check_number, check_shape
from ffgym.core.types import Array
from ffgym.diagnosis.identification.narx.fit import N_EVALUATIONS, Focus
from ffgym.diagnosis.identification.narx.problems import STEEPEST, Samples, check_records
from ffgym.diagnosis.identification.narx.regressors import Regressors


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class LinearModel:
    r"""Friction as a linear difference equation of each motor.

    .. math:: y(k) = d + \sum_i b_i v(k - i) + \sum_w c_w s_w(k) + \sum_j a_j y(k - j)

    Fitted to the error one step ahead it is an ARX model, in free run an output-error (OE) model.

    Reference:
        Thesis (3.5); L. Ljung, System Identification (1999), 4.2.
    """

    input_weights: Array
    """b [N m s/rad] of each speed lag, then c [N m/rad] of each slip element, shape (N, n_inputs)."""
    output_weights: Array
    """a of each output lag, shape (N, J)."""
    offset: Array
    """d [N m], shape (N,)."""
    regressors: Regressors
    dt: float
    """Time between samples [s]; lags are counted in it."""

    def __post_init__(self) -> None:
        (n,) = check_shape("offset", self.offset, (None,)).shape
        shapes = {
            "offset": (n,),
            "input_weights": (n, self.regressors.n_inputs),
            "output_weights": (n, len(self.regressors.output_lags)),
        }
        for name, shape in shapes.items():
            object.__setattr__(self, name, check_shape(name, getattr(self, name), shape))
        check_number("dt", self.dt, unit="s", low=0.0, open_low=True)

    @property
    def n_joints(self) -> int:
        """Number of motors N."""
        return len(self.offset)

    @property
    def largest_pole(self) -> Array:
        """Largest modulus of the poles, shape (N,); free run of a motor with 1 or more may run away."""
        return np.array([np.abs(np.roots(each)).max(initial=0.0) for each in self._denominators])

    def is_sampled_at(self, dt: float) -> bool:
        """Tell whether samples every `dt` [s] are those that the lags count."""
        return abs(dt - self.dt) <= 1e-9

    def simulate(self, motor_dq: Array) -> Array:
        """Torque [N m] along motor speeds [rad/s], both (T, N): past outputs are the model's own; none at first.

        Torque that runs away is cut at 1e100.
        """
        driven = self._driven(motor_dq)
        driven[0] = 0.0
        return np.stack([_filter(a, u) for a, u in zip(self._denominators, driven.T, strict=True)], axis=1)

    def predict(self, motor_dq: Array, torque: Array) -> Array:
        """Torque [N m] one step ahead along motor speeds [rad/s], all (T, N): past outputs are measured `torque`."""
        past = self.regressors.past_outputs(check_shape("torque", torque, np.shape(motor_dq)))
        weighted = (a * each[..., 0] for a, each in zip(self.output_weights.T, past, strict=True))
        return np.asarray(self._driven(motor_dq) + sum(weighted, np.zeros(1)))

    def _driven(self, motor_dq: Array) -> Array:
        inputs = self.regressors.inputs(motor_dq, self.dt, np.ones(self.n_joints))
        return np.asarray(self.offset + (inputs * self.input_weights).sum(axis=-1))

    @property
    def _denominators(self) -> list[Array]:
        return [_denominator(a, self.regressors.output_lags) for a in self.output_weights]


def fit_linear(records: Sequence[Samples], regressors: Regressors, *, focus: Focus = "prediction") -> LinearModel:
    """Fit a linear model to motions, motor by motor.

    Args:
        records: motions to fit to.
        regressors: entries of the regression vector; a constant is added.
        focus: "prediction" is ARX, by least squares; "simulation" is OE, which goes on from there by
            Levenberg-Marquardt among stable models. Without past outputs they are the same.

    Raises:
        FFGymError: if there is no record, records do not fit together, or they have fewer scored samples than a motor
            has weights.
    """
    check_records(records, regressors.count + 1, "linear model", "regressors")
    check_choice("focus", focus, get_args(Focus))
    dt, n = records[0].dt, records[0].torque.shape[1]
    found = []
    for joint in range(n):
        problem = _Motor(records, regressors, joint)
        weights = problem.fit_prediction()
        found.append(problem.fit_simulation(weights) if focus == "simulation" and regressors.output_lags else weights)
    first, last = regressors.n_inputs, regressors.n_inputs + 1
    weights = np.array(found)
    return LinearModel(
        input_weights=weights[:, :first],
        offset=weights[:, first],
        output_weights=weights[:, last:],
        regressors=regressors,
        dt=dt,
    )


class _Motor:
    """Fits of one motor, with weights (K,): those of inputs, the offset, those of past outputs."""

    def __init__(self, records: Sequence[Samples], regressors: Regressors, joint: int) -> None:
        self._lags, self._n_inputs = regressors.output_lags, regressors.n_inputs
        ones = np.ones(records[0].torque.shape[1])
        # of each record: inputs with a constant (T, n_inputs + 1), torque (T,), scored rows, noise
        self._records = []
        for r in records:
            inputs = regressors.inputs(r.motor_dq, r.dt, ones)[:, joint]
            inputs = np.hstack([inputs, np.ones((len(inputs), 1))])
            self._records.append((inputs, r.torque[:, joint], r.scored, float(r.noise[joint])))

    def fit_prediction(self) -> Array:
        """Weights with the least squares of the error one step ahead."""
        rows, targets = [], []
        for inputs, torque, scored, noise in self._records:
            rows.append(self._phi(inputs, torque)[scored] / noise)
            targets.append(torque[scored] / noise)
        matrix = np.concatenate(rows)
        # columns of one size, so that those that depend on one another are found by a relative limit
        size = np.linalg.norm(matrix, axis=0)
        size[size == 0] = 1.0
        found, *_ = np.linalg.lstsq(matrix / size, np.concatenate(targets), rcond=None)
        return np.asarray(found / size)

    def fit_simulation(self, start: Array) -> Array:
        """Weights of a stable model with the least squares of the error in free run, from those of an ARX model."""
        start = self._stabilise(start)
        fit = scipy.optimize.least_squares(
            self._residual, start, self._jacobian, method="lm", x_scale="jac", max_nfev=N_EVALUATIONS
        )
        return np.asarray(fit.x)

    def _residual(self, weights: Array) -> Array:
        """Errors in free run in units of the noise; those of an unstable model are too large to be accepted."""
        a = self._denominator(weights)
        wall = 0.0 if _is_stable(a) else _WALL
        return np.concatenate(
            [(self._simulate(a, weights, u) - y)[scored] / noise + wall for u, y, scored, noise in self._records]
        )

    def _jacobian(self, weights: Array) -> Array:
        """Their derivative: each regressor through the filter of the past outputs."""
        a, parts = self._denominator(weights), []
        for inputs, _, scored, noise in self._records:
            phi = self._phi(inputs, self._simulate(a, weights, inputs))
            phi[0] = 0.0  # the first output is none, whatever the weights
            parts.append(_filter(a, phi)[scored] / noise)
        return np.concatenate(parts)

    def _simulate(self, a: Array, weights: Array, inputs: Array) -> Array:
        driven = inputs @ weights[: self._n_inputs + 1]
        driven[0] = 0.0
        return _filter(a, driven)

    def _phi(self, inputs: Array, outputs: Array) -> Array:
        past = [np.concatenate([np.zeros(lag), outputs])[: len(outputs), None] for lag in self._lags]
        return np.hstack([inputs, *past])

    def _denominator(self, weights: Array) -> Array:
        return _denominator(weights[self._n_inputs + 1 :], self._lags)

    def _stabilise(self, weights: Array) -> Array:
        """Shrink poles that are not stable into the circle, all by one factor, which keeps the lags."""
        largest = np.abs(np.roots(self._denominator(weights))).max(initial=0.0)
        if largest < 1.0:
            return weights
        shrunk = weights.copy()
        shrunk[self._n_inputs + 1 :] *= (_RADIUS / largest) ** np.array(self._lags)
        return shrunk


_RADIUS = 0.999
"""Modulus of the largest pole that a fit of an unstable ARX model goes on with; chosen: as near to it as a pole that
forgets within a second at 1 kHz."""
_WALL = 1e6
"""Error of an unstable model in units of the noise [-]; chosen far beyond that of any stable one."""


def _denominator(weights: Array, lags: Sequence[int]) -> Array:
    """Compute the polynomial A of A(q) y = u, from q^0 on."""
    a = np.zeros(max(lags, default=0) + 1)
    a[0] = 1.0
    a[list(lags)] = -weights
    return a


def _is_stable(a: Array) -> bool:
    return bool(np.abs(np.roots(a)).max(initial=0.0) < 1.0)


def _filter(a: Array, series: Array) -> Array:
    """Series (T, ...) through 1 / A, cut where it runs away."""
    found = scipy.signal.lfilter([1.0], a, series, axis=0)
    return np.nan_to_num(np.clip(found, -STEEPEST, STEEPEST), nan=STEEPEST)
