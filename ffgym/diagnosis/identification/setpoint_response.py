r"""Delay and filter of a controller, from set-points that were sent and motor angles that were measured.

The documented robot under its servo is simulated along the filtered set-points F s, and delay d and coefficients a_1,
a_2 of the filter (`SetpointResponse`) are fitted so that it moves as the motors did:

.. math:: \min \sum_j \| \theta_j - \theta_j^{model}(F s; \nu_j) \|^2 / \sigma_j^2 + \| \nu \|^2 / \sigma_\nu^2

Friction and inertia of each joint are nuisance parameters nu with priors, as a model that is wrong in them follows its
set-points earlier or later than the robot does. A delay alone is tried first; a coefficient is added if residuals fall
by it, as a filter of second order with a_2 = a_1^2 / 2 is a delay to most motions. Intervals are from sums of scores
over blocks of time, as residuals are not independent.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import scipy

from ffgym.control import SetpointResponse
from ffgym.core.errors import FFGymError, check_class
from ffgym.core.measures import rms
from ffgym.core.types import Array
from ffgym.diagnosis.identification.setpoint_model import MOVES, NUISANCES, ResponseModel, SetpointLog
from ffgym.recordings import Recording
from ffgym.robot import RigidArm
from ffgym.simulation.run import Progress

NAMES = ("delay", "lag", "curvature")
"""Parameters of a response; a simpler one has the first of them."""
_TINY = 1e-4
"""Step by which parameters are differentiated by coordinates."""
_SOME_LAG = 1 / 3
"""Share of the delay that the fit of a filter of second order begins with as lag, with the curvature of a delay."""
PRIOR = 0.3
"""Standard deviation of the priors of nuisance parameters; chosen: numbers of friction are a third off from robot to
robot."""
_UPPER = np.array([200.0, 100.0, 5000.0])
"""Largest coordinates of a response, see `make_response`; slower controllers follow no path."""
_STEPS = (0.2, 0.2, 5.0, 0.05, 0.05, 0.05)
"""Steps of numerical derivatives: of these coordinates, then of the nuisance parameters."""
_STRAIN = 9.0
"""Sum of squares of nuisance parameters, in standard deviations, by which it must fall otherwise; three of one."""
_FITS = 5
"""Most fits until a response is selected."""
_BETTER = 0.1
"""Share of the sum of squares by which it must fall for another coefficient; chosen: models of drives are that wrong
between set-points, where some join them by straight lines."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ResponseFit:
    """Response of a controller as recordings show it."""

    response: SetpointResponse
    intervals: dict[str, tuple[float, float]]
    """95 % intervals of the parameters that it has, and of `total_delay` if it has a filter, in SI units.

    They know noise alone. A drive that makes speeds of set-points otherwise than the model moves `total_delay` by some
    0.1 ms, delay and lag against each other by more.
    """
    covariance: Array
    """Covariance of these parameters, SI units, shape (K, K)."""
    factors: dict[str, Array]
    """Factors of friction and inertia that were fitted beside it, by `NUISANCES`, shape (N,)."""
    residual: Array
    """RMS of measured motor angles less those of the model, motor side [rad], shape (N,); NaN for joints at rest."""
    undelayed: Array
    """The same for set-points that arrive at once, motor side [rad], shape (N,)."""

    @property
    def explained(self) -> float:
        """Explained share of the variance that set-points which arrive at once leave."""
        return float(1 - np.nansum(self.residual**2) / np.nansum(self.undelayed**2))


def identify_response(
    recordings: Sequence[Recording], arm: RigidArm, *, n_threads: int = 0, progress: Progress | None = None
) -> ResponseFit:
    """Identify delay and filter of the controller that made recordings.

    Args:
        recordings: set-points as they were sent (`reference.position`) and motor angles (`motor.position`); motions of
            a second and more with changes of speed up to some Hz.
        arm: the robot as it is documented.
        n_threads: threads of the engine, 0 for all cores.
        progress: function called with the fits that are done and their largest number.

    Raises:
        FFGymError: if there are no recordings, nothing moves, a joint moves beyond its limits, or the model cannot
            follow.
    """
    if not recordings:
        raise FFGymError("There are no recordings; record set-points and motor angles of a motion of some seconds.")
    check_class("arm", arm, RigidArm, "RigidArm(robot) makes one of a description")
    model = ResponseModel(
        arm=arm, logs=tuple(SetpointLog.of(each, arm.robot) for each in recordings), n_threads=n_threads
    )
    if not model.moves.any():
        raise FFGymError(
            f"No set-point moves by more than {MOVES} rad, motor side: the delay cannot be found. Record a motion."
        )
    fit = _select(model, progress or (lambda done, total: None))
    n = arm.robot.n_joints
    return ResponseFit(
        response=make_response(fit.values, fit.count),
        intervals=fit.intervals(),
        covariance=fit.response_covariance,
        factors=dict(zip(NUISANCES, np.exp(fit.values[fit.count :]).reshape(3, n), strict=True)),
        residual=np.where(model.moves, fit.spread, np.nan),
        undelayed=np.where(model.moves, rms(model.late, 0), np.nan),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Fit:
    """Parameters that fit, and how well they are known."""

    count: int
    """Number of parameters of the response."""
    values: Array
    """Coordinates of the response, then logarithms of factors."""
    covariance: Array
    spread: Array
    """RMS of the residuals, motor side [rad], shape (N,); 0 for joints at rest."""
    step: float
    """Smallest noise of a motor angle [rad]."""

    @property
    def sigma(self) -> Array:
        """Unit of residuals of the next fit [rad], shape (N,)."""
        return np.hypot(self.spread, self.step)

    def is_as_good(self, other: "_Fit") -> bool:
        """Tell if residuals and nuisance parameters are as small as in a fit with more parameters.

        What resolvers do not show counts as noise.
        """
        larger = ((self.sigma / other.sigma) ** 2).mean()
        strain = [((each.values[each.count :] / PRIOR) ** 2).sum() for each in (self, other)]
        return bool(larger < 1 / (1 - _BETTER) and strain[0] < strain[1] + _STRAIN)

    @cached_property
    def response_covariance(self) -> Array:
        """Covariance of the parameters of the response, in SI units, shape (K, K)."""
        return to_parameters(self.values[: self.count], self.covariance[: self.count, : self.count])

    def intervals(self) -> dict[str, tuple[float, float]]:
        """Compute the 95 % intervals of the parameters of the response and of its total delay, in SI units."""
        found = {}
        if self.count > 1:
            found["total_delay"] = _interval(1e-3 * self.values[0], 1e-3 * np.sqrt(self.covariance[0, 0]))
        sigma, own = np.sqrt(np.diag(self.response_covariance)), _parameters(self.values[: self.count])
        return found | {name: _interval(value, s) for name, value, s in zip(NAMES, own, sigma, strict=False)}


def _interval(middle: float, sigma: float) -> tuple[float, float]:
    """Return the ends of a 95 % interval."""
    return float(middle - 1.96 * sigma), float(middle + 1.96 * sigma)


def make_response(values: Array, count: int) -> SetpointResponse:
    r"""Make a response of its coordinates: d + a_1 [ms], a_1 [ms], a_1^2 / 2 - a_2 [ms^2].

    They are the slopes of phase and magnitude at low frequencies, log F = -s (d + a_1) + s^2 (a_1^2 / 2 - a_2) + ...,
    which motions show best; in d, a_1 and a_2 themselves the best values lie along a curve.
    """
    return SetpointResponse(**dict(zip(NAMES, _parameters(values[:count]).tolist(), strict=False)))


def _parameters(values: Array) -> Array:
    """Compute delay [s], lag [s] and curvature [s^2], as many as there are coordinates, shape (K,)."""
    total, lag, roll = np.pad(values, (0, 3 - len(values)))
    found = np.array([1e-3 * (total - lag), 1e-3 * lag, 1e-6 * (lag**2 / 2 - roll)])
    return np.maximum(found, 0.0)[: len(values)]


def to_parameters(values: Array, covariance: Array) -> Array:
    """Bring the covariance of coordinates to that of delay [s], lag [s] and curvature [s^2], shape (K, K)."""
    steps = _TINY * np.eye(len(values))
    slopes = np.stack([_parameters(values + h) - _parameters(values - h) for h in steps], axis=1) / (2 * _TINY)
    return np.asarray(slopes @ covariance @ slopes.T)


def _select(model: ResponseModel, progress: Progress) -> _Fit:
    """Fit a delay, then a filter of second order, then one of first order if the second is better than none."""
    n = model.arm.robot.n_joints
    progress(0, _FITS)
    sigma, late = model.guess()
    delay = _fit(model, np.r_[late, np.zeros(3 * n)], 1, sigma)
    progress(1, _FITS)
    delay = _fit(model, delay.values, 1, delay.sigma)
    progress(2, _FITS)
    start = np.r_[delay.values[0], _SOME_LAG * delay.values[0], 0.0, np.zeros(3 * n)]
    second = _fit(model, start, 3, delay.sigma)
    progress(3, _FITS)
    if delay.is_as_good(second):
        return delay
    second = _fit(model, second.values, 3, second.sigma)
    progress(4, _FITS)
    first = _fit(model, np.delete(second.values, 2), 2, second.sigma)
    return first if first.is_as_good(second) else second


def _fit(model: ResponseModel, start: Array, count: int, sigma: Array) -> _Fit:
    """Fit `count` parameters of the response and all nuisance parameters, with residuals in units of `sigma` (N,)."""
    n_factors = len(start) - count
    lower = np.r_[[0.0, 0.1, -_UPPER[2]][:count], np.full(n_factors, -2.0)]
    upper = np.r_[_UPPER[:count], np.full(n_factors, 2.0)]
    problem = _Problem(model=model, count=count, weight=np.where(model.moves, 1 / sigma, 0.0))
    solved = scipy.optimize.least_squares(
        problem.residuals,
        np.clip(start, lower + 1e-6, upper - 1e-6),
        problem.jacobian,
        bounds=(lower, upper),
        x_scale="jac",
        ftol=1e-4,
        xtol=1e-4,
        max_nfev=15,
    )
    jacobian = np.asarray(solved.jac, dtype=np.float64)
    return _Fit(
        count=count,
        values=solved.x,
        covariance=problem.covariance(solved.fun, jacobian),
        spread=problem.spread(solved.fun),
        step=model.step,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Problem:
    """Weighted residuals of a fit and their derivatives: of all angles, then of the priors."""

    model: ResponseModel
    count: int
    weight: Array
    """One over the noise of each joint [1/rad], 0 for joints at rest, shape (N,)."""
    known: dict[bytes, Array] = field(default_factory=dict)
    """Angles of residuals by the parameters that they were last computed for; derivatives are asked for there next."""

    def residuals(self, values: Array) -> Array:
        """Compute the residuals."""
        (residual,) = self.model.residuals([self._split(values)])
        self.known.clear()
        self.known[values.tobytes()] = residual
        return np.r_[(residual * self.weight).ravel(), values[self.count :] / PRIOR]

    def jacobian(self, values: Array) -> Array:
        """Differentiate the residuals: each parameter of the response, and each nuisance of all joints at once.

        What a joint's friction and inertia do to other joints is left out: it reaches them through springs alone.
        """
        n, k = len(self.weight), self.count
        steps = np.r_[_STEPS[:k], _STEPS[3:]]
        first, moved = self.known.get(values.tobytes()), []
        for i, step in enumerate(steps):
            change = np.zeros_like(values)
            change[i if i < k else slice(k + (i - k) * n, k + (i - k + 1) * n)] = step
            moved.append(values + change)
        if first is None:
            moved.append(values)
        others = self.model.residuals([self._split(each) for each in moved])
        if first is None:
            first = others.pop()
        slopes = [self.weight * (other - first) / step for other, step in zip(others, steps, strict=True)]
        columns = [slope.ravel() for slope in slopes[:k]]
        columns += [(slope * (np.arange(n) == j)).ravel() for slope in slopes[k:] for j in range(n)]
        priors = np.hstack([np.zeros((3 * n, k)), np.eye(3 * n) / PRIOR])
        return np.vstack([np.stack(columns, axis=1), priors])

    def spread(self, residuals: Array) -> Array:
        """Compute the RMS of each joint's residual [rad] from weighted ones, shape (N,)."""
        n = len(self.weight)
        measured = residuals[: -3 * n].reshape(-1, n)
        return np.divide(rms(measured, 0), self.weight, out=np.zeros(n), where=self.weight > 0)

    def covariance(self, residuals: Array, jacobian: Array) -> Array:
        """Compute the covariance of the parameters from scores that are summed over blocks of time."""
        n = len(self.weight)
        rows = np.repeat(self.model.blocks, n)
        scores = jacobian[: len(rows)] * residuals[: len(rows), None]
        sums = np.stack([np.bincount(rows.astype(np.int64), column) for column in scores.T], axis=1)
        inverse = np.linalg.pinv(jacobian.T @ jacobian)
        used = len(sums) / max(1, len(sums) - self.count)
        return np.asarray(used * inverse @ (sums.T @ sums + np.diag(self._prior_scores())) @ inverse)

    def _prior_scores(self) -> Array:
        """Compute the variance of scores of the priors: one over that of each nuisance parameter."""
        return np.r_[np.zeros(self.count), np.full(3 * len(self.weight), PRIOR**-2)]

    def _split(self, values: Array) -> tuple[SetpointResponse, Array]:
        return make_response(values, self.count), values[self.count :]
