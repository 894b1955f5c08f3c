r"""Least squares over parameters that a machine can have: bodies that exist, inertias and friction above 0.

.. math:: \min_y \; y^T A y - 2 b^T y \quad \text{with} \quad Z_i(y) \succeq \epsilon 1, \; y_j \ge l_j

with a linear matrix inequality for each body. It is a convex problem with one minimum, solved by Clarabel through
CVXPY. Where least squares alone gives such parameters, they are the answer and no solver is called.
"""

from functools import cached_property
from typing import Any

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular

from ffgym.core.errors import FFGymError
from ffgym.core.provenance import installed
from ffgym.core.types import Array
from ffgym.diagnosis.identification.rigid_body.coordinates import UPPER, WEIGHTS, Coordinates

LEAST = 1e-3
"""Smallest eigenvalue of Z, that is how thin a body may become against its reference: above 0, so that the description
that is written is one of bodies."""

_TOLERANCE = 1e-7
"""Of the solver, for the objective and relative to it, and for constraints: far below noise and LEAST."""


class ConsistentLeastSquares:
    """Solver for one set of coordinates, which is used again and again with other data."""

    def __init__(self, coordinates: Coordinates) -> None:
        self.coordinates = coordinates

    def solve(self, normal: Array, right: Array) -> Array:
        """The best coordinates y (K,).

        Args:
            normal: A, symmetric positive definite, shape (K, K).
            right: b, shape (K,).

        Raises:
            FFGymError: if the solver is missing or fails, or A is singular in floating point.
        """
        try:
            y: Array = cho_solve(cho_factor(normal), right)
        except np.linalg.LinAlgError as error:
            raise FFGymError(
                "The equations are singular in floating point: description and recordings differ by too many powers of "
                "ten. Check masses, rotors, gear ratios and the unit of the torque."
            ) from error
        if np.all(y >= self.coordinates.least) and self.coordinates.least_eigenvalue(y) >= LEAST:
            return y
        return self._constrained(y, normal)

    def _constrained(self, best: Array, normal: Array) -> Array:
        """The allowed coordinates nearest to the `best` ones, in the metric of the data.

        The unknowns are whitened, w = R (y - best) / s with R^T R = A, so that the objective is |w|^2 whatever the
        data, and s such that it is 1 at the reference, which is allowed: at the optimum it is less.
        """
        problem, y, centre, whitened = self._problem
        root = np.linalg.cholesky(normal).T
        size = np.linalg.norm(root @ (self.coordinates.reference - best))
        centre.value = best
        whitened.value = size * solve_triangular(root, np.eye(len(best)))
        problem.solve(solver="CLARABEL", tol_gap_rel=_TOLERANCE, tol_gap_abs=_TOLERANCE, tol_feas=_TOLERANCE)
        if problem.status not in ("optimal", "optimal_inaccurate"):
            raise FFGymError(
                f"No parameters of a machine were found that fit ({problem.status}): is the recording of this robot?"
            )
        return np.asarray(y.value, dtype=np.float64)

    @cached_property
    def _problem(self) -> tuple[Any, Any, Any, Any]:
        """Problem, unknowns, and the two parameters that data fill in: built once, since that takes longest."""
        if not installed("cvxpy"):
            raise FFGymError(
                "Least squares leave bodies that cannot exist, and those that can are found with cvxpy; "
                "pip install 'ffgym[identify]'."
            )
        import cvxpy as cp
        from cvxpy.atoms.affine.binary_operators import multiply
        from cvxpy.atoms.sum_squares import sum_squares

        own = self.coordinates
        unknown, centre, whitened = cp.Variable(own.n), cp.Parameter(own.n), cp.Parameter((own.n, own.n))
        y = centre + whitened @ unknown
        bounded = np.flatnonzero(np.isfinite(own.least))
        limits = [y[bounded] >= own.least[bounded]] if len(bounded) else []
        for body in own.bodies:
            z = cp.Variable((4, 4), symmetric=True)
            limits += [multiply(WEIGHTS, z[UPPER]) == y[body], z >> LEAST * np.eye(4)]
        return cp.Problem(cp.Minimize(sum_squares(unknown)), limits), y, centre, whitened
