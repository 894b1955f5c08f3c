"""A second, wider fall of friction with speed, of another exponent than the Stribeck curve of the LuGre model."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects import State, TorqueEffect, Torques
from ffgym.effects.effect import Side
from ffgym.effects.parameters import parameter


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SlowStribeck(TorqueEffect):
    r"""Friction of seals and grease that falls off with speed.

    .. math:: \tau = -A \, e^{-|v / v_2|} \, s
    """

    name: ClassVar[str] = "slow_stribeck"
    title: ClassVar[str] = "Second Stribeck term"
    equation: ClassVar[str] = "tau_f += A exp(-|v/v2|) s"
    side: ClassVar[Side] = "motor"
    signature: ClassVar[str] = "friction that falls from slow to medium speed"
    way_in: ClassVar[str] = "torque on the motor"
    needs_friction: ClassVar[bool] = True

    level: Array = parameter(
        "friction that goes away with speed, A, motor side", unit="N m", low=0.0, high=0.2, source="chosen"
    )
    speed: Array = parameter(
        "speed at which 1/e of it is left, motor side",
        unit="rad/s",
        low=0.3,
        high=10.0,
        source="chosen: well above the Stribeck speed of the LuGre model",
        null=None,
        minimum=1e-3,
    )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        fading = self.level * np.exp(-np.abs(state.motor_speed) / self.speed)
        return Torques(motor=-fading * state.friction_sign), memory
