"""The dynamic LuGre model from records with reversals, thesis (6.14)-(6.18)."""

from dataclasses import dataclass

import numpy as np
import scipy

from ffgym.core.measures import rms
from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.identification.sliding_data import SlidingData
from ffgym.robot.friction import LuGreParameters

PRESLIDING = (1e-5, 1.0)
"""Bounds of the presliding length f_c / sigma_0 [rad], motor side."""

DAMPING_SPEED = (1e-2, 1e3)
"""Bounds of f_c / sigma_1 [rad/s], motor side."""

INERTIA_ERROR = 0.5
"""Largest relative error of the inertia that is allowed for: thesis 6.1.2 estimates up to 5 %, but descriptions give
links within 30 % and rotors within a factor of two (docs/robots). A narrower bound makes bristles absorb the rest."""

_NEAR_BOUND = 0.99
"""Share of a bound from which on a fit ends at it: the solver stays inside."""

_LEAST_RATIO = 0.01
"""Smallest share of its estimate that a resampled static parameter counts as: one that ends at zero, where its
logarithm is not finite, is far outside of what one Gauss-Newton step can follow. Chosen."""

BLOCK = 0.5
"""Duration of a block that is resampled [s]: long against the filter's memory of 25 ms, some of them in each record."""

MIN_BLOCKS = 8
"""Blocks that an interval takes at least; of fewer, resamples say little."""

_STARTS, _REFINED = 48, 3
"""Random starts that are simulated, all at once, and the best of them that are refined."""

_STEP = 1e-4
"""Step of the logarithm of a parameter in difference quotients."""

NAMES = ("coulomb", "static", "viscous", "stribeck_velocity", "bristle_stiffness", "bristle_damping")
"""Parameters of `LuGreParameters`, in the order of arrays here."""


@dataclass(frozen=True, kw_only=True, eq=False)
class BristleFit:
    """Dynamic LuGre model of one joint, motor side."""

    values: Array
    """sigma_0 [N m/rad] and sigma_1 [N m s/rad], shape (2,)."""
    inertia_error: float
    """Share of the model's inertial torque that is missing; the nuisance that friction is not to absorb."""
    offset: float
    """Mean torque that neither model nor friction explains [N m]."""
    inertia_at_bound: bool
    """Whether the inertia error lies at its bound, so that friction had to absorb the rest of it."""
    at_bound: BoolArray
    """Whether a value lies at its bound, so that the data do not tell it, shape (2,)."""
    resampled: Array
    """sigma_0, sigma_1 of resampled blocks, shape (B, 2)."""
    rms_error: float
    """Of the friction torque [N m]."""
    n_blocks: int
    """Blocks that could be resampled."""
    data: SlidingData
    """What was fitted to."""


def model_of(values: Array) -> LuGreParameters:
    """Model of one joint from parameters in the order of NAMES, shape (6,)."""
    return LuGreParameters(**{name: np.array([value]) for name, value in zip(NAMES, values, strict=True)})


def fit_bristles(
    data: SlidingData, static: Array, static_resampled: Array, rng: np.random.Generator, start: Array | None = None
) -> BristleFit:
    r"""Fit sigma_0 and sigma_1 to friction along measured speeds, thesis (6.17).

    .. math:: \min_{\sigma_0, \sigma_1, \epsilon, o} \sum_k
        \left( \hat f_k - \epsilon \tau_{inertia, k} - o - F(v_k | \sigma_0, \sigma_1) \right)^2

    over logarithms of the parameters, within bounds, from the best of random starts. Intervals are those of
    resampled blocks with one Gauss-Newton step each, together with those of the static parameters.

    Args:
        data: records with reversals.
        static: f_c, f_s, f_v, v_s, shape (4,).
        static_resampled: the same of resampled windows, shape (B, 4).
        rng: draws starts and blocks.
        start: sigma_0, sigma_1 of a fit before, to start from alone, shape (2,); None starts at random.
    """
    problem = _Problem(data, static)
    starts = problem.starts(rng) if start is None else [np.array([*np.log(start), 0.0, 0.0])]
    found = min((problem.refined(x) for x in starts), key=lambda fit: fit.cost)
    errors = problem.residual(found.x)
    return BristleFit(
        values=np.exp(found.x[:2]),
        inertia_error=float(found.x[2]),
        offset=float(found.x[3]),
        inertia_at_bound=bool(abs(found.x[2]) > _NEAR_BOUND * INERTIA_ERROR),
        at_bound=found.active_mask[:2] != 0,
        resampled=_resampled(problem, found.x, static_resampled, rng),
        rms_error=rms(errors),
        n_blocks=data.blocks(BLOCK).n_resampled,
        data=data,
    )


class _Problem:
    """Residuals of records under parameters x = (log sigma_0, log sigma_1, inertia error, offset)."""

    def __init__(self, data: SlidingData, static: Array) -> None:
        self.data, self.static = data, static
        self._friction, self._inertia = data.flat(data.friction), data.flat(data.inertia)
        self._last: tuple[Array, Array] | None = None
        coulomb = static[0]
        span = max(float(np.ptp(self._friction)), coulomb)
        self.low = np.array([*np.log(coulomb / np.array([PRESLIDING[1], DAMPING_SPEED[1]])), -INERTIA_ERROR, -span])
        self.high = np.array([*np.log(coulomb / np.array([PRESLIDING[0], DAMPING_SPEED[0]])), INERTIA_ERROR, span])

    def _model(self, logs: Array) -> Array:
        """Friction of the models (P, 6) given as logarithms, at the scored rows, shape (P, S)."""
        return self.data.flat(self.data.model_friction([model_of(np.exp(row)) for row in logs]))

    def _all(self, x: Array) -> Array:
        return np.concatenate([np.log(self.static), x[:2]])

    def residual(self, x: Array) -> Array:
        """Friction torque that is not explained [N m], shape (S,)."""
        rest: Array = self._friction - x[2] * self._inertia - x[3] - self._at(self._all(x))
        return rest

    def _at(self, logs: Array) -> Array:
        """Friction of one model (6,) given as logarithms, (S,); the last is kept, as its slopes are asked for next."""
        if self._last is None or not np.array_equal(self._last[0], logs):
            self._last = (logs, self._model(logs[None])[0])
        return self._last[1]

    def jacobian(self, x: Array) -> Array:
        """Of `residual`, shape (S, 4)."""
        return self._slopes(x, [4, 5])

    def with_static(self, x: Array) -> Array:
        """Of `residual` by x, and by the logarithms of the static parameters, shape (S, 8)."""
        return self._slopes(x, [4, 5, 0, 1, 2, 3])

    def _slopes(self, x: Array, moved: list[int]) -> Array:
        """Difference quotients by parameters `moved`, with those of inertia error and offset in between."""
        base = self._all(x)
        steps = np.where(np.array(moved) == 0, -_STEP, _STEP)  # f_c goes down: without a Stribeck peak it is f_s
        models = self._model(np.stack([base + step * np.eye(6)[i] for i, step in zip(moved, steps, strict=True)]))
        by_logs = -(models - self._at(base)).T / steps
        return np.column_stack([by_logs[:, :2], -self._inertia, -np.ones_like(self._inertia), by_logs[:, 2:]])

    def starts(self, rng: np.random.Generator) -> list[Array]:
        """The best of random starts."""
        x = np.zeros((_STARTS, 4))
        x[:, :2] = rng.uniform(self.low[:2], self.high[:2], size=(_STARTS, 2))
        errors = self._friction - self._model(np.stack([self._all(row) for row in x]))
        best = np.argsort(np.sum(errors**2, axis=1))[:_REFINED]
        return list(x[best])

    def refined(self, start: Array) -> "scipy.optimize.OptimizeResult":
        """Least squares from one start."""
        start = np.clip(start, self.low, self.high)
        return scipy.optimize.least_squares(
            self.residual, start, self.jacobian, bounds=(self.low, self.high), x_scale=[1.0, 1.0, 0.01, 0.01], xtol=1e-5
        )


def _resampled(problem: _Problem, x: Array, static_resampled: Array, rng: np.random.Generator) -> Array:
    """sigma_0, sigma_1 of resampled blocks, one Gauss-Newton step from the estimate each."""
    slopes, errors = problem.with_static(x), problem.residual(x)
    own, static = slopes[:, :4], slopes[:, 4:]
    blocks = problem.data.blocks(BLOCK)
    curvature = blocks.sums(np.einsum("si,sj->sij", own, own))
    pull = blocks.sums(own * errors[:, None])
    cross = blocks.sums(np.einsum("si,sj->sij", own, static))
    found = np.empty((len(static_resampled), 2))
    ratio = np.divide(static_resampled, problem.static, out=np.ones_like(static_resampled), where=problem.static > 0)
    for row, moved in zip(found, np.log(np.maximum(ratio, _LEAST_RATIO)), strict=True):
        counts = blocks.draw(rng)
        h, g, c = (np.tensordot(counts, part, axes=1) for part in (curvature, pull, cross))
        row[:] = x[:2] - np.linalg.solve(h, g + c @ moved)[:2]
    return np.exp(found)
