"""The static LuGre model: friction in windows of constant speed, and the curve that fits it, thesis (6.4)-(6.9)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.diagnosis.identification.friction_data import FrictionTorque
from ffgym.diagnosis.resampling import RESAMPLES, Blocks, bootstrap
from ffgym.diagnosis.settings import settings
from ffgym.logs.quality.signals import stretches
from ffgym.robot.friction import stribeck_decay, stribeck_level


@dataclass(frozen=True, kw_only=True, eq=False)
class SteadyFriction:
    """Friction of one joint in windows of constant speed, R windows from any number of recordings."""

    speed: Array
    """Mean motor speed [rad/s], signed, shape (R,)."""
    friction: Array
    """Mean friction torque, motor side [N m], shape (R,); offsets and errors of gravity are in it."""
    run: IntArray
    """Run at one speed that the window is part of, shape (R,)."""

    @property
    def n_runs(self) -> int:
        """Number of runs."""
        return int(self.run[-1]) + 1 if len(self.run) else 0

    def levels(self) -> tuple[Array, Array]:
        """Mean speed [rad/s] and friction [N m] of each run, shape (n_runs,) each."""
        count = np.bincount(self.run)
        return np.bincount(self.run, self.speed) / count, np.bincount(self.run, self.friction) / count


def steady_friction(torques: Sequence[FrictionTorque], joint: int, presliding: float) -> SteadyFriction:
    """Find windows in which one joint moves at constant speed, with acceleration and bristles settled.

    Bristles bend by `presliding`, f_s / sigma_0 [rad], motor side.
    """
    tables: list[Array] = []
    for torque in torques:
        means = _means(torque, joint)
        for rows in find_steady_windows(torque, joint, settings().friction.settling_travel * presliding):
            tables.append(np.column_stack([means[rows], np.full(len(rows), len(tables))]))
    speed, friction, run = (np.concatenate(tables) if tables else np.zeros((0, 3))).T
    return SteadyFriction(speed=speed, friction=friction, run=run.astype(np.intp))


def find_steady_windows(torque: FrictionTorque, joint: int, settling: float) -> list[IntArray]:
    """Find windows of constant speed of one joint, run by run, once its motor has gone `settling` [rad].

    Returns:
        Numbers of the windows of each run with any, counted as `average_windows` counts them.
    """
    speed, found = _means(torque, joint)[:, 0], []
    for run in stretches(_is_constant(speed)):
        # the first and the last window have a ramp in them
        travel = settings().friction.speed_window * np.cumsum(np.abs(speed[run.start : run.stop - 1]))
        rows = run.start + 1 + np.flatnonzero(travel[:-1] >= settling)
        if len(rows):
            found.append(rows)
    return found


def constant_share(torque: FrictionTorque, joint: int) -> float:
    """Share of a record's time in which one joint moves at constant speed."""
    return float(np.mean(_is_constant(_means(torque, joint)[:, 0])))


def _means(torque: FrictionTorque, joint: int) -> Array:
    """Mean motor speed and friction in windows, shape (n_windows, 2); NaN at the ends of a record."""
    columns = (torque.signals.motor_dq, torque.friction)
    rows = np.stack([column[:, joint] for column in columns], axis=1)
    return average_windows(torque, joint, rows)


def average_windows(torque: FrictionTorque, joint: int, rows: Array) -> Array:
    """Average `rows` (T, C) of a record over the windows in which speeds are compared, shape (n_windows, C).

    NaN where rows do not count for the `joint`.
    """
    length = max(1, round(settings().friction.speed_window / torque.signals.dt))
    count = len(torque.signals.t) // length
    kept = np.array(rows[: count * length], dtype=np.float64)
    kept[~torque.counts(joint)[: count * length]] = np.nan
    means: Array = kept.reshape(count, length, -1).mean(axis=1)
    return means


def _is_constant(speed: Array) -> BoolArray:
    """Tell if speed changes neither before nor after a window, shape (n_windows,)."""
    limits = settings().friction
    constant = np.zeros(len(speed), dtype=np.bool_)
    if len(speed) >= 3:
        change = np.abs(np.diff(speed)) / limits.speed_window
        drift, here = np.maximum(change[1:], change[:-1]), np.abs(speed[1:-1])  # a sine of 2 windows looks the same
        allowed = np.maximum(limits.least_drift, limits.speed_drift * here)
        constant[1:-1] = (here > limits.lowest_speed) & (drift < allowed)
    return constant


@dataclass(frozen=True, kw_only=True, eq=False)
class StribeckFit:
    r"""Static LuGre model of one joint, motor side.

    .. math:: f(v) = (f_c + (f_s - f_c) e^{-(v/v_s)^2}) \mathrm{sign}(v) + f_v v \;+\; o + a |v|

    The even part, offset and asymmetry, is no part of the LuGre model: it is what both directions do not share.
    """

    values: Array
    """f_c [N m], f_s [N m], f_v [N m s/rad], v_s [rad/s], shape (4,)."""
    offset: float
    """o [N m]: an error of gravity, a torque offset, or Coulomb torques that differ; 0 if there is one direction."""
    asymmetry: float
    """a [N m s/rad]: half the difference of the viscous coefficients; 0 if there is one direction only."""
    resampled: Array
    """f_c, f_s, f_v, v_s, o, a of resampled windows, shape (B, 6)."""
    rms_error: float
    """Of the runs' mean friction [N m]."""
    lacking: Mapping[str, str]
    """Name what the speeds lack to tell each parameter, '' if nothing."""
    both_directions: bool
    """Whether there are runs in both directions; if not, gravity errors count as friction."""
    data: SteadyFriction
    """What was fitted to."""

    def curve(self, speed: Array) -> Array:
        """Friction [N m] at motor speeds [rad/s], without the even part."""
        coulomb, static, viscous, velocity = self.values
        level = stribeck_level(speed, coulomb, static, velocity)
        friction: Array = level * np.sign(speed) + viscous * speed
        return friction


def fit_stribeck(
    data: SteadyFriction,
    rng: np.random.Generator,
    *,
    stribeck_velocity: float | None = None,
    usual_velocity: float,
    n_resamples: int = RESAMPLES,
) -> StribeckFit:
    r"""Fit the static LuGre model to steady friction.

    For a given :math:`v_s` the model is linear in :math:`f_c, f_s - f_c, f_v \ge 0`, thesis (6.6)-(6.8), and is solved
    by non-negative least squares; that :math:`f_s \ge f_c` is a property of the model that the thesis leaves open. The
    best :math:`v_s` is found on top of that, unless `stribeck_velocity` [rad/s] gives it; where the speeds cannot tell
    it, it is `usual_velocity`.
    """
    fewest = settings().friction.fewest_runs
    if data.n_runs < fewest:
        raise FFGymError(
            f"There are {data.n_runs} runs at constant speed, must be {fewest} or more with different speeds for a "
            f"static friction curve. Record a speed ladder."
        )
    # the curve with v_s free, and with the usual one where the speeds do not tell it
    once, velocity = np.ones(len(data.speed)), stribeck_velocity
    values, residual = _solve(data, once, velocity)
    lacking = _lacking(data, float(values[3]))
    if velocity is None and lacking["stribeck_velocity"]:
        velocity = usual_velocity
        values, residual = _solve(data, once, velocity)
        lacking = _lacking(data, velocity) | {"stribeck_velocity": lacking["stribeck_velocity"]}
    windows = Blocks(of_row=np.arange(len(data.speed)), stratum=data.run)  # drawn within their runs
    return StribeckFit(
        values=values[:4],
        offset=float(values[4]),
        asymmetry=float(values[5]),
        resampled=bootstrap(lambda counts: _solve(data, counts, velocity)[0], windows, rng, n_resamples),
        rms_error=residual,
        lacking=lacking,
        both_directions=_has_both_directions(data),
        data=data,
    )


def _has_both_directions(data: SteadyFriction) -> bool:
    return bool(np.any(data.speed > 0) and np.any(data.speed < 0))


def _solve(data: SteadyFriction, counts: Array, given: float | None) -> tuple[Array, float]:
    """Parameters f_c, f_s, f_v, v_s, o, a from the means of runs, and the RMS error [N m].

    Windows count as often as `counts` says; v_s is `given` [rad/s], or that of the least error.
    """
    # means of runs, each as heavy as it is long
    weight = np.bincount(data.run, counts, data.n_runs)
    speed = np.bincount(data.run, counts * data.speed, data.n_runs) / weight
    friction = np.bincount(data.run, counts * data.friction, data.n_runs) / weight
    root = np.sqrt(weight / weight.sum())
    sign, size, both = np.sign(speed), np.abs(speed), _has_both_directions(data)

    def at(velocity: float) -> tuple[Array, float]:
        # regressors of f_c, f_s - f_c, f_v, and of the even part with both signs, since none may be negative
        regressors = [sign, sign * stribeck_decay(speed, velocity), speed]
        if both:
            regressors += [np.ones_like(speed), -np.ones_like(speed), size, -size]
        return scipy.optimize.nnls(root[:, None] * np.stack(regressors, axis=1), root * friction)

    velocity = given
    if velocity is None:
        # the best of a grid, then within its neighbours
        limits = settings().friction
        grid = np.geomspace(
            limits.least_stribeck_velocity, limits.largest_stribeck_velocity, limits.stribeck_velocities
        )
        best = int(np.argmin([at(tried)[1] for tried in grid]))
        low, high = np.log(grid[max(best - 1, 0)]), np.log(grid[min(best + 1, len(grid) - 1)])
        found = scipy.optimize.minimize_scalar(
            lambda x: at(float(np.exp(x)))[1], bounds=(low, high), method="bounded", options={"xatol": 1e-3}
        )
        velocity = float(np.exp(found.x))
    solution, error = at(velocity)
    coulomb, rise, viscous = solution[:3]
    even = solution[3::2] - solution[4::2] if both else np.zeros(2)
    return np.array([coulomb, coulomb + rise, viscous, velocity, *even]), float(error)


def _lacking(data: SteadyFriction, velocity: float) -> dict[str, str]:
    """Name what the speeds lack to tell each parameter, for a Stribeck velocity."""
    limits = settings().friction
    slow, fast = limits.slow * velocity, limits.fast * velocity
    # speeds below v_s tell f_s, speeds far above it f_c, and two of those f_v
    speeds = np.abs(data.levels()[0])
    sliding = speeds[speeds >= fast]
    if np.count_nonzero(np.bincount(data.run) > 1) < limits.fewest_runs:
        return dict.fromkeys(("coulomb", "static", "viscous", "stribeck_velocity"), "runs too short for an interval")
    no_slow = "" if speeds.min() <= slow else f"no constant speed below {slow:.3g} rad/s"
    no_fast = "" if len(sliding) else f"no constant speed above {fast:.3g} rad/s"
    are_spread = len(sliding) and sliding.max() >= limits.speed_ratio * sliding.min()
    no_spread = "" if are_spread else "constant speeds too close together"
    return {
        "coulomb": no_fast,
        "static": no_slow,
        "viscous": no_fast or no_spread,
        "stribeck_velocity": no_slow or no_fast,
    }
