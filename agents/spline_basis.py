"""Basis of B-splines on knots of the thesis, 5.1.1, or any others.

Departure from the source: SciPy's B-splines stand in place of the recursion (3.11), see `ffgym.agents.bspline`.
"""

from dataclasses import dataclass, field

import numpy as np
import scipy

from ffgym.core.errors import FFGymError, check_shape, check_whole
from ffgym.core.types import Array, IntArray

FINE_KNOTS = 41
"""Knots in +-FINE_RANGE, thesis 5.1.1: friction bends there."""
FINE_RANGE = 1.0
"""[rad/s], motor side, thesis 5.1.1."""
COARSE_KNOTS = 38
"""Knots outside, half of them on each side, thesis 5.1.1."""
FULL_RANGE = 20.0
"""[rad/s], motor side: the fastest motor of the circles at 100 mm/s, thesis 5.1.1."""

MOST_ORDER = 20
"""Largest order; chosen, as splines of more than a few are rounding between knots."""
_CLOSEST = 1e-12
"""Distance of knots, over their range if that is beyond 1, below which splines between them are rounding."""


def thesis_knots() -> Array:
    """Knots of thesis 5.1.1 [rad/s], motor side, shape (79,)."""
    fine = np.linspace(-FINE_RANGE, FINE_RANGE, FINE_KNOTS)
    coarse = np.linspace(FINE_RANGE, FULL_RANGE, COARSE_KNOTS // 2 + 1)[1:]
    return np.concatenate([-coarse[::-1], fine, coarse])


@dataclass(frozen=True, kw_only=True, eq=False)
class SplineBasis:
    """S B-splines of one order on one set of knots; S is the number of knots + order - 2."""

    knots: Array = field(default_factory=thesis_knots)
    """Motor speeds [rad/s], or places on the axis of another input, ascending, shape (K,)."""
    order: int = 2
    """Order j; 1 gives steps, 2 hats (thesis 5.1.1), 3 parabolas."""

    def __post_init__(self) -> None:
        knots = check_shape("knots", self.knots, (None,))
        if len(knots) < 2 or np.any(np.diff(knots) <= _CLOSEST * max(1.0, knots[-1] - knots[0])):
            raise FFGymError(
                f"knots = {knots.tolist()} must be two or more numbers, each above the last, by more than "
                f"{_CLOSEST:g}, or by that share of a range beyond 1."
            )
        object.__setattr__(self, "knots", knots)
        object.__setattr__(self, "order", check_whole("order", self.order, low=1, high=MOST_ORDER))

    @property
    def n_splines(self) -> int:
        """Number of splines S."""
        return len(self.knots) + self.order - 2

    @property
    def clamped(self) -> Array:
        """Knots with the outermost ones repeated, shape (S + order,)."""
        return np.pad(self.knots, self.order - 1, mode="edge")

    @property
    def centres(self) -> Array:
        """Speed that each spline stands for (Greville abscissa) [rad/s], shape (S,); the knots themselves for hats."""
        if self.order == 1:
            return np.asarray((self.knots[1:] + self.knots[:-1]) / 2)
        inner = self.clamped[1:-1]
        return np.lib.stride_tricks.sliding_window_view(inner, self.order - 1).mean(axis=-1)

    def active(self, motor_dq: Array) -> tuple[Array, IntArray]:
        """Evaluate the splines that are not zero at `motor_dq` [rad/s]: values and numbers, shape (..., order) each.

        Beyond the outermost knots a speed counts as that knot, so that a curve keeps its last value. Every speed is
        treated by itself, whatever stands beside it.
        """
        inside = np.clip(motor_dq, self.knots[0], self.knots[-1])
        # rows of a design matrix hold the `order` splines of their interval; 30 us for six speeds, 70 us for 64 x 6,
        # against 20 and 25 us for one BSpline object per joint, which could not be trained from
        matrix = scipy.interpolate.BSpline.design_matrix(inside.ravel(), self.clamped, self.order - 1)
        shape = (*inside.shape, self.order)
        return matrix.data.reshape(shape), matrix.indices.reshape(shape).astype(np.int64)
