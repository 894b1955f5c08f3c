r"""B-spline networks over speed and position: the tensor product of thesis (3.12).

.. math:: u_{lff} = \sum_h \sum_s w_{hs} \, \nu_h(x) \, \mu_s(v), \qquad x = (q - q_{low}) / (q_{high} - q_{low})

mu are the splines over motor speed of `ffgym.agents.bspline`, nu splines over the joint's position q, link side, with
knots of their own. It can learn what no sum of a curve over speed and a curve over position can: friction that changes
with the position of the gearbox, or the loop that friction makes on one circle. It has as many weights as the product
of both numbers of splines, and each has to be met: thesis 3.2.2 calls it the curse of dimensionality.

Run it:

    ffgym train bspline --network tensor --position-knots 9 --out tensor.npz
    ffgym demo --agents none bsn_extended tensor.npz

Logged while learning: mean squares of motor error and learning signal per joint, see `ffgym.agents.lffc`.

Departures from the source: the thesis states (3.12) and uses networks of one input only, so that numbers are chosen
here: 9 position knots, evenly over the range of each joint on the motions of the training, order as over speed.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Self, final

import numpy as np

from ffgym.agents.bspline import BSplineNetwork
from ffgym.agents.spline_basis import SplineBasis
from ffgym.core.errors import FFGymError, check_shape, check_whole
from ffgym.core.types import Array, IntArray
from ffgym.paths import Reference

POSITION_KNOTS = 9
"""Knots over the range of a joint. Chosen; docs/agents/bspline.md compares it with 5 and 17."""


def even_positions(n_knots: int = POSITION_KNOTS, order: int = 2) -> SplineBasis:
    """Make splines over the share of a joint's range, with `n_knots` evenly from 0 to 1."""
    return SplineBasis(knots=np.linspace(0, 1, check_whole("position knots", n_knots, low=2)), order=order)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TensorBSN(BSplineNetwork):
    """One network per motor over reference speed and joint position; `coefficients` has a row per position spline."""

    position_range: Array
    """Lowest and highest position of each joint [rad], link side, shape (2, N); beyond them the last torque stays."""
    positions: SplineBasis = field(default_factory=even_positions)
    """Splines over x, the share of that range."""
    name: str = "bsn_tensor"
    kind: ClassVar[str] = "bsn_tensor"
    n_networks: ClassVar[int | None] = None

    def __post_init__(self) -> None:
        super().__post_init__()
        low, high = check_shape("position_range", self.position_range, (2, self.n_joints))
        if np.any(high <= low):
            raise FFGymError(
                f"position_range = {np.asarray(self.position_range).tolist()} rad must rise on every joint; "
                f"train on motions that move all of them, or give a range of your own."
            )
        check_shape("coefficients", self.coefficients, (None, self.positions.n_splines, None))

    @classmethod
    def along(
        cls,
        references: Sequence[Reference],
        basis: SplineBasis | None = None,
        positions: SplineBasis | None = None,
        **fields: Any,
    ) -> Self:
        """Return a network with zero weights, whose position splines cover the range of `references`.

        Raises:
            FFGymError: if there is no reference, or a joint does not move.
        """
        if not references:
            raise FFGymError("There is no motion to cover; give one or more references.")
        q = np.concatenate([reference.q for reference in references])
        basis, positions = basis or SplineBasis(), positions or even_positions()
        return cls(
            coefficients=np.zeros((q.shape[1], positions.n_splines, basis.n_splines)),
            basis=basis,
            positions=positions,
            position_range=np.stack([q.min(axis=0), q.max(axis=0)]),
            **fields,
        )

    @classmethod
    def zero(cls, n_joints: int, basis: SplineBasis | None = None, **fields: Any) -> Self:
        """Return a network with zero weights, over one turn of each joint unless `position_range` is given."""
        turn = np.pi * np.array([[-1.0], [1.0]])
        basis, positions = basis or SplineBasis(), fields.pop("positions", None) or even_positions()
        return cls(
            coefficients=np.zeros((n_joints, positions.n_splines, basis.n_splines)),
            basis=basis,
            positions=positions,
            position_range=fields.pop("position_range", np.repeat(turn, n_joints, axis=1)),
            **fields,
        )

    def locate(self, q: Array) -> Array:
        """Return joint positions `q` (..., N) [rad], link side, as shares of the range of each joint."""
        low, high = self.position_range
        share: Array = (q - low) / (high - low)
        return share

    def active(self, motor_dq: Array, motor_ddq: Array, place: Array | None = None) -> tuple[Array, IntArray]:
        """Evaluate the products of splines that are not zero, one per pair; see `BSplineNetwork.active`.

        Raises:
            FFGymError: if there is no position.
        """
        if place is None:
            raise FFGymError(f"Network {self.name!r} is a function of speed and position; give positions too.")
        by_place, rows = self.positions.active(place)
        by_speed, columns = self.basis.active(motor_dq)
        values = by_place[..., :, None] * by_speed[..., None, :]
        numbers = self.basis.n_splines * rows[..., :, None] + columns[..., None, :]
        shape = (*values.shape[:-2], -1)
        return values.reshape(shape), numbers.reshape(shape)

    def parts(self) -> tuple[dict[str, Any], dict[str, Array]]:
        """Return settings and arrays of the network over speed, and those of the position."""
        settings, arrays = super().parts()
        own = {"position_range": self.position_range, "position_knots": self.positions.knots}
        return settings | {"position_order": self.positions.order}, arrays | own

    @classmethod
    def from_parts(cls, settings: Mapping[str, Any], arrays: Mapping[str, Array]) -> Self:
        """Rebuild the network from `parts`."""
        return cls(
            coefficients=arrays["coefficients"],
            basis=SplineBasis(knots=arrays["knots"], order=settings["order"]),
            normalised=settings.get("normalised", True),
            positions=SplineBasis(knots=arrays["position_knots"], order=settings["position_order"]),
            position_range=arrays["position_range"],
            **{"name": settings["name"]},
        )
