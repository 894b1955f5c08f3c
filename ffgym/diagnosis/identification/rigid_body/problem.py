"""The weighted least squares of all motors, as sums over blocks, and how firmly the description is held."""

from dataclasses import dataclass, replace

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.diagnosis.identification.rigid_body.coordinates import Coordinates, coordinates_of
from ffgym.diagnosis.identification.rigid_body.observation import Equations, rms_counting

_WEIGHTINGS = 3
"""Times that the weights are computed anew from what is left; the third changes them by less than a percent."""

LOOSE = 10.0
"""Spread with which the errors are found that the weights are of: the data alone, where they say anything."""

_LEAST_NOISE = 1e-6
"""Smallest error of a motor's equations against its torque: noise-free data have none, which no weight could be of."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Problem:
    r"""Weighted equations in coordinates y, as what is left of the rows of each block b in units of `noise`.

    .. math:: y^T A_b y - 2 b_b^T y + c_b
    """

    coordinates: Coordinates
    noise: Array
    """RMS error of each motor's equations [N m], shape (N,); the weights are its inverses."""
    normal: Array
    """A_b, shape (n_blocks, K, K)."""
    right: Array
    """b_b, shape (n_blocks, K)."""
    square: Array
    """c_b, shape (n_blocks,)."""
    rows: int
    """Equations that count, of all motors and blocks."""

    def solve(self, counts: Array, spread: float, reference: Array | None = None) -> Array:
        """The best coordinates (K,), with each block counted as often as `counts` (n_blocks,) says.

        Those that are held are near a `reference` (K,), None is the description, with `spread` as standard deviation.
        """
        reference = self.coordinates.reference if reference is None else reference
        prior = self.coordinates.spreads(spread) ** -2.0
        normal = np.tensordot(counts, self.normal, axes=1) + np.diag(prior)
        return self.coordinates.solve(normal, counts @ self.right + prior * reference)

    def losses(self, y: Array) -> Array:
        """Squared error of the rows of each block, in units of the noise, shape (n_blocks,)."""
        return np.einsum("bkl,k,l->b", self.normal, y, y) - 2 * self.right @ y + self.square

    def shares(self, spread: float) -> Array:
        """Compute the share of the data in each coordinate, from 0, all the reference, to 1, all the data; shape (K,).

        It is the diagonal of the resolution matrix (A + P)^-1 A, with P the inverse squared spreads.
        """
        normal = self.normal.sum(axis=0)
        prior = np.diag(self.coordinates.spreads(spread) ** -2.0)
        return np.diag(np.linalg.solve(normal + prior, normal)).copy()

    def shares_of(self, combination: Array, spread: float) -> Array:
        """Compute the share of the data in combinations of parameters, (B, K): the variance that they take away."""
        normal, prior = self.normal.sum(axis=0), self.coordinates.spreads(spread) ** 2.0
        rows = combination @ self.coordinates.to_parameters
        left = np.linalg.inv(normal + np.diag(1 / prior))
        shares: Array = 1 - np.einsum("bk,kl,bl->b", rows, left, rows) / (rows**2 @ prior)
        return shares

    def only(self, kept: BoolArray) -> "Problem":
        """The problem for some coordinates, `kept` (K,); the others stay at the reference."""
        if kept.all():
            return self
        out = ~kept
        fixed = self.coordinates.reference[out]
        given = self.normal[:, :, out] @ fixed
        return replace(
            self,
            coordinates=self.coordinates.only(kept),
            normal=self.normal[:, kept][:, :, kept],
            right=(self.right - given)[:, kept],
            square=self.square - 2 * self.right[:, out] @ fixed + given[:, out] @ fixed,
        )


def problem_of(equations: Equations) -> Problem:
    """Weight the equations of each motor by the inverse of what they leave."""
    counts = equations.counts
    if not counts.any():
        raise FFGymError(
            "No motor moves fast enough for long enough to tell anything: record a motion, or lower `moving`."
        )
    silent = rms_counting(equations.measured, counts) == 0.0
    if silent.any():
        names = ", ".join(equations.robot.joints[j] for j in np.flatnonzero(silent))
        raise FFGymError(
            f"motor.effort of {names} is 0 wherever it moves, which tells nothing: map the column with its torque."
        )
    torque = np.nan_to_num(rms_counting(equations.torque, counts))
    size = np.where(torque > 0, torque, 1.0)
    # each parameter in units of what alone would make the torque of the motor on which it acts most, 1 if on none
    columns = np.where(counts[:, None], equations.columns, 0.0)
    action = np.sqrt((columns**2).sum(axis=0) / np.maximum(counts.sum(axis=0), 1))
    strongest = (action / size).max(axis=1)
    scales = np.where(strongest > 0, 1 / np.where(strongest > 0, strongest, 1.0), 1.0)
    coordinates = coordinates_of(equations.robot, equations.terms, scales)
    # weights from what is left, again and again
    noise = size
    for _ in range(_WEIGHTINGS):
        problem = _sum(equations, coordinates, noise)
        y = problem.solve(np.ones(equations.blocks.n_blocks), LOOSE)
        left = np.nan_to_num(rms_counting(equations.residual(coordinates.parameters(y)), counts))
        noise = np.maximum(left, np.where(torque > 0, _LEAST_NOISE * torque, 1.0))
    return _sum(equations, coordinates, noise)


def _sum(equations: Equations, coordinates: Coordinates, noise: Array) -> Problem:
    """Sums over the rows of each block with these weights."""
    blocks, k = equations.blocks, coordinates.n
    normal, right = np.zeros((blocks.n_blocks, k, k)), np.zeros((blocks.n_blocks, k))
    square = np.zeros(blocks.n_blocks)
    for motor, sigma in enumerate(noise):
        rows = np.flatnonzero(equations.counts[:, motor])
        columns = equations.columns[rows, :, motor] @ coordinates.to_parameters / sigma
        torque = equations.torque[rows, motor] / sigma
        for block in np.unique(blocks.of_row[rows]):
            own = blocks.of_row[rows] == block
            normal[block] += columns[own].T @ columns[own]
            right[block] += columns[own].T @ torque[own]
            square[block] += torque[own] @ torque[own]
    return Problem(
        coordinates=coordinates,
        noise=noise,
        normal=normal,
        right=right,
        square=square,
        rows=int(equations.counts.sum()),
    )


SPREADS = (0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0)
"""What is tried: from a description that is as good as a drawing to one that is a rule of thumb."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TradeOff:
    """Prediction of held-out rows by how firmly parameters were held."""

    spreads: Array
    """Relative standard deviations that were tried, shape (S,)."""
    errors: Array
    """RMS error of held-out rows in units of the motors' noise, shape (S,)."""
    chosen: float
    """The smallest spread that predicts as well as the best, within one standard error."""


def choose_spread(problem: Problem, folds: IntArray, spreads: tuple[float, ...] = SPREADS) -> TradeOff:
    """Choose by cross-validation: each of the `folds` (n_blocks,) of blocks is predicted from the others.

    The description is left only for a reason: of all spreads whose loss exceeds the least by no more than one standard
    error of their difference over the blocks, the smallest is taken.

    Reference:
        Hastie, Tibshirani, Friedman (2009), The Elements of Statistical Learning, 7.10 (one-standard-error rule).
    """
    if len(np.unique(folds)) < 2:
        raise FFGymError("There is one block of rows only, so nothing can be held out: record for longer.")
    losses = np.zeros((len(spreads), len(folds)))
    for left, spread in zip(losses, spreads, strict=True):
        for fold in np.unique(folds):
            own = folds == fold
            left[own] = problem.losses(problem.solve((~own).astype(np.float64), spread))[own]
    total = losses.sum(axis=1)
    excess = losses - losses[np.argmin(total)]
    tie = excess.sum(axis=1) <= excess.std(axis=1, ddof=1) * np.sqrt(losses.shape[1])
    return TradeOff(
        spreads=np.array(spreads), errors=np.sqrt(total / problem.rows), chosen=float(spreads[int(np.argmax(tie))])
    )
