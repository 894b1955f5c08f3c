r"""Coordinates relative to a reference, bodies by their pseudo-inertia, and least squares over bodies that exist.

A body with pseudo-inertia J and reference :math:`J_0 = C C^T` has the ten entries of the symmetric matrix
:math:`Z = C^{-1} J C^{-T}`, which is 1 at the reference. Off-diagonal entries count :math:`\sqrt 2`, so that the
squared distance to the reference is :math:`\| C^{-1} (J - J_0) C^{-T} \|_F^2`: it has no unit, does not depend on the
frame of the body, and agrees to second order with the distance along geodesics of positive definite matrices. J is that
of a body if and only if Z is positive definite.

Reference:
    Lee, Wensing, Park (2020), IEEE Transactions on Robotics 36(3), 837-852, eq. (24): constant pullback of the metric.

.. math:: \min_y \; y^T A y - 2 b^T y \quad \text{with} \quad Z_i(y) \succeq \epsilon 1, \; y_j \ge l_j

with a linear matrix inequality for each body. It is a convex problem with one minimum, solved by Clarabel through
CVXPY. Where least squares alone gives such parameters, they are the answer and no solver is called.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy

from ffgym.core.errors import FFGymError
from ffgym.core.provenance import is_installed
from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.diagnosis.identification.rigid_body.bodies import pseudo_inertia
from ffgym.diagnosis.identification.rigid_body.terms import BODIES, Term, per_parameter
from ffgym.robot import RobotDescription

THINNEST = 0.01
"""Least second moment of a reference body against its largest, in any direction: descriptions have flat plates and
rods, which are at the edge of what is a body, and would be held there."""

UPPER = np.triu_indices(4)
"""Rows and columns of the ten entries of a symmetric matrix (4, 4), as coordinates hold them."""

WEIGHTS = np.where(UPPER[0] == UPPER[1], 1.0, np.sqrt(2.0))
"""What each of them counts."""

LEAST = 1e-3
"""Smallest eigenvalue of Z, that is how thin a body may become against its reference: above 0, so that the description
that is written is one of bodies."""

_TOLERANCE = 1e-7
"""Of the solver, for the objective and relative to it, and for constraints: far below noise and LEAST."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Coordinates:
    """Affine map between parameters x (K,) in their units and coordinates y (K,) without unit."""

    to_parameters: Array
    """x = T y, shape (K, K)."""
    reference: Array
    """y of the description, shape (K,)."""
    is_held: BoolArray
    """Whether a coordinate is held near the reference as firmly as is chosen, or only so that it is determined at all,
    shape (K,)."""
    bodies: tuple[IntArray, ...]
    """Coordinates of each body, ten each: upper triangle of Z row by row."""
    least: Array
    """Smallest value of each coordinate, shape (K,)."""

    @property
    def n(self) -> int:
        """Number of parameters K."""
        return len(self.reference)

    def only(self, kept: BoolArray) -> "Coordinates":
        """Some of the coordinates, `kept` (K,); those of a body stay together."""
        index = np.cumsum(kept) - 1
        return Coordinates(
            to_parameters=self.to_parameters[np.ix_(kept, kept)],
            reference=self.reference[kept],
            is_held=self.is_held[kept],
            least=self.least[kept],
            bodies=tuple(index[body] for body in self.bodies),
        )

    def parameters(self, y: Array) -> Array:
        """Parameters (..., K) of coordinates (..., K)."""
        return y @ self.to_parameters.T

    def spreads(self, spread: float) -> Array:
        """Give each coordinate its spread about the reference, shape (K,), held ones the given `spread`."""
        return np.where(self.is_held, spread, 1.0)

    def least_eigenvalue(self, y: Array) -> float:
        """Smallest eigenvalue of Z over all bodies; infinite if there are none."""
        return min((float(np.linalg.eigvalsh(_symmetric(y[body]))[0]) for body in self.bodies), default=np.inf)

    def solve(self, normal: Array, right: Array) -> Array:
        """Minimise y^T A y - 2 b^T y over bodies that exist, with `normal` A (K, K) and `right` b (K,)."""
        try:
            y: Array = scipy.linalg.cho_solve(scipy.linalg.cho_factor(normal), right)
        except np.linalg.LinAlgError as error:
            raise FFGymError(
                "The equations are singular in floating point: description and recordings differ by too many powers of "
                "ten. Check masses, rotors, gear ratios and the unit of the torque."
            ) from error
        if np.all(y >= self.least) and self.least_eigenvalue(y) >= LEAST:
            return y
        return self._constrain(y, normal)

    def _constrain(self, best: Array, normal: Array) -> Array:
        """The allowed coordinates nearest to the `best` ones, in the metric of the data.

        The unknowns are whitened, w = R (y - best) / s with R^T R = A, so that the objective is |w|^2 whatever the
        data, and s such that it is 1 at the reference, which is allowed: at the optimum it is less.
        """
        problem, y, centre, whitened = self._problem
        root = np.linalg.cholesky(normal).T
        size = np.linalg.norm(root @ (self.reference - best))
        centre.value = best
        whitened.value = size * scipy.linalg.solve_triangular(root, np.eye(self.n))
        problem.solve(solver="CLARABEL", tol_gap_rel=_TOLERANCE, tol_gap_abs=_TOLERANCE, tol_feas=_TOLERANCE)
        if problem.status not in ("optimal", "optimal_inaccurate"):
            raise FFGymError(
                f"No parameters of a machine were found that fit ({problem.status}): is the recording of this robot?"
            )
        return np.asarray(y.value, dtype=np.float64)

    @cached_property
    def _problem(self) -> tuple[Any, Any, Any, Any]:
        """Problem, unknowns, and the two parameters that data fill in: built once, since that takes longest."""
        if not is_installed("cvxpy"):
            raise FFGymError(
                "Least squares leave bodies that cannot exist, and those that can are found with cvxpy; "
                "pip install 'ffgym[identify]'."
            )
        import cvxpy as cp
        from cvxpy.atoms.affine.binary_operators import multiply
        from cvxpy.atoms.sum_squares import sum_squares

        unknown, centre, whitened = cp.Variable(self.n), cp.Parameter(self.n), cp.Parameter((self.n, self.n))
        y = centre + whitened @ unknown
        bounded = np.flatnonzero(np.isfinite(self.least))
        limits = [y[bounded] >= self.least[bounded]] if len(bounded) else []
        for body in self.bodies:
            z = cp.Variable((4, 4), symmetric=True)
            limits += [multiply(WEIGHTS, z[UPPER]) == y[body], z >> LEAST * np.eye(4)]
        return cp.Problem(cp.Minimize(sum_squares(unknown)), limits), y, centre, whitened


def coordinates_of(robot: RobotDescription, terms: tuple[Term, ...], scales: Array) -> Coordinates:
    """Coordinates for the parameters of `terms`; `scales` (K,) are the sizes of those that are not held."""
    maps, reference, bodies, start = [], [], [], 0
    for term in terms:
        described = term.described(robot)
        own = np.arange(start, start + len(described))
        if term is BODIES:
            maps += [_body_map(body) for body in described.reshape(-1, 10)]
            bodies += list(own.reshape(-1, 10))
            reference.append(np.tile(_IDENTITY, len(described) // 10))
        else:
            sizes = described if term.is_held else scales[own]
            maps.append(np.diag(sizes))
            reference.append(described / sizes)
        start += len(described)
    return Coordinates(
        to_parameters=scipy.linalg.block_diag(*maps),
        reference=np.concatenate(reference),
        is_held=per_parameter(robot, terms, lambda term: term.is_held),
        least=per_parameter(robot, terms, lambda term: term.least),
        bodies=tuple(bodies),
    )


def _body_map(own: Array) -> Array:
    """Matrix (10, 10) from the entries of Z to the parameters of a body, with the body `own` (10,) as reference."""
    basis = np.array([_entries(m) for m in pseudo_inertia(np.eye(10))]).T  # entries of J of each parameter
    # thicken the reference where it is thinner than THINNEST; mass and centre stay
    pseudo = pseudo_inertia(own)
    mass, moment = pseudo[3, 3], pseudo[:3, 3]
    second, axes = np.linalg.eigh(pseudo[:3, :3] - np.outer(moment, moment) / mass)
    pseudo[:3, :3] += (axes * (np.maximum(second, THINNEST * second[2]) - second)) @ axes.T
    root = np.linalg.cholesky(pseudo)
    spread = np.array([_entries(root @ _symmetric(unit) @ root.T) for unit in np.eye(10)]).T
    return np.linalg.solve(basis, spread)


def _entries(symmetric: Array) -> Array:
    """The ten entries of a symmetric matrix (4, 4), off-diagonal ones times the square root of 2."""
    return symmetric[UPPER] * WEIGHTS


def _symmetric(entries: Array) -> Array:
    """Symmetric matrix (4, 4) of its ten entries."""
    matrix = np.zeros((4, 4))
    matrix[UPPER] = entries / WEIGHTS
    return matrix + np.triu(matrix, 1).T


_IDENTITY = _entries(np.eye(4))
