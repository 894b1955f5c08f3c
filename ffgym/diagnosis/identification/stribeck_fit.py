"""The static LuGre model from friction at constant speeds, thesis (6.4)-(6.9)."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import scipy

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.diagnosis.identification.resampling import RESAMPLES, bootstrap
from ffgym.diagnosis.identification.steady import SteadyFriction

SLOW, FAST = 0.8, 2.0
"""Speeds in Stribeck velocities that data must have at or below, and at or above: there the Stribeck part is half of
what it is at rest, and 2 % of it. Between them f_s, f_c and v_s cannot be told apart."""

SPREAD = 2.0
"""Ratio of the fastest to the slowest sliding speed from which viscous and Coulomb friction can be told apart."""

MIN_RUNS = 3
"""Runs at constant speed that a curve takes at least."""

VELOCITIES = (0.01, 10.0)
"""Range of Stribeck velocities that are looked at [rad/s], motor side."""

_GRID = 25
"""Stribeck velocities that are tried before the best is refined: two steps are a factor of 1.8."""


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
    """What the speeds lack to tell each parameter, '' if nothing."""
    both_directions: bool
    """Whether there are runs in both directions; if not, gravity errors count as friction."""
    data: SteadyFriction
    """What was fitted to."""

    def curve(self, speed: Array) -> Array:
        """Friction [N m] at motor speeds [rad/s], without the even part."""
        coulomb, static, viscous, velocity = self.values
        level = coulomb + (static - coulomb) * np.exp(-((speed / velocity) ** 2))
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
    best :math:`v_s` is found on top of that, where the speeds can tell it.

    Args:
        data: friction in windows of constant speed.
        rng: draws the resamples.
        stribeck_velocity: v_s [rad/s]; None estimates it.
        usual_velocity: v_s [rad/s] that is taken where the speeds cannot tell it.
        n_resamples: how many resamples.

    Raises:
        FFGymError: if there are too few runs.
    """
    if data.n_runs < MIN_RUNS:
        raise FFGymError(
            f"There are {data.n_runs} runs at constant speed, must be {MIN_RUNS} or more with different speeds for a "
            f"static friction curve. Record a speed ladder."
        )
    fit = _RunFit(data, stribeck_velocity)
    values, residual = fit.solve(np.ones(data.n_rows))
    lacking = _lacking(data, float(values[3]))
    if stribeck_velocity is None and lacking["stribeck_velocity"]:
        fit = _RunFit(data, usual_velocity)
        values, residual = fit.solve(np.ones(data.n_rows))
        lacking = _lacking(data, usual_velocity) | {"stribeck_velocity": lacking["stribeck_velocity"]}
    return StribeckFit(
        values=values[:4],
        offset=float(values[4]),
        asymmetry=float(values[5]),
        resampled=bootstrap(lambda counts: fit.solve(counts)[0], data.blocks, rng, n_resamples),
        rms_error=residual,
        lacking=lacking,
        both_directions=fit.both_directions,
        data=data,
    )


class _RunFit:
    """Fits to the means of runs, however often their windows count."""

    def __init__(self, data: SteadyFriction, stribeck_velocity: float | None) -> None:
        self._data, self._given = data, stribeck_velocity
        self._n_runs = data.n_runs
        self.both_directions = bool(np.any(data.speed > 0) and np.any(data.speed < 0))
        self._grid = np.geomspace(*VELOCITIES, _GRID)

    def solve(self, counts: Array) -> tuple[Array, float]:
        """Parameters f_c, f_s, f_v, v_s, o, a, and the RMS error [N m]."""
        data = self._data
        weight = np.bincount(data.run, counts, self._n_runs)
        speed = np.bincount(data.run, counts * data.speed, self._n_runs) / weight
        friction = np.bincount(data.run, counts * data.friction, self._n_runs) / weight
        root = np.sqrt(weight / weight.sum())

        def at(velocity: float) -> tuple[Array, float]:
            return scipy.optimize.nnls(root[:, None] * self._regressors(speed, velocity), root * friction)

        best = self._given if self._given is not None else self._refined(lambda velocity: at(velocity)[1])
        solution, error = at(best)
        coulomb, rise, viscous = solution[:3]
        even = solution[3::2] - solution[4::2] if self.both_directions else np.zeros(2)
        return np.array([coulomb, coulomb + rise, viscous, best, *even]), float(error)

    def _regressors(self, speed: Array, velocity: float) -> Array:
        """Columns of f_c, f_s - f_c, f_v, and of the even part with both signs, since none may be negative."""
        sign, size = np.sign(speed), np.abs(speed)
        columns = [sign, sign * np.exp(-((speed / velocity) ** 2)), speed]
        if self.both_directions:
            columns += [np.ones_like(speed), -np.ones_like(speed), size, -size]
        return np.stack(columns, axis=1)

    def _refined(self, error: Callable[[float], float]) -> float:
        """Stribeck velocity of least error: the best of a grid, then within its neighbours."""
        errors = [error(velocity) for velocity in self._grid]
        best = int(np.argmin(errors))
        low, high = self._grid[max(best - 1, 0)], self._grid[min(best + 1, _GRID - 1)]
        found = scipy.optimize.minimize_scalar(
            lambda x: error(float(np.exp(x))),
            bounds=(np.log(low), np.log(high)),
            method="bounded",
            options={"xatol": 1e-3},
        )
        return float(np.exp(found.x))


def _lacking(data: SteadyFriction, velocity: float) -> dict[str, str]:
    """What the speeds lack to tell each parameter, for a Stribeck velocity."""
    speeds = np.abs(data.levels()[0])
    sliding = speeds[speeds >= FAST * velocity]
    if np.count_nonzero(np.bincount(data.run) > 1) < MIN_RUNS:
        return dict.fromkeys(("coulomb", "static", "viscous", "stribeck_velocity"), "runs too short for an interval")
    no_slow = "" if speeds.min() <= SLOW * velocity else f"no constant speed below {SLOW * velocity:.3g} rad/s"
    no_fast = "" if len(sliding) else f"no constant speed above {FAST * velocity:.3g} rad/s"
    no_spread = "" if len(sliding) and sliding.max() >= SPREAD * sliding.min() else "constant speeds too close together"
    return {
        "coulomb": no_fast,
        "static": no_slow,
        "viscous": no_fast or no_spread,
        "stribeck_velocity": no_slow or no_fast,
    }
