"""The dynamic LuGre model: records with reversals, and the bristles that fit them, thesis (6.14)-(6.18)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
import scipy
from numpy.typing import NDArray

from ffgym.control import DynamicLuGreExact
from ffgym.core.errors import FFGymError
from ffgym.core.measures import rms
from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.identification.friction_data import FrictionTorque
from ffgym.diagnosis.identification.stribeck_fit import constant_share
from ffgym.diagnosis.resampling import Blocks
from ffgym.diagnosis.settings import settings
from ffgym.logs.preparation import LowPass
from ffgym.logs.quality.signals import stretches
from ffgym.robot.friction import LuGreParameters

_STEP = 1e-4
"""Step of the logarithm of a parameter in difference quotients."""

NUISANCES = ("inertia", "links", "joint stiffness", "lag of the friction", "delay of the torque", "offset")
"""Numbers that are fitted beside both bristle parameters, in the order of arrays here."""

N_NUISANCES, N_PRIORS = len(NUISANCES), 4
"""Their number, and how many of them have a prior: the second to the fifth."""

N_OWN = 2 + N_NUISANCES
"""Numbers that a fit finds."""

NAMES = ("coulomb", "static", "viscous", "stribeck_velocity", "bristle_stiffness", "bristle_damping")
"""Parameters of `LuGreParameters`, in the order of arrays here."""


def reverses(torque: FrictionTorque, joint: int, presliding: float) -> bool:
    """Tell if a joint turns back between slides in a record, some times `presliding` [rad] long: it tells bristles."""
    limits, rest = settings().friction, settings().patterns.rest
    # strokes between changes of sign, and those that are long enough to slide
    speed = torque.signals.motor_dq[torque.counts(joint), joint]
    moving = speed[np.abs(speed) > rest]
    if not len(moving):
        return False
    stroke = np.concatenate([[0], np.cumsum(np.diff(np.sign(moving)) != 0)])
    slides = np.bincount(stroke, np.abs(moving)) * torque.signals.dt > limits.slides * presliding
    n_reversals = np.count_nonzero(slides[1:] & slides[:-1])
    return bool(n_reversals >= limits.fewest_reversals) and constant_share(torque, joint) < limits.constant_share


@dataclass(frozen=True, kw_only=True, eq=False)
class SlidingData:
    """Motion and friction of one joint in R records side by side, T rows; short ones go on with their last row."""

    segments: tuple[str, ...]
    """Names of the records, shape (R,)."""
    dt: float
    """Sample period [s]."""
    speed: Array
    """Motor speed [rad/s], shape (T, R)."""
    friction: Array
    """Friction torque, motor side [N m], shape (T, R)."""
    by_inertia: Array
    """Derivative of the torque of rotor and links by a common share of them, motor side [N m], shape (T, R)."""
    by_links: Array
    """The same by a share of the links alone [N m], shape (T, R)."""
    by_springs: Array
    """The same by a share of the joint stiffness [N m], shape (T, R)."""
    arm_rate: Array
    """Rate of the torque of inertia, gravity and springs [N m/s], motor side, shape (T, R)."""
    angle_noise: Array
    """Standard deviation of white noise of the motor angle in each record [rad], shape (R,)."""
    shaken: Array
    """Inertia of rotor and of links that such noise shakes, motor side [kg m^2], shape (2, R)."""
    rows_dt: float
    """Time between the rows of the records, of which every so many-th is here [s]."""
    scored: BoolArray
    """Rows that count: the filter knows them, and bristles have forgotten how they began, shape (T, R)."""
    low_pass: LowPass
    """Filter of speed and friction, which a model's friction goes through too."""

    def model_friction(self, values: Array, speed: Array | None = None, n_substeps: int = 1) -> Array:
        """Compute the friction of P models (P, 6), filtered as the measured one, shape (P, T, R), thesis (6.16).

        Along the measured speed, or another `speed` (T, R) [rad/s]; parameters are in the order of NAMES.
        """
        n_models, (n_rows, n_records) = len(values), self.speed.shape
        friction = dict(zip(NAMES, np.repeat(values, n_records, axis=0).T, strict=True))
        law = DynamicLuGreExact(LuGreParameters(**friction), n_substeps=n_substeps)
        torque = law.along(np.tile(self.speed if speed is None else speed, (1, n_models)), self.dt)
        filtered = self.low_pass(torque, self.dt).reshape(n_rows, n_models, n_records)
        return filtered.transpose(1, 0, 2)

    @property
    def sharp_speed(self) -> Array:
        """Speed before the filter, by one step of van Cittert's deconvolution [rad/s], shape (T, R)."""
        return np.asarray(2 * self.speed - self.low_pass(self.speed, self.dt))

    def measure_again(self, friction: Array, rng: np.random.Generator) -> "SlidingData":
        """Draw surrogate data: this motion with some `friction` (T, R) [N m], its angle measured with noise anew."""
        every = round(self.dt / self.rows_dt)
        white = self.angle_noise * rng.standard_normal((every * len(self.speed), len(self.segments)))
        speed = np.gradient(self.low_pass(white, self.rows_dt), self.rows_dt, axis=0)
        rotor, links = self.shaken[:, None] * np.gradient(speed, self.rows_dt, axis=0)[::every]
        return replace(
            self,
            speed=self.low_pass(self.sharp_speed, self.dt) + speed[::every],
            friction=friction - rotor - links,
            by_inertia=self.by_inertia + rotor + links,
            by_links=self.by_links + links,
        )

    def blocks(self) -> Blocks:
        """Blocks of the scored rows of `flat`, drawn within their record."""
        duration = settings().friction.block
        joined = Blocks.joined([Blocks.cut([rows], self.dt, duration) for rows in self.scored.T if rows.any()])
        return Blocks(of_row=joined.of_row[joined.of_row >= 0], stratum=joined.stratum)

    def flat(self, values: Array) -> Array:
        """Scored rows of `values` (..., T, R), one record after the other, shape (..., S)."""
        return np.concatenate([values[..., rows, r] for r, rows in enumerate(self.scored.T)], axis=-1)


def sliding_data(torques: Sequence[FrictionTorque], joint: int, presliding: float) -> SlidingData:
    """Put records, sampled at periods that differ by whole factors, side by side for one joint.

    Bristles bend by `presliding`, f_s / sigma_0 [rad], motor side.
    """
    limits, rest = settings().friction, settings().patterns.rest
    low_pass, rows_dt = torques[0].signals.low_pass, max(torque.signals.dt for torque in torques)
    dt = rows_dt * max(1, int(1 / (limits.samples_per_period * low_pass.cutoff * rows_dt)))
    every = []
    for torque in torques:
        step = round(dt / torque.signals.dt)
        if abs(step * torque.signals.dt - dt) > limits.same_period * dt or torque.signals.low_pass != low_pass:
            raise FFGymError(
                f"Recording {torque.signals.segment!r} is sampled every {torque.signals.dt:g} s, which does not divide "
                f"the {dt:g} s of others, or is filtered otherwise; records that are used together must fit one "
                "another."
            )
        every.append(step)

    # short records go on with their last row, which does not count
    length = max(-(-len(torque.signals.t) // step) for torque, step in zip(torques, every, strict=True))

    def side_by_side(columns: Sequence[NDArray[Any]], beyond: Literal["edge", "constant"] = "edge") -> NDArray[Any]:
        thinned = [column[::step] for column, step in zip(columns, every, strict=True)]
        return np.stack([np.pad(x, (0, length - len(x)), mode=beyond) for x in thinned], axis=1)

    speed = side_by_side([torque.signals.motor_dq[:, joint] for torque in torques])
    # at rest the noise of the speed makes the bristles of a model creep: they are known once they have slipped
    known = np.zeros(speed.shape, dtype=np.bool_)
    for r, own in enumerate(speed.T):
        around = scipy.ndimage.maximum_filter1d(np.abs(own), max(1, round(limits.rest_time / dt)))
        for run in stretches(around > rest):
            known[run, r] = np.cumsum(np.abs(own[run])) * dt > limits.forgetting_travel * presliding
    return SlidingData(
        segments=tuple(torque.signals.segment for torque in torques),
        dt=dt,
        speed=speed,
        friction=side_by_side([torque.friction[:, joint] for torque in torques]),
        by_inertia=side_by_side([torque.by_inertia[:, joint] for torque in torques]),
        by_links=side_by_side([torque.by_links[:, joint] for torque in torques]),
        by_springs=side_by_side([torque.by_springs[:, joint] for torque in torques]),
        arm_rate=side_by_side(
            [np.gradient((each.inertia + each.holding)[:, joint], each.signals.dt) for each in torques]
        ),
        angle_noise=np.array([torque.signals.angle_noise[joint] for torque in torques]),
        shaken=np.stack([torque.shaken[:, joint] for torque in torques], axis=1),
        rows_dt=rows_dt,
        scored=known & side_by_side([torque.counts(joint) for torque in torques], "constant"),
        low_pass=low_pass,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class BristleFit:
    """Dynamic LuGre model of one joint, motor side."""

    values: Array
    """sigma_0 [N m/rad] and sigma_1 [N m s/rad], shape (2,)."""
    inertia_error: float
    """Share of the model's inertial torque that is missing; the nuisance that friction is not to absorb."""
    link_error: float
    """Share of the links' masses that is missing beside it, which bends elastic joints otherwise; a nuisance too."""
    spring_error: float
    """Share of the joint stiffness that is missing; a nuisance too."""
    lag: float
    """Time by which friction follows the motion [s]; a nuisance too."""
    delay: float
    """Time by which the torque acts later than its record says [s]; a nuisance too."""
    offset: float
    """Mean torque that neither model nor friction explains [N m]."""
    inertia_at_bound: bool
    """True if the inertia error lies at its bound, so that friction had to absorb the rest of it."""
    held: tuple[str, ...]
    """Other nuisances that lie at their bounds, of NUISANCES: they make up for more than they stand for."""
    at_bound: BoolArray
    """True for a value at its bound, so that the data do not tell it, shape (2,)."""
    resampled: Array
    """sigma_0, sigma_1 of resampled blocks, shape (B, 2)."""
    rms_error: float
    """RMS of the friction torque that is left [N m]."""
    n_blocks: int
    """Blocks that could be resampled."""
    data: SlidingData
    """Records that were fitted to."""


def fit_bristles(
    data: SlidingData, static: Array, static_resampled: Array, rng: np.random.Generator, start: Array | None = None
) -> BristleFit:
    r"""Fit sigma_0 and sigma_1 to friction along measured speeds, thesis (6.17), beside nuisances.

    .. math:: \min \sum_k \left( \hat f_k - \epsilon^T r_k - F_k + (l - d) \dot F_k - d \dot a_k - o \right)^2
        + \sum_i (s p_i / \pi_i)^2, \quad F_k = F(v_k | \sigma_0, \sigma_1)

    with errors :math:`\epsilon` of inertia, links and springs times the derivatives r of the torque a of the arm by
    them, the lag l of friction, the delay d of the torque and an offset o; p are the nuisances that have priors of
    standard deviation :math:`\pi`, and s is the RMS of what is left. The fit is over logarithms of sigma_0 and sigma_1,
    within bounds, from a `start` (2,), or the best of random ones; its bias on surrogate data is subtracted.

    Intervals are those of resampled blocks with one Gauss-Newton step each, together with those of the `static`
    parameters f_c, f_s, f_v, v_s, (4,) and resampled (B, 4).

    Reference:
        Davison & Hinkley (1997), Bootstrap Methods and their Application, ch. 2.3 and 4, for surrogate data of a fit.
    """
    limits = settings().friction
    # the best of several starts, as bristles that are too stiff or too soft leave no slope to follow
    problem = _Problem(data, static)
    starts = problem.starts(rng) if start is None else [np.array([*np.log(start), *np.zeros(N_NUISANCES)])]
    found = min((problem.refine(x) for x in starts), key=lambda fit: fit.cost)

    # once more, with priors that weigh against the error that is left
    problem.misfit = rms(problem.residual(found.x)[:-N_PRIORS])
    found = problem.refine(found.x)
    errors, blocks = problem.residual(found.x)[:-N_PRIORS], data.blocks()
    slopes, priors = np.split(problem.slopes(found.x, [4, 5, 0, 1, 2, 3]), [-N_PRIORS])

    # nuisances at a bound stay there
    free = np.abs(found.x) < limits.near_bound * problem.high
    free[:2] = True
    own, by_static, priors = slopes[:, :N_OWN][:, free], slopes[:, N_OWN:], priors[:, :N_OWN][:, free]

    # bias: surrogate data of this model along the measured motion, measured and fitted once more
    bias, exact = np.zeros(N_OWN), problem.torque(found.x)
    for _ in range(limits.noisy_copies):
        copy = _Problem(data.measure_again(exact, rng), static, problem.misfit)
        error = np.concatenate([copy.residual(found.x)[:-N_PRIORS], np.zeros(N_PRIORS)])
        bias[free] -= np.linalg.lstsq(copy.slopes(found.x)[:, free], error)[0] / limits.noisy_copies
    x = found.x - bias

    # one Gauss-Newton step from the estimate for each resample of blocks, static parameters and priors
    curvature = blocks.sums(np.einsum("si,sj->sij", own, own))
    pull = blocks.sums(own * errors[:, None])
    cross = blocks.sums(np.einsum("si,sj->sij", own, by_static))
    resampled = np.empty((len(static_resampled), 2))
    ratio = np.divide(static_resampled, static, out=np.ones_like(static_resampled), where=static > 0)
    for row, moved in zip(resampled, np.log(np.maximum(ratio, limits.least_ratio)), strict=True):
        counts = blocks.draw(rng)
        h, g, c = (np.tensordot(counts, part, axes=1) for part in (curvature, pull, cross))
        h += priors.T @ priors
        g += priors.T @ (priors @ found.x[free] - problem.misfit * rng.standard_normal(N_PRIORS))
        row[:] = x[:2] - np.linalg.solve(h, g + c @ moved)[:2]
    return BristleFit(
        values=np.exp(x[:2]),
        inertia_error=float(x[2]),
        link_error=float(x[3]),
        spring_error=float(x[4]),
        lag=float(x[5]),
        delay=float(x[6]),
        offset=float(x[7]),
        inertia_at_bound=bool(abs(found.x[2]) > limits.near_bound * limits.inertia_error),
        held=tuple(name for name, moves in zip(NUISANCES[1:], free[3:], strict=True) if not moves),
        at_bound=found.active_mask[:2] != 0,
        resampled=np.exp(resampled),
        rms_error=rms(errors),
        n_blocks=blocks.n_resampled,
        data=data,
    )


class _Problem:
    """Residuals of records and priors.

    x = (log sigma_0, log sigma_1, errors of inertia, of links and of springs, lag, delay, offset).
    """

    def __init__(self, data: SlidingData, static: Array, misfit: float | None = None) -> None:
        self.data, self.static, limits = data, static, settings().friction
        self._friction = data.flat(data.friction)
        self._arm_rate = data.flat(data.arm_rate)
        self._nuisances = np.stack(
            [data.flat(data.by_inertia), data.flat(data.by_links), data.flat(data.by_springs)], axis=1
        )
        self._last: tuple[Array, Array, Array] | None = None
        coulomb = static[0]
        self.misfit = limits.misfit * coulomb if misfit is None else misfit
        self._spread = np.array([limits.link_error, limits.spring_error, limits.lag * data.rows_dt, limits.delay])
        span = max(float(np.ptp(self._friction)), coulomb)
        self.high = np.array(
            [
                *np.log(coulomb / np.array([limits.least_presliding, limits.least_damping_speed])),
                *[limits.inertia_error] * 3,
                data.rows_dt,
                limits.longest_delay,
                span,
            ]
        )
        largest = np.array([limits.largest_presliding, limits.largest_damping_speed])
        self.low = np.array([*np.log(coulomb / largest), *-self.high[2:]])

    def _model(self, logs: Array) -> tuple[Array, Array]:
        """Friction of the models (P, 6) given as logarithms, and its rate, at the scored rows, shape (P, S) each."""
        friction = self.data.model_friction(np.exp(logs))
        return self.data.flat(friction), self.data.flat(np.gradient(friction, self.data.dt, axis=1))

    def _all(self, x: Array) -> Array:
        return np.concatenate([np.log(self.static), x[:2]])

    def residual(self, x: Array) -> Array:
        """Friction torque that is not explained [N m], and what priors are off in its scale, shape (S + 4,)."""
        friction, rate = self._at(self._all(x))
        late = x[5] * rate - x[6] * (rate + self._arm_rate)
        rest = self._friction - self._nuisances @ x[2:5] + late - x[7] - friction
        return np.concatenate([rest, self.misfit * x[3:7] / self._spread])

    def _at(self, logs: Array) -> tuple[Array, Array]:
        """Friction of one model (6,) given as logarithms, and its rate, (S,); the last is kept for its slopes."""
        if self._last is None or not np.array_equal(self._last[0], logs):
            friction, rate = self._model(logs[None])
            self._last = (logs, friction[0], rate[0])
        return self._last[1:]

    def slopes(self, x: Array, moved: Sequence[int] = (4, 5)) -> Array:
        """Derivative of `residual` by x, and by logarithms of further parameters `moved`, numbered as NAMES."""
        base = self._all(x)
        steps = np.where(np.array(moved) == 0, -_STEP, _STEP)  # f_c goes down: without a Stribeck peak it is f_s
        friction, rate = self._at(base)
        models, rates = self._model(
            np.stack([base + step * np.eye(6)[i] for i, step in zip(moved, steps, strict=True)])
        )
        by_logs = -(models - friction - (x[5] - x[6]) * (rates - rate)).T / steps
        rows = np.column_stack(
            [by_logs[:, :2], -self._nuisances, rate, -(rate + self._arm_rate), -np.ones_like(rate), by_logs[:, 2:]]
        )
        priors = np.zeros((N_PRIORS, rows.shape[1]))
        priors[np.arange(N_PRIORS), np.arange(3, 7)] = self.misfit / self._spread
        return np.concatenate([rows, priors])

    def torque(self, x: Array) -> Array:
        """Torque that model and nuisances give along the motion before the filter [N m], shape (T, R)."""
        values, n_substeps = np.exp(self._all(x))[None], settings().friction.surrogate_steps
        friction = self.data.model_friction(values, self.data.sharp_speed, n_substeps)[0]
        lagging = friction - (x[5] - x[6]) * np.gradient(friction, self.data.dt, axis=0) + x[6] * self.data.arm_rate
        arm = x[2] * self.data.by_inertia + x[3] * self.data.by_links + x[4] * self.data.by_springs
        explained: Array = lagging + arm + x[7]
        return explained

    def starts(self, rng: np.random.Generator) -> list[Array]:
        """The best of random starts."""
        limits = settings().friction
        x = np.zeros((limits.starts, N_OWN))
        x[:, :2] = rng.uniform(self.low[:2], self.high[:2], size=(limits.starts, 2))
        errors = self._friction - self._model(np.stack([self._all(row) for row in x]))[0]
        best = np.argsort(np.sum(errors**2, axis=1))[: limits.refined_starts]
        return list(x[best])

    def refine(self, start: Array) -> "scipy.optimize.OptimizeResult":
        """Least squares from one start."""
        start = np.clip(start, self.low, self.high)
        scale = [1.0, 1.0, 0.01, 0.01, 0.01, 1e-4, 1e-4, 0.01]
        return scipy.optimize.least_squares(
            self.residual, start, self.slopes, bounds=(self.low, self.high), x_scale=scale, xtol=1e-5
        )
