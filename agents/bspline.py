"""B-spline networks: added torque as a curve over the reference speed, learned from trials.

Idea and source: thesis 5.1 and (3.8)-(3.17); learning feed-forward control with B-splines is from Velthuis (2000).
A spline is non-zero on a few knots only, so that training at some speeds leaves the weights of all others as they are.

    static (5.1)      u_lff = sum_s w_s mu_s(v),                      v: motor speed of the reference
    extended (5.2)    u_lff = H1(v) where its acceleration is >= 0, H2(v) where it is < 0; each is a static network

`ffgym.agents.tensor_bspline` has networks over speed and position. An update is (5.5), which divides by the sum of each
spline, or the plain gradient (3.16) where `normalised` is False.

Run it:

    ffgym train bspline --network extended --out network.npz
    ffgym demo --agents none bsn_static bsn_extended network.npz

Logged while learning: mean squares of motor error and learning signal per joint, see `ffgym.agents.lffc`.

Departures from the source: the torque is the one for the next sample, at the speed and acceleration there, since the
drive reaches it then. SciPy's B-splines stand in place of the recursion (3.11), which counts the knots one too far for
the text: order j means pieces of degree j - 1. The outermost knots are repeated, so that the splines add up to one on
the whole interval, where those of (3.9)-(3.11) fade out towards its ends; beyond it the last value stays.

Thesis 5.5 finds that a network trained at 10 mm/s gains little at 40 mm/s, as weights at speeds that it never met stay
zero, and proposes first weights from a constant friction, and training over several speeds: `bsn_extended_prior`.
"""

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self, final

import numpy as np
import scipy

from ffgym.agents.coulomb_prior import CoulombPrior
from ffgym.agents.declaration import AgentEntry, declare
from ffgym.agents.lffc import Network, thesis_training
from ffgym.agents.spline_basis import SplineBasis
from ffgym.agents.trials import Lesson, Trial, friction_motions, thesis_motions
from ffgym.control import LawStyle, Window
from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.types import Array, IntArray
from ffgym.robot import RigidArm


@dataclass(frozen=True, kw_only=True, eq=False)
class BSplineNetwork(Network):
    """One or more B-spline networks per motor; members say which weights answer."""

    coefficients: Array
    """Weights w [N m], motor side, shape (N, H, S): joints, networks of a joint, splines."""
    basis: SplineBasis = field(default_factory=SplineBasis)
    normalised: bool = True
    """Division of each weight's update by the sum of its spline, thesis (3.17); without it, (3.16)."""
    n_networks: ClassVar[int | None]
    """Networks per joint H; None where an object sets them."""

    def __post_init__(self) -> None:
        shape = (None, self.n_networks, self.basis.n_splines)
        object.__setattr__(self, "coefficients", check_shape("coefficients", self.coefficients, shape))
        if self.n_joints == 0:
            raise FFGymError("coefficients are of no joint, must be of one or more.")

    @classmethod
    def zero(cls, n_joints: int, basis: SplineBasis | None = None, **fields: Any) -> Self:
        """Return a network with zero weights, which adds nothing."""
        basis = basis or SplineBasis()
        return cls(coefficients=np.zeros((n_joints, cls.n_networks or 1, basis.n_splines)), basis=basis, **fields)

    @abstractmethod
    def active(self, motor_dq: Array, motor_ddq: Array, place: Array | None = None) -> tuple[Array, IntArray]:
        """Evaluate the splines that answer: values, and places of weights among a joint's H S; (..., A) each.

        Args:
            motor_dq: motor speed [rad/s].
            motor_ddq: motor acceleration [rad/s^2].
            place: joint position as `locate` gives it; only networks over position need it.
        """

    def locate(self, q: Array) -> Array:
        """Return joint positions `q` (..., N) [rad], link side, on the axis of the position splines, if there are."""
        return q

    @property
    def n_joints(self) -> int:
        """Number of motors N."""
        return len(self.coefficients)

    @property
    def weights(self) -> dict[str, Array]:
        """Weights of the splines."""
        return {"coefficients": self.coefficients}

    def with_curve(self, curve: Callable[[Array], Array]) -> Self:
        """Return the network with weights that follow `curve`, torque [N m] over motor speed [rad/s], (..., N) each.

        A weight is the curve at the centre of its spline: exact at the knots for hats, smoothed for higher orders.
        """
        speeds = np.repeat(self.basis.centres[:, None], self.n_joints, axis=1)
        return replace(self, coefficients=np.broadcast_to(curve(speeds).T[:, None], self.coefficients.shape).copy())

    def step(self, memory: Array, window: Window) -> tuple[Array, Array]:
        """Return the torque of the next sample; the network has no memory."""
        dq, ddq, q = window.motor_dq[..., 1, :], window.motor_ddq[..., 1, :], window.q[..., 1, :]
        return self.torque_at(dq, ddq, q), memory

    def torque_at(self, motor_dq: Array, motor_ddq: Array, q: Array | None = None) -> Array:
        """Compute the torque [N m] at a motion of the motors, all of shape (..., N).

        Args:
            motor_dq: motor speed [rad/s].
            motor_ddq: motor acceleration [rad/s^2].
            q: joint position [rad], link side; only networks over position need it.

        Raises:
            FFGymError: if the network needs a position and there is none.
        """
        values, places = self.active(motor_dq, motor_ddq, None if q is None else self.locate(q))
        flat = self.coefficients.reshape(self.n_joints, -1)
        weights = np.take_along_axis(np.broadcast_to(flat, (*places.shape[:-1], flat.shape[-1])), places, axis=-1)
        return np.asarray((values * weights).sum(axis=-1))

    def design_matrix(self, motor_dq: Array, motor_ddq: Array, place: Array | None = None) -> "scipy.sparse.csr_array":
        """Return splines along a motion of one joint, (T, H S): torque = matrix @ weights of the joint in one row."""
        values, places = self.active(motor_dq, motor_ddq, place)
        ends = np.arange(len(motor_dq) + 1) * values.shape[-1]
        shape = (len(motor_dq), self.coefficients[0].size)
        return scipy.sparse.csr_array((values.ravel(), places.ravel(), ends), shape=shape)

    def adapt(self, lessons: Sequence[Lesson], rate: float) -> Self:
        r"""Return the network after the offline update of thesis (5.5), with the sums over all lessons.

        .. math:: \Delta w_s = \gamma \sum_k z(k) \mu_s(v(k)) \, / \sum_k \mu_s(v(k))

        Without the denominator where the network is not `normalised`, thesis (3.16). Standstill does not count, and a
        spline that saw no data keeps its weight.
        """
        # numerator and denominator of (5.5), summed over lessons
        missing = np.zeros((self.n_joints, self.coefficients[0].size))
        seen = np.zeros_like(missing)
        for lesson in lessons:
            rows, places = lesson.moving, self.locate(lesson.q)
            for joint in range(self.n_joints):
                at = lesson.motor_dq[rows, joint], lesson.motor_ddq[rows, joint], places[rows, joint]
                splines = self.design_matrix(*at)
                missing[joint] += splines.T @ lesson.signal[rows, joint]
                seen[joint] += splines.sum(axis=0)
        step = np.divide(missing, seen, out=np.zeros_like(missing), where=seen > 0) if self.normalised else missing
        return replace(self, coefficients=self.coefficients + rate * step.reshape(self.coefficients.shape))

    def parts(self) -> tuple[dict[str, Any], dict[str, Array]]:
        """Return name, order and the kind of update, if it is not the usual one, and arrays of weights and knots."""
        return (
            {"name": self.name, "order": self.basis.order} | ({} if self.normalised else {"normalised": False}),
            {"coefficients": self.coefficients, "knots": self.basis.knots},
        )

    @classmethod
    def from_parts(cls, settings: Mapping[str, Any], arrays: Mapping[str, Array]) -> Self:
        """Rebuild the network from `parts`."""
        fields = {"name": settings["name"], "normalised": settings.get("normalised", True)}
        basis = SplineBasis(knots=arrays["knots"], order=settings["order"])
        return cls(coefficients=arrays["coefficients"], basis=basis, **fields)


class SwitchedBSN(BSplineNetwork):
    """B-spline networks over speed, of which the acceleration selects one."""

    @abstractmethod
    def select_network(self, motor_ddq: Array) -> IntArray:
        """Number of the network of a joint that answers at motor acceleration `motor_ddq` [rad/s^2]; same shape."""

    def active(self, motor_dq: Array, motor_ddq: Array, place: Array | None = None) -> tuple[Array, IntArray]:
        """Evaluate the splines of the network that answers, (..., order) each; see `BSplineNetwork.active`."""
        values, splines = self.basis.active(motor_dq)
        return values, splines + self.basis.n_splines * self.select_network(motor_ddq)[..., None]


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class StaticBSN(SwitchedBSN):
    """One network per motor over the reference speed, thesis (5.1)."""

    name: str = "bsn_static"
    kind: ClassVar[str] = "bsn_static"
    n_networks: ClassVar[int | None] = 1

    def select_network(self, motor_ddq: Array) -> IntArray:
        """Return 0: a motor has one network."""
        return np.zeros(motor_ddq.shape, dtype=np.int64)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ExtendedBSN(SwitchedBSN):
    """Two networks per motor, thesis (5.2): H1 while the reference speeds up or keeps its speed, H2 for the rest.

    "Speeds up" goes by the sign of the acceleration, not of speed times acceleration, as in the thesis.
    """

    name: str = "bsn_extended"
    kind: ClassVar[str] = "bsn_extended"
    n_networks: ClassVar[int | None] = 2

    def select_network(self, motor_ddq: Array) -> IntArray:
        """Return 0 (H1) where the acceleration is >= 0, 1 (H2) where it is < 0."""
        return (motor_ddq < 0).astype(np.int64)


def train_as_in_thesis(kind: type[BSplineNetwork], arm: RigidArm, trial: Trial) -> Network:
    """Train from zero weights on the one motion of the thesis: p1 at 10 mm/s, or the sine of 1 Hz."""
    n = arm.robot.n_joints
    return thesis_training(n).learn(kind.zero(n), thesis_motions(arm), trial).best


def train_with_prior(arm: RigidArm, trial: Trial, name: str) -> Network:
    """Train an extended network on motions of two speeds, from a Coulomb torque that one more trial estimates.

    The estimate is made on the slow motion of the thesis, where viscous friction and inertia are least.
    """
    n = arm.robot.n_joints
    prior = CoulombPrior.from_trial(thesis_motions(arm), trial)
    first = ExtendedBSN.zero(n, name=name).with_curve(prior.torque_at)
    return thesis_training(n).learn(first, friction_motions(arm), trial).best


declare(
    AgentEntry(
        name="bsn_static",
        title="static B-spline network",
        about="One B-spline network over speed per motor, learned from the feedback as in the thesis.",
        track="causal",
        order=4,
        page="bspline.md",
        style=LawStyle(label="static B-spline network", colour="#CC79A7", marker="D"),
        make=lambda setting: train_as_in_thesis(StaticBSN, setting.arm, setting.trial),
        learns=True,
    ),
    AgentEntry(
        name="bsn_extended",
        title="extended B-spline network",
        about="Two B-spline networks per motor, for speeding up and for slowing down, as in the thesis.",
        track="causal",
        order=5,
        page="bspline.md",
        style=LawStyle(label="extended B-spline network", colour="#E69F00", marker="v"),
        make=lambda setting: train_as_in_thesis(ExtendedBSN, setting.arm, setting.trial),
        learns=True,
    ),
    AgentEntry(
        name="bsn_extended_prior",
        title="extended B-spline network with prior",
        about="The extended network, begun from an estimated Coulomb torque and learned at two speeds.",
        track="causal",
        order=6,
        page="bspline.md",
        style=LawStyle(label="B-spline network with prior", colour="#B8860B", marker="^", line="--"),
        make=lambda setting: train_with_prior(setting.arm, setting.trial, "bsn_extended_prior"),
        learns=True,
    ),
)
