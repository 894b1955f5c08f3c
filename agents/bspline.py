"""B-spline networks: added torque as a curve over the reference speed, learned from trials.

Idea and source: thesis 5.1 and (3.8)-(3.17); learning feed-forward control with B-splines is from Velthuis (2000).
A spline is non-zero on a few knots only, so that a network forgets nothing at speeds that it does not see.

    static (5.1)      u_lff = sum_s w_s mu_s(v),                      v: motor speed of the reference
    extended (5.2)    u_lff = H1(v) where its acceleration is >= 0, H2(v) where it is < 0; each is a static network

Run it:

    ffgym lffc --network extended --out network.npz
    ffgym demo --agents none bsn_static bsn_extended network.npz

Logged while learning: mean squares of motor error and learning signal per joint, see `ffgym.agents.learning.lffc`.

Departures from the source: the torque is the one for the next sample, at the speed and acceleration there, since the
drive reaches it then; outermost knots are repeated, and beyond them the last value stays
(`ffgym.agents.splines.basis`).
"""

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self, final

import numpy as np
from scipy.sparse import csr_array

from ffgym.agents.common.network import Network
from ffgym.agents.common.trials import Lesson
from ffgym.agents.splines.basis import SplineBasis
from ffgym.control import Window
from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.types import Array, IntArray


@dataclass(frozen=True, kw_only=True, eq=False)
class BSplineNetwork(Network):
    """One or more B-spline networks per motor; members say which one is in charge."""

    coefficients: Array
    """Weights w [N m], motor side, shape (N, H, S): joints, networks of a joint, splines."""
    basis: SplineBasis = field(default_factory=SplineBasis)
    n_networks: ClassVar[int]
    """Networks per joint H."""

    def __post_init__(self) -> None:
        shape = (None, self.n_networks, self.basis.n_splines)
        object.__setattr__(self, "coefficients", check_shape("coefficients", self.coefficients, shape))
        if self.n_joints == 0:
            raise FFGymError("coefficients are of no joint, must be of one or more.")

    @classmethod
    def zero(cls, n_joints: int, basis: SplineBasis | None = None, **fields: Any) -> Self:
        """A network that has learned nothing and adds nothing."""
        basis = basis or SplineBasis()
        return cls(coefficients=np.zeros((n_joints, cls.n_networks, basis.n_splines)), basis=basis, **fields)

    @abstractmethod
    def in_charge(self, motor_ddq: Array) -> IntArray:
        """Which network of a joint answers at motor acceleration `motor_ddq` [rad/s^2]; same shape."""

    @property
    def n_joints(self) -> int:
        """See base class."""
        return len(self.coefficients)

    @property
    def weights(self) -> dict[str, Array]:
        """See base class."""
        return {"coefficients": self.coefficients}

    def with_weights(self, weights: dict[str, Array]) -> Self:
        """See base class."""
        return replace(self, coefficients=weights["coefficients"])

    def filled(self, curve: Callable[[Array], Array]) -> Self:
        """The same network with weights that follow `curve`, a torque [N m] (..., N) over motor speed [rad/s] (..., N).

        A weight is the curve at the centre of its spline: exact at the knots for hats, smoothed for higher orders.
        """
        speeds = np.repeat(self.basis.centres[:, None], self.n_joints, axis=1)
        return replace(self, coefficients=np.broadcast_to(curve(speeds).T[:, None], self.coefficients.shape).copy())

    def step(self, memory: Array, window: Window) -> tuple[Array, Array]:
        """See base class; nothing is remembered."""
        return self.torque_at(window.motor_dq[..., 1, :], window.motor_ddq[..., 1, :]), memory

    def torque_at(self, motor_dq: Array, motor_ddq: Array) -> Array:
        """Torque [N m] at motor speed [rad/s] and acceleration [rad/s^2], all of shape (..., N)."""
        values, places = self.active(motor_dq, motor_ddq)
        flat = self.coefficients.reshape(self.n_joints, -1)
        return np.asarray((values * flat[np.arange(self.n_joints)[:, None], places]).sum(axis=-1))

    def active(self, motor_dq: Array, motor_ddq: Array) -> tuple[Array, IntArray]:
        """Values of the splines that answer, and where their weights stand among a joint's H S; (..., order) each."""
        values, splines = self.basis.active(motor_dq)
        return values, splines + self.basis.n_splines * self.in_charge(motor_ddq)[..., None]

    def design_matrix(self, motor_dq: Array, motor_ddq: Array) -> csr_array:
        """Splines along a motion of one joint, shape (T, H S): torque = matrix @ weights of the joint in one row."""
        values, places = self.active(motor_dq, motor_ddq)
        ends = np.arange(len(motor_dq) + 1) * self.basis.order
        shape = (len(motor_dq), self.n_networks * self.basis.n_splines)
        return csr_array((values.ravel(), places.ravel(), ends), shape=shape)

    def adapted(self, lessons: Sequence[Lesson], rate: float) -> Self:
        r"""Offline update, thesis (5.5), with the sums over all lessons.

        .. math:: \Delta w_s = \gamma \sum_k z(k) \mu_s(v(k)) \, / \sum_k \mu_s(v(k))

        Standstill does not count, and a spline that saw no data keeps its weight.
        """
        missing = np.zeros((self.n_joints, self.n_networks * self.basis.n_splines))
        seen = np.zeros_like(missing)
        for lesson in lessons:
            rows = lesson.moving
            for joint in range(self.n_joints):
                splines = self.design_matrix(lesson.motor_dq[rows, joint], lesson.motor_ddq[rows, joint])
                missing[joint] += splines.T @ lesson.signal[rows, joint]
                seen[joint] += splines.sum(axis=0)
        step = np.divide(missing, seen, out=np.zeros_like(missing), where=seen > 0)
        return replace(self, coefficients=self.coefficients + rate * step.reshape(self.coefficients.shape))

    def parts(self) -> tuple[dict[str, Any], dict[str, Array]]:
        """See base class."""
        return (
            {"name": self.name, "order": self.basis.order},
            {"coefficients": self.coefficients, "knots": self.basis.knots},
        )

    @classmethod
    def from_parts(cls, settings: Mapping[str, Any], arrays: Mapping[str, Array]) -> Self:
        """See base class."""
        basis = SplineBasis(knots=arrays["knots"], order=settings["order"])
        return cls(coefficients=arrays["coefficients"], basis=basis, **{"name": settings["name"]})


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class StaticBSN(BSplineNetwork):
    """One network per motor over the reference speed, thesis (5.1)."""

    name: str = "bsn_static"
    kind: ClassVar[str] = "bsn_static"
    n_networks: ClassVar[int] = 1

    def in_charge(self, motor_ddq: Array) -> IntArray:
        """See base class; there is one."""
        return np.zeros(motor_ddq.shape, dtype=np.int64)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ExtendedBSN(BSplineNetwork):
    """Two networks per motor, thesis (5.2): H1 while the reference speeds up or keeps its speed, H2 for the rest.

    "Speeds up" goes by the sign of the acceleration, not of speed times acceleration, as in the thesis.
    """

    name: str = "bsn_extended"
    kind: ClassVar[str] = "bsn_extended"
    n_networks: ClassVar[int] = 2

    def in_charge(self, motor_ddq: Array) -> IntArray:
        """See base class; 0 (H1) where the acceleration is >= 0, 1 (H2) where it is < 0."""
        return np.asarray(motor_ddq < 0, dtype=np.int64)
