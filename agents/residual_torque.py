"""Residual torque model: the torque that is missing as a function of what a motor does, learned from two trials.

Idea and source: regression on the difference between what a model predicts and what a machine does is common for
inverse dynamics (Nguyen-Tuong & Peters 2011, Cognitive Processing 12, "Model learning for robot control"); here the
model is the drive's own feed-forward, and the difference is friction before all. Per motor

    u_lff = b . [s_1 ... s_W, v, a] + g(x),      x = [s_1 ... s_W, asinh(v / v_0) / asinh(v_max / v_0)]

with slip elements s (`ffgym.robot.friction`: what remembers the last reversal), motor speed v and
acceleration a. The linear part is the mean of a Gaussian process, g its deviation from it: a sum of bells around some
of the samples seen,

    g(x) = sum_i alpha_i exp(-|x - x_i|^2 / (2 l^2))

It is zero far from all that was seen, where the linear part alone answers: shrinking to the mean is what the process
does where its variance is back at that of the prior.

Run it:

    ffgym demo --agents none lugre_dynamic residual_gp

Logged: see `ffgym.agents.fitting.supervised.Supervised`. How it is fitted, and what departs from the source:
`ffgym.agents.fitting.residual_fit`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, Self, final

import numpy as np

from ffgym.agents.common.law_files import StoredLaw
from ffgym.agents.fitting.supervised import linear_features
from ffgym.control import CausalLaw, Window
from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.types import Array
from ffgym.robot.friction import WIDTHS, advance_slip

KNEE = 0.01
"""v_0 / v_max: speeds are stretched below it and compressed above, since friction changes most near standstill. Chosen:
0.1 rad/s where a motor reaches 10, which is where the Stribeck effect of geared motors lies."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ResidualTorque(CausalLaw, StoredLaw):
    """Linear part plus Gaussian process per motor; predicts with NumPy alone."""

    coefficients: Array
    """b [N m per unit of its feature], motor side, shape (N, W + 2)."""
    top_speed: Array
    """v_max [rad/s], motor side, shape (N,), > 0."""
    points: Array
    """Samples x_i, shape (N, P, W + 1)."""
    alpha: Array
    """Heights of their bells [N m], shape (N, P)."""
    length: Array
    """Width l of the bells, in units of x, shape (N,), > 0."""
    widths: Array = field(default_factory=WIDTHS.copy)
    """Motor travel after which the slip elements slip [rad], shape (W,), > 0."""
    name: str = "residual_gp"
    kind: ClassVar[str] = "residual_gp"

    def __post_init__(self) -> None:
        n, p = check_shape("alpha", self.alpha, (None, None)).shape
        w = check_shape("widths", self.widths, (None,)).size
        shapes = {
            "coefficients": (n, w + 2),
            "top_speed": (n,),
            "points": (n, p, w + 1),
            "alpha": (n, p),
            "length": (n,),
            "widths": (w,),
        }
        for name, shape in shapes.items():
            object.__setattr__(self, name, check_shape(name, getattr(self, name), shape))
        for name in ("top_speed", "length", "widths"):
            if np.any(getattr(self, name) <= 0):
                raise FFGymError(f"{name} = {getattr(self, name)} of law {self.name!r} must be > 0.")

    @property
    def n_joints(self) -> int:
        """See base class."""
        return len(self.coefficients)

    def initial_memory(self, window: Window) -> Array:
        """Slip elements at the start, shape (..., N W): relaxed."""
        return np.zeros((*window.q.shape[:-2], self.n_joints * len(self.widths)))

    def step(self, memory: Array, window: Window) -> tuple[Array, Array]:
        """See base class; remembered are the slip elements."""
        slip = memory.reshape(*memory.shape[:-1], self.n_joints, len(self.widths))
        now, then = window.motor_dq[..., 0, :], window.motor_dq[..., 1, :]
        slip = advance_slip(slip, now, then, window.dt, self.widths)
        return self.at(slip, then, window.motor_ddq[..., 1, :]), slip.reshape(memory.shape)

    def at(self, slip: Array, motor_dq: Array, motor_ddq: Array) -> Array:
        """Torque [N m] with slip elements (..., N, W), at motor speed [rad/s] and acceleration [rad/s^2] (..., N)."""
        mean = (self.coefficients * linear_features(slip, motor_dq, motor_ddq)).sum(axis=-1)
        x = bell_features(slip, motor_dq, self.top_speed)
        square = np.zeros((*motor_dq.shape, self.alpha.shape[1]))
        for d in range(x.shape[-1]):  # one feature at a time, or the array of differences gets large
            square += (x[..., d, None] - self.points[..., d]) ** 2
        bells = np.exp(-0.5 * square / self.length[:, None] ** 2)
        return np.asarray(mean + (self.alpha * bells).sum(axis=-1))

    def parts(self) -> tuple[dict[str, Any], dict[str, Array]]:
        """See base class."""
        names = ("coefficients", "top_speed", "points", "alpha", "length", "widths")
        return {"name": self.name}, {name: getattr(self, name) for name in names}

    @classmethod
    def from_parts(cls, settings: Mapping[str, Any], arrays: Mapping[str, Array]) -> Self:
        """See base class."""
        return cls(**{"name": settings["name"], "widths": arrays["widths"], **arrays})  # a file has no default


def bell_features(slip: Array, motor_dq: Array, top_speed: Array) -> Array:
    """Where the process is asked, x of shape (..., N, W + 1), each number within [-1, 1] up to the top speed."""
    stretched = np.arcsinh(motor_dq / (KNEE * top_speed)) / np.arcsinh(1 / KNEE)
    return np.concatenate([slip, stretched[..., None]], axis=-1)
