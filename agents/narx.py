r"""NARX feed-forward: friction as a small recurrent network of past speeds and its own past outputs.

Idea and source: thesis 6.2 with (6.19) and (6.20), which takes the first form from its reference [22]. Three sigmoid
neurons per motor, an offset and no linear term. With v the motor speed and y the torque, both in units of their size

    y(k) = d + sum_h c_h sigma(w_h . phi(k) + b_h),   sigma(x) = 1 / (1 + e^-x)

    (6.19)   phi(k) = [v(k), v(k-1)]        n_speeds = 2, no past output: the torque follows the speed at once
    (6.20)   phi(k) = [v(k), y(k-1)]        n_speeds = 1, one past output: remembers, and may drift

As feed-forward it is simulated on the reference speed: past outputs are its own, never measured ones. Sigmoids are
bounded, and so is the torque, |y - d| <= sum |c_h|, for any motion however long.

Run it:

    ffgym demo --agents none lugre_dynamic narx

Logged: see `agents.fitting.supervised.Supervised`. How it is fitted, and what departs from the source:
`agents.fitting.narx_fit`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self, final

import numpy as np

from agents.common.law_files import StoredLaw
from ffgym.control import CausalLaw, Window
from ffgym.errors import FFGymError, check_shape, check_whole
from ffgym.types import Array


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class NARX(CausalLaw, StoredLaw):
    """One network per motor; regressors are speeds v(k), v(k-1), ... and then past outputs y(k-1), y(k-2), ..."""

    input_weights: Array
    """w, shape (N, H, R): joints, neurons, regressors."""
    biases: Array
    """b, shape (N, H)."""
    output_weights: Array
    """c, shape (N, H)."""
    offset: Array
    """d, shape (N,)."""
    speed_scale: Array
    """Motor speed that counts as 1 [rad/s], shape (N,), > 0."""
    torque_scale: Array
    """Torque that counts as 1 [N m], motor side, shape (N,), > 0."""
    n_speeds: int
    """How many of the R regressors are speeds, 1 or more; the others are past outputs."""
    name: str = "narx"
    kind: ClassVar[str] = "narx"

    def __post_init__(self) -> None:
        n, h, r = check_shape("input_weights", self.input_weights, (None, None, None)).shape
        shapes: dict[str, tuple[int, ...]] = {
            "input_weights": (n, h, r),
            "biases": (n, h),
            "output_weights": (n, h),
            "offset": (n,),
            "speed_scale": (n,),
            "torque_scale": (n,),
        }
        for name, shape in shapes.items():
            object.__setattr__(self, name, check_shape(name, getattr(self, name), shape))
        for name in ("speed_scale", "torque_scale"):
            if np.any(getattr(self, name) <= 0):
                raise FFGymError(f"{name} = {getattr(self, name)} of law {self.name!r} must be > 0.")
        check_whole("n_speeds", self.n_speeds, low=1, high=r)

    @property
    def n_joints(self) -> int:
        """See base class."""
        return len(self.input_weights)

    @property
    def n_regressors(self) -> int:
        """Length R of phi."""
        return self.input_weights.shape[-1]

    @property
    def bound(self) -> Array:
        """Torque that is never exceeded [N m], shape (N,)."""
        return np.asarray(self.torque_scale * (np.abs(self.offset) + np.abs(self.output_weights).sum(axis=-1)))

    def initial_memory(self, window: Window) -> Array:
        """Regressors but the newest speed, shape (..., N (R - 1)): the speed at the start, outputs of zero."""
        return self.remembered(window.motor_dq[..., 0, :])

    def remembered(self, motor_dq: Array) -> Array:
        """What is remembered where `motor_dq` (..., N) [rad/s] was held without torque, shape (..., N (R - 1))."""
        past = np.zeros((*motor_dq.shape, self.n_regressors - 1))
        past[..., : self.n_speeds - 1] = (motor_dq / self.speed_scale)[..., None]
        return past.reshape(*motor_dq.shape[:-1], -1)

    def step(self, memory: Array, window: Window) -> tuple[Array, Array]:
        """See base class; remembered are the regressors but the newest speed."""
        return self.advanced(memory, window.motor_dq[..., 1, :])

    def advanced(self, memory: Array, motor_dq: Array) -> tuple[Array, Array]:
        """Torque [N m] (..., N) at the next speed [rad/s] (..., N), and what to remember, (..., N (R - 1))."""
        past = memory.reshape(*motor_dq.shape, self.n_regressors - 1)
        old_speeds, old_outputs = past[..., : self.n_speeds - 1], past[..., self.n_speeds - 1 :]
        speeds = np.concatenate([(motor_dq / self.speed_scale)[..., None], old_speeds], axis=-1)
        output = self.output(np.concatenate([speeds, old_outputs], axis=-1))
        outputs = np.concatenate([output[..., None], old_outputs], axis=-1)
        past = np.concatenate([speeds[..., :-1], outputs[..., :-1]], axis=-1)  # the oldest of each is forgotten
        return self.torque_scale * output, past.reshape(memory.shape)

    def output(self, regressors: Array) -> Array:
        """Output y (..., N) for phi (..., N, R), both in units of their scales."""
        inside = np.broadcast_to(self.biases, (*regressors.shape[:-1], self.biases.shape[-1])).copy()
        for r in range(self.n_regressors):  # elementwise: a matrix product may round by the size of the batch
            inside += self.input_weights[..., r] * regressors[..., r, None]
        return np.asarray(self.offset + (self.output_weights * sigmoid(inside)).sum(axis=-1))

    def simulated(self, motor_dq: Array) -> Array:
        """Torque [N m] along motor speeds [rad/s], both (T, N): past outputs are the network's own."""
        torque, memory = np.zeros_like(motor_dq), self.remembered(motor_dq[0])
        for k in range(1, len(motor_dq)):
            torque[k], memory = self.advanced(memory, motor_dq[k])
        return torque

    def predicted(self, motor_dq: Array, torque: Array) -> Array:
        """Torque [N m] one step ahead along motor speeds [rad/s], all (T, N): past outputs are measured `torque`."""
        return self.torque_scale * self.output(self.regressors(motor_dq, torque))

    def regressors(self, motor_dq: Array, torque: Array) -> Array:
        """Phi with measured past outputs, shape (T, N, R); before the start, the speed was held without torque."""
        v, y = motor_dq / self.speed_scale, torque / self.torque_scale
        n_outputs = self.n_regressors - self.n_speeds
        speeds = [_delayed(v, by, before=v[0]) for by in range(self.n_speeds)]
        outputs = [_delayed(y, by, before=np.zeros_like(y[0])) for by in range(1, n_outputs + 1)]
        return np.stack(speeds + outputs, axis=-1)

    def parts(self) -> tuple[dict[str, Any], dict[str, Array]]:
        """See base class."""
        names = ("input_weights", "biases", "output_weights", "offset", "speed_scale", "torque_scale")
        return {"name": self.name, "n_speeds": self.n_speeds}, {name: getattr(self, name) for name in names}

    @classmethod
    def from_parts(cls, settings: Mapping[str, Any], arrays: Mapping[str, Array]) -> Self:
        """See base class."""
        return cls(name=settings["name"], n_speeds=settings["n_speeds"], **arrays)


def sigmoid(x: Array) -> Array:
    """Thesis (3.7), as a hyperbolic tangent, which cannot overflow."""
    return np.asarray(0.5 + 0.5 * np.tanh(0.5 * x))


def _delayed(series: Array, by: int, before: Array) -> Array:
    """A series (T, N), `by` samples later, with `before` (N,) until it begins."""
    return np.concatenate([np.broadcast_to(before, (by, series.shape[1])), series[: len(series) - by]])
