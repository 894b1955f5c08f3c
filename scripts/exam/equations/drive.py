"""Torque of drives in other shapes: gain errors that fade with the current, two lags in a row."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects import State, TorqueEffect, Torques
from ffgym.effects.effect import Side
from ffgym.effects.parameters import parameter
from scripts.exam.equations.variant import Variant


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class BentTorqueConstant(Variant, TorqueEffect):
    """An error of the torque constant that gets smaller with the current, as iron saturates smoothly."""

    name: ClassVar[str] = "bent_torque_constant"
    variant_of: ClassVar[str] = "torque_constant"
    title: ClassVar[str] = "torque constant that bends with the current"
    equation: ClassVar[str] = r"\tau \mathrel{+}= e\, u / (1 + |u| / (b\, u_{peak}))"
    side: ClassVar[Side] = "motor"

    error: Array = parameter("e", unit="1", low=-0.1, high=0.1, minimum=-0.9, source="as torque_constant")
    bend: Array = parameter(
        "b, of the peak torque", unit="1", null=None, low=0.5, high=2.0, minimum=1e-3, source="chosen"
    )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        u = state.motor_torque
        return Torques(motor=self.error * u / (1 + np.abs(u) / (self.bend * state.peak_torque))), memory


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TwoLags(Variant, TorqueEffect):
    """A current loop with a filter before it: two lags in a row; the exact solution for commands that are held."""

    name: ClassVar[str] = "two_lags"
    variant_of: ClassVar[str] = "torque_delay"
    title: ClassVar[str] = "two lags of the torque loop"
    equation: ClassVar[str] = r"T_1 \dot x = u - x, \quad T_1 \dot \tau = x - \tau"
    side: ClassVar[Side] = "motor"

    lag: Array = parameter("T_1, of each", unit="s", low=0.0, high=0.0005, minimum=0.0, source="as torque_delay")

    def initial_memory(self, state: State) -> Array:
        """Both give the command at rest, shape (..., N, 2)."""
        return np.repeat(state.motor_torque[..., None], 2, axis=-1)

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        u = state.motor_torque
        keep = np.exp(-np.divide(dt, self.lag, out=np.full_like(self.lag, np.inf), where=self.lag > 0))
        first = u + (memory[..., 0] - u) * keep
        second = first + (memory[..., 1] - first) * keep
        return Torques(motor=second - u), np.stack([first, second], axis=-1)
