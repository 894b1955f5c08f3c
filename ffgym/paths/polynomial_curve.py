"""Curves that are polynomials of a parameter, measured by arc length: corner blends and splines through points."""

import itertools
from dataclasses import dataclass
from functools import cached_property
from typing import Any, final

import numpy as np
from scipy.interpolate import BPoly, CubicSpline, PPoly
from scipy.optimize import minimize_scalar

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.paths.curves import Curve, Derivatives

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)
_PIECES = 16
"""Pieces of each polynomial between which arc length is tabled; with 12 nodes each its error is below 1e-12."""
_STEPS = 12
"""Newton steps from arc length to parameter at most: 3 or 4 are enough, the rest are for very uneven speed."""
_MISS = 1e-9
"""Error of arc length, as a share of the whole, after which one more Newton step, which squares it, leaves rounding."""


CUSP = 0.01
"""Speed by its parameter, which is 1 on average, below which a spline counts as turning on the spot."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class PolynomialCurve(Curve):
    """Piecewise polynomial curve, twice continuously differentiable, whose speed by its parameter is nowhere zero."""

    polynomial: PPoly
    """Position as a function of any parameter u, shape (D,)."""

    @cached_property
    def _slopes(self) -> tuple[PPoly, PPoly, PPoly]:
        return self.polynomial.derivative(1), self.polynomial.derivative(2), self.polynomial.derivative(3)

    @cached_property
    def _table(self) -> tuple[Array, Array]:
        """Parameters and the arc lengths that lead to them."""
        ends = self.polynomial.x
        u = np.concatenate([np.linspace(a, b, _PIECES, endpoint=False) for a, b in itertools.pairwise(ends)])
        u = np.append(u, ends[-1])
        return u, np.concatenate([[0.0], np.cumsum(self._length_between(u[:-1], u[1:]))])

    def _length_between(self, start: Array, end: Array) -> Array:
        """Arc length from `start` to `end`, parameters of shape (T,) within one polynomial each."""
        half = 0.5 * (end - start)
        u = (0.5 * (start + end))[:, None] + half[:, None] * _NODES
        speed = np.linalg.norm(self._slopes[0](u), axis=-1)
        return half * (speed * _WEIGHTS).sum(axis=1)

    @property
    def length(self) -> float:
        """Arc length of the whole."""
        return float(self._table[1][-1])

    @property
    def knots(self) -> Array:
        """Arc lengths at which one polynomial ends and the next begins, with both ends."""
        return self._table[1][::_PIECES]

    def _parameter(self, s: Array) -> Array:
        """Parameter u at arc lengths `s`: from the table, then by Newton's method within the piece."""
        u_table, s_table = self._table
        piece = np.clip(np.searchsorted(s_table, s, side="right") - 1, 0, len(u_table) - 2)
        low, high = u_table[piece], u_table[piece + 1]
        start = s_table[piece]
        u = low + (high - low) * (s - start) / (s_table[piece + 1] - start)
        done = np.zeros(len(u), dtype=np.bool_)  # row by row, so that no row's bits depend on its neighbours
        for _ in range(_STEPS):
            miss = self._length_between(low, u) - (s - start)
            step = miss / np.linalg.norm(self._slopes[0](u), axis=-1)
            u = np.where(done, u, np.clip(u - step, low, high))
            done |= np.abs(miss) <= _MISS * s_table[-1]
            if done.all():
                break
        return u

    def at(self, s: Array) -> Derivatives:
        """Position and derivatives by arc length, by the chain rule."""
        u = self._parameter(np.asarray(s, dtype=np.float64))
        first, second, third = (slope(u) for slope in self._slopes)
        speed = np.linalg.norm(first, axis=1)
        rate = (first * second).sum(axis=1) / speed
        change = ((second * second).sum(axis=1) + (first * third).sum(axis=1) - rate**2) / speed
        u1, u2, u3 = 1 / speed, -rate / speed**3, (3 * rate**2 - change * speed) / speed**5
        u1, u2, u3 = u1[:, None], u2[:, None], u3[:, None]
        return (
            self.polynomial(u),
            first * u1,
            second * u1**2 + first * u2,
            third * u1**3 + 3 * second * u1 * u2 + first * u3,
        )


def blend(before: Curve, after: Curve) -> PolynomialCurve:
    """Quintic from the end of one curve to the start of another that meets both in tangent and curvature.

    The parameter's speed at both ends is the length of the chord: it keeps the curvature of a right-angled corner
    within 4 % of the least that a quintic can have, and shrinks for sharp corners, where a longer one would bulge.
    """
    p0, t0, n0, _ = (part[0] for part in before.at(np.array([before.length])))
    p1, t1, n1, _ = (part[0] for part in after.at(np.array([0.0])))
    chord = float(np.linalg.norm(p1 - p0))
    quintic = BPoly.from_derivatives([0.0, 1.0], [[p0, chord * t0, chord**2 * n0], [p1, chord * t1, chord**2 * n1]])
    return PolynomialCurve(polynomial=PPoly.from_bernstein_basis(quintic))


def spline_through(points: Array, *, closed: bool = False) -> PolynomialCurve:
    """Cubic spline through points (K, D), K >= 2, that is continuous in tangent and curvature.

    The parameter is the chord length. At the ends the curvature is zero; a closed spline joins itself smoothly.

    Raises:
        FFGymError: if neighbouring points coincide, or a closed spline does not end where it starts.
    """
    chords = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if len(points) < 2 or np.any(chords <= 0):
        same = int(np.argmin(chords)) + 2 if len(points) > 1 else 1
        raise FFGymError(f"A spline needs two or more points, each apart from the one before; see point {same}.")
    if closed and len(points) < 4:
        raise FFGymError(f"A closed spline needs at least 4 points, the last equal to the first, got {len(points)}.")
    if closed and not np.allclose(points[0], points[-1], rtol=0, atol=1e-9):
        raise FFGymError("A closed spline must end at its first point.")
    u = np.concatenate([[0.0], np.cumsum(chords)])
    if closed:
        points = np.vstack([points[:-1], points[:1]])
    spline = CubicSpline(u, points, bc_type="periodic" if closed else "natural")
    _check_cusp(spline)
    return PolynomialCurve(polynomial=spline)


def _check_cusp(spline: CubicSpline[Any]) -> None:
    """Check that the spline nowhere turns on the spot, where it would have no direction."""
    slope = spline.derivative()
    u = np.concatenate([np.linspace(a, b, _PIECES, endpoint=False) for a, b in itertools.pairwise(spline.x)])
    slowest = int(np.argmin(np.linalg.norm(slope(u), axis=1)))
    around = u[max(slowest - 1, 0)], u[min(slowest + 1, len(u) - 1)]
    found = minimize_scalar(lambda x: float(np.linalg.norm(slope(x))), bounds=around, method="bounded")
    if found.fun < CUSP:
        point = int(np.argmin(np.abs(spline.x - found.x))) + 1
        raise FFGymError(
            f"The spline turns back on the spot near point {point}; end it there, or move the point aside."
        )
