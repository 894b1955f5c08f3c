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
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy

from ffgym.control import SetpointResponse
from ffgym.core.errors import FFGymError
from ffgym.core.measures import rms
from ffgym.core.types import Array, BoolArray
from ffgym.paths import Reference
from ffgym.recordings import Recording
from ffgym.robot import RigidArm, RobotDescription
from ffgym.simulation import Run, simulate
from ffgym.simulation.run import Progress

NAMES = ("delay", "lag", "curvature")
"""Parameters of a response; a simpler one has the first of them."""
_TINY = 1e-4
"""Step by which parameters are differentiated by coordinates."""
_SOME_LAG = 1 / 3
"""Share of the delay that the fit of a filter of second order begins with as lag, with the curvature of a delay."""
NUISANCES = ("Coulomb friction", "viscous friction", "rotor inertia")
"""Nuisance parameters of each joint, as logarithms of factors."""
PRIOR = 0.3
"""Standard deviation of their priors; chosen: numbers of friction are a third off from robot to robot."""
_UPPER = np.array([200.0, 100.0, 5000.0])
"""Largest coordinates of a response, see `_response`; slower controllers follow no path."""
_STEPS = (0.2, 0.2, 5.0, 0.05, 0.05, 0.05)
"""Steps of numerical derivatives: of these coordinates, then of the nuisance parameters."""
_MOVES = 2e-3
"""Range of set-points below which a joint counts as at rest, motor side [rad]; some steps of a resolver."""
_STRAIN = 9.0
"""Sum of squares of nuisance parameters, in standard deviations, by which it must fall otherwise; three of one."""
_FINER = 4
"""Set-points of the model's servo for each one that was sent; chosen: every millisecond, of 4."""
_FITS = 5
"""Most fits until a response is selected."""
_BLOCK = 0.25
"""Length of a block of time [s]; chosen: some periods of the servo."""
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
    model = _Model(arm=arm, logs=tuple(_Log.of(each, arm.robot) for each in recordings), n_threads=n_threads)
    if not model.moves.any():
        raise FFGymError(
            f"No set-point moves by more than {_MOVES} rad, motor side: the delay cannot be found. Record a motion."
        )
    fit = _select(model, progress or (lambda done, total: None))
    n = arm.robot.n_joints
    return ResponseFit(
        response=_response(fit.values, fit.count),
        intervals=fit.intervals(),
        factors=dict(zip(NUISANCES, np.exp(fit.values[fit.count :]).reshape(3, n), strict=True)),
        residual=np.where(model.moves, fit.spread, np.nan),
        undelayed=np.where(model.moves, model.spread_at_once(), np.nan),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Log:
    """Set-points and motor angles of one recording."""

    name: str
    sent: Array
    """Set-points every control step, motor side [rad], shape (T, N)."""
    t: Array
    """Times of measurements [s], shape (M,), within the samples."""
    measured: Array
    """Motor angles, motor side [rad], shape (M, N)."""

    @classmethod
    def of(cls, recording: Recording, robot: RobotDescription) -> "_Log":
        """Read a recording, from the first control step to the last whole one."""
        t, dt = recording.t - recording.t[0], robot.servo.control_dt
        grid = np.arange(int(t[-1] / dt + 1e-9) + 1) * dt
        if len(grid) < 2:
            raise FFGymError(f"Recording {recording.header.segment!r} lasts {t[-1]:.3g} s, needs a second or more.")
        sent, measured = (
            recording.header.motor_side(recording.joint_array(f"{name}.position")) for name in ("reference", "motor")
        )
        within = t <= grid[-1] + 1e-9
        samples = scipy.interpolate.make_interp_spline(t, sent, k=1)(np.minimum(grid, t[-1]))
        return cls(name=recording.header.segment, sent=samples, t=t[within], measured=measured[within])


@dataclass(frozen=True, kw_only=True, eq=False)
class _Model:
    """Motor angles of the documented robot, by parameters: response, then logarithms of factors (3 N)."""

    arm: RigidArm
    logs: tuple[_Log, ...]
    n_threads: int

    @property
    def step(self) -> float:
        """Smallest noise of a motor angle [rad]: that of the steps of the documented resolver."""
        return self.arm.robot.sensors.resolver_step / float(np.sqrt(12))

    @cached_property
    def robot(self) -> RobotDescription:
        """Robot whose servo gets set-points so often that lines between those that were sent stay straight."""
        servo = self.arm.robot.servo
        return replace(self.arm.robot, servo=replace(servo, control_dt=servo.control_dt / _FINER))

    @cached_property
    def moves(self) -> BoolArray:
        """True for joints whose set-points move, shape (N,)."""
        moves: BoolArray = np.max([np.ptp(log.sent, axis=0) for log in self.logs], axis=0) > _MOVES
        return moves

    @cached_property
    def blocks(self) -> Array:
        """Number of the block of each row of all logs, shape (M,)."""
        starts = np.cumsum([0, *(int(log.t[-1] / _BLOCK) + 1 for log in self.logs[:-1])])
        return np.concatenate([start + log.t // _BLOCK for start, log in zip(starts, self.logs, strict=True)])

    def residuals(self, each: Sequence[tuple[SetpointResponse, Array]]) -> list[Array]:
        """Compute measured angles less those of the model for several parameters, side by side: (M, N) each."""
        runs, machines = [], []
        for response, factors in each:
            machine = scale(self.robot, *np.exp(factors.reshape(3, -1)))
            runs += [Run(reference=self._reference(log, response)) for log in self.logs]
            machines += [machine] * len(self.logs)
        dt = self.robot.servo.control_dt
        recordings = simulate(runs, arm=self.arm, machine=machines, record_dt=dt, n_threads=self.n_threads)
        found = [
            log.measured
            - scipy.interpolate.make_interp_spline(recording.t, recording.joint_array("motor.position"), k=3)(log.t)
            for recording, log in zip(recordings, self.logs * len(each), strict=True)
        ]
        count = len(self.logs)
        return [np.concatenate(found[i * count : (i + 1) * count]) for i in range(len(each))]

    def spread_at_once(self) -> Array:
        """Compute the RMS of residuals of set-points that arrive at once, motor side [rad], shape (N,)."""
        (residual,) = self.residuals([(SetpointResponse(), np.zeros(3 * self.arm.robot.n_joints))])
        return rms(residual, 0)

    def guess(self) -> tuple[Array, float]:
        """Guess the noise of each joint [rad] and the delay [ms], by the shift at which motors move like the model."""
        nothing = np.zeros(3 * self.arm.robot.n_joints)
        (residual,) = self.residuals([(SetpointResponse(), nothing)])
        measured = np.concatenate([log.measured for log in self.logs])
        speed = np.concatenate([np.gradient(log.measured, log.t, axis=0) for log in self.logs])
        # late by tau: measured = model(t - tau), so that residual = -tau times the speed
        weight = self.moves / np.maximum(rms(measured - measured.mean(axis=0), 0), 1e-9) ** 2
        late = -float((weight * speed * residual).sum() / (weight * speed**2).sum())
        return np.hypot(rms(residual + late * speed, 0), self.step), 1e3 * float(np.clip(late, 1e-3, 0.09))

    def _reference(self, log: _Log, response: SetpointResponse) -> Reference:
        """Make the reference that a response makes of a log's set-points, which a drive joins by straight lines."""
        robot, dt = self.robot, self.robot.servo.control_dt
        arrived = response.apply(log.sent, _FINER * dt, _FINER)
        t = dt * np.arange(len(arrived), dtype=np.float64)
        path = scipy.interpolate.make_interp_spline(t, robot.drive.joint_angle(arrived), k=3)
        q, dq, ddq = (np.asarray(path(t, order), dtype=np.float64) for order in range(3))
        if not response.lag:  # lines have corners, over which a controller differences speeds
            cycle = _FINER * dt
            ddq = (dq - np.vstack([np.tile(dq[:1], (_FINER, 1)), dq[:-_FINER]])) / cycle
        return Reference(name=log.name, robot=robot, t=t, q=q, dq=dq, ddq=ddq, phases=())


def scale(robot: RobotDescription, coulomb: Array, viscous: Array, inertia: Array) -> RobotDescription:
    """Multiply static and Coulomb friction, viscous friction and rotor inertia of a robot by factors, (N,) each."""
    friction = replace(
        robot.friction,
        coulomb=robot.friction.coulomb * coulomb,
        static=robot.friction.static * coulomb,
        viscous=robot.friction.viscous * viscous,
    )
    return replace(
        robot, friction=friction, drive=replace(robot.drive, rotor_inertia=robot.drive.rotor_inertia * inertia)
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

    def intervals(self) -> dict[str, tuple[float, float]]:
        """Compute the 95 % intervals of the parameters of the response and of its total delay, in SI units."""
        k = self.count
        found = {}
        if k > 1:
            found["total_delay"] = _interval(1e-3 * self.values[0], 1e-3 * np.sqrt(self.covariance[0, 0]))
        own = self.values[:k]
        slopes = np.stack([_parameters(own + h) - _parameters(own - h) for h in _TINY * np.eye(k)], axis=1) / (
            2 * _TINY
        )
        sigma = np.sqrt(np.einsum("ij,jk,ik->i", slopes, self.covariance[:k, :k], slopes))
        return found | {
            name: _interval(value, s) for name, value, s in zip(NAMES, _parameters(own), sigma, strict=False)
        }


def _interval(middle: float, sigma: float) -> tuple[float, float]:
    """Return the ends of a 95 % interval."""
    return float(middle - 1.96 * sigma), float(middle + 1.96 * sigma)


def _response(values: Array, count: int) -> SetpointResponse:
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


def _select(model: _Model, progress: Progress) -> _Fit:
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


def _fit(model: _Model, start: Array, count: int, sigma: Array) -> _Fit:
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

    model: _Model
    count: int
    weight: Array
    """One over the noise of each joint [1/rad], 0 for joints at rest, shape (N,)."""

    def residuals(self, values: Array) -> Array:
        """Compute the residuals."""
        (residual,) = self.model.residuals([self._split(values)])
        return np.r_[(residual * self.weight).ravel(), values[self.count :] / PRIOR]

    def jacobian(self, values: Array) -> Array:
        """Differentiate the residuals: each parameter of the response, and each nuisance of all joints at once.

        What a joint's friction and inertia do to other joints is left out: it reaches them through springs alone.
        """
        n, k = len(self.weight), self.count
        steps = np.r_[_STEPS[:k], _STEPS[3:]]
        moved = [values]
        for i, step in enumerate(steps):
            change = np.zeros_like(values)
            change[i if i < k else slice(k + (i - k) * n, k + (i - k + 1) * n)] = step
            moved.append(values + change)
        first, *others = self.model.residuals([self._split(each) for each in moved])
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
        return _response(values, self.count), values[self.count :]
