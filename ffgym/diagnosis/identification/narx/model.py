"""The network itself, sigmoid neurons per motor, no linear term; what it sees, simulates and predicts."""

from dataclasses import dataclass
from typing import Any, final

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_shape
from ffgym.core.types import Array
from ffgym.diagnosis.identification.narx.regressors import Regressors
from ffgym.robot.friction import advance_slip


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class NarxModel:
    r"""Friction as a network of one hidden layer per motor, with speed and torque in units of their size.

    .. math:: y(k) = d + \sum_h c_h \sigma(w_h \cdot \varphi(k) + b_h), \quad \sigma(x) = 1 / (1 + e^{-x})

    Sigmoids are bounded, and so is the torque, |y - d| <= sum |c_h|, for any motion however long.

    Reference:
        Thesis 6.2.1, Figure 6.8, (6.19) and (6.20).
    """

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
    regressors: Regressors
    dt: float
    """Time between samples [s]; lags are counted in it, so that the network is no model at another."""

    def __post_init__(self) -> None:
        n, h, _ = check_shape("input_weights", self.input_weights, (None, None, None)).shape
        shapes: dict[str, tuple[int, ...]] = {
            "input_weights": (n, h, self.regressors.count),
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
                raise FFGymError(f"{name} = {getattr(self, name)} of a NARX network must be > 0.")
        check_number("dt", self.dt, unit="s", low=0.0, open_low=True)

    @property
    def n_joints(self) -> int:
        """Number of motors N."""
        return len(self.input_weights)

    def is_sampled_at(self, dt: float) -> bool:
        """Tell whether samples every `dt` [s] are those that the network's lags count."""
        return abs(dt - self.dt) <= 1e-9

    @property
    def bound(self) -> Array:
        """Torque that is never exceeded [N m], shape (N,)."""
        return np.asarray(self.torque_scale * (np.abs(self.offset) + np.abs(self.output_weights).sum(axis=-1)))

    def hold_memory(self, motor_dq: Array) -> Array:
        """Return the memory after `motor_dq` (..., N) [rad/s] was held without torque, shape (..., N M).

        Per motor: past speeds [rad/s], slip elements (relaxed), past outputs in units of their scale; newest first.
        """
        regressors = self.regressors
        sizes = (regressors.n_past_speeds, len(regressors.slip_widths), regressors.n_past_outputs)
        past = np.zeros((*motor_dq.shape, sum(sizes)))
        past[..., : sizes[0]] = motor_dq[..., None]
        return past.reshape(*motor_dq.shape[:-1], -1)

    def advance(self, memory: Array, motor_dq: Array) -> tuple[Array, Array]:
        """Torque [N m] (..., N) at the next speed [rad/s] (..., N), and what to remember, (..., N M)."""
        regressors = self.regressors
        parts = np.cumsum([regressors.n_past_speeds, len(regressors.slip_widths)])
        old_speeds, slip, old_outputs = np.split(memory.reshape(*motor_dq.shape, -1), parts, axis=-1)
        speeds = np.concatenate([motor_dq[..., None], old_speeds], axis=-1)
        if regressors.slip_widths:
            slip = advance_slip(slip, speeds[..., 1], motor_dq, self.dt, np.array(regressors.slip_widths))
        phi = [
            speeds[..., list(regressors.speed_lags)] / self.speed_scale[..., None],
            slip,
            old_outputs[..., [lag - 1 for lag in regressors.output_lags]],
        ]
        output = self.output(np.concatenate(phi, axis=-1))
        outputs = np.concatenate([output[..., None], old_outputs], axis=-1)
        kept = [speeds[..., : regressors.n_past_speeds], slip, outputs[..., : regressors.n_past_outputs]]
        return self.torque_scale * output, np.concatenate(kept, axis=-1).reshape(memory.shape)

    def output(self, phi: Array) -> Array:
        """Output y (..., N) for regressors (..., N, R), both in units of their scales."""
        return self._sum(self._inside(self.biases, phi, 0))

    def simulate(self, motor_dq: Array) -> Array:
        """Torque [N m] along motor speeds [rad/s], both (T, N): past outputs are the network's own; none at first."""
        regressors = self.regressors
        driven = self._inside(self.biases, self.inputs(motor_dq), 0)
        if not regressors.output_lags:
            output = self._sum(driven)
            output[0] = 0.0
            return self.torque_scale * output
        before, lags = regressors.n_past_outputs, np.array(regressors.output_lags)
        outputs = np.zeros((before + len(motor_dq), self.n_joints))
        for k in range(1, len(motor_dq)):
            past = outputs[before + k - lags].T
            outputs[before + k] = self._sum(self._inside(driven[k], past, regressors.n_inputs))
        return self.torque_scale * outputs[before:]

    def predict(self, motor_dq: Array, torque: Array) -> Array:
        """Torque [N m] one step ahead along motor speeds [rad/s], all (T, N): past outputs are measured `torque`."""
        return self.torque_scale * self.output(self.phi(motor_dq, torque))

    def phi(self, motor_dq: Array, torque: Array) -> Array:
        """Regressors with measured past outputs, shape (T, N, R); before the start, no torque and the first speed."""
        y = check_shape("torque", torque, np.shape(motor_dq)) / self.torque_scale
        return np.concatenate([self.inputs(motor_dq), *self.regressors.past_outputs(y)], axis=-1)

    def inputs(self, motor_dq: Array) -> Array:
        """The regressors that follow from motor speeds (T, N) [rad/s], shape (T, N, n_inputs)."""
        return self.regressors.inputs(motor_dq, self.dt, self.speed_scale)

    def _inside(self, start: Array, phi: Array, first: int) -> Array:
        """Compute inputs of neurons, (..., N, H), from `start` and regressors from `first` on, (..., N, some of R)."""
        inside = np.broadcast_to(start, (*phi.shape[:-1], self.biases.shape[-1])).copy()
        for r in range(phi.shape[-1]):  # elementwise: a matrix product may round by the size of the batch
            inside += self.input_weights[..., first + r] * phi[..., r, None]
        return inside

    def _sum(self, inside: Array) -> Array:
        output: Array = self.offset + (self.output_weights * sigmoid(inside)).sum(axis=-1)
        return output


ARRAYS = ("input_weights", "biases", "output_weights", "offset", "speed_scale", "torque_scale")
"""Fields of `NarxModel` that are arrays over joints."""


def joint_models(models: list[NarxModel], which: Array) -> NarxModel:
    """The network whose motor j is that of `models[which[j]]`; all have one structure."""
    joints = np.arange(len(which))
    arrays: dict[str, Any] = {
        name: np.stack([getattr(each, name) for each in models])[which, joints] for name in ARRAYS
    }
    return NarxModel(**arrays, regressors=models[0].regressors, dt=models[0].dt)


def sigmoid(x: Array) -> Array:
    """Thesis (3.7), as a hyperbolic tangent, which cannot overflow."""
    share: Array = 0.5 + 0.5 * np.tanh(0.5 * x)
    return share
