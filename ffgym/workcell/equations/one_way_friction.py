"""Friction that differs between the two directions of a motor, more so the faster it turns."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects import State, TorqueEffect, Torques
from ffgym.effects.effect import Side
from ffgym.effects.parameters import parameter


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class OneWayFriction(TorqueEffect):
    r"""Friction of tooth flanks and seals that are pressed harder one way.

    .. math:: \tau = -a \, s^2 \, (1 + |v| / v_a)^{1/2}

    It stands against the positive direction and helps the negative one; at rest on relaxed bristles it is gone.
    """

    name: ClassVar[str] = "one_way_friction"
    title: ClassVar[str] = "Friction that differs by direction"
    equation: ClassVar[str] = "tau_f += a s^2 sqrt(1 + |v|/va)"
    side: ClassVar[Side] = "motor"
    signature: ClassVar[str] = "an offset while moving, that is gone at rest and grows slowly with speed"
    way_in: ClassVar[str] = "torque on the motor"
    needs_friction: ClassVar[bool] = True

    level: Array = parameter(
        "half the difference of both directions at low speed, a, motor side",
        unit="N m",
        low=-0.1,
        high=0.1,
        source="chosen: up to a fifth of Coulomb friction",
    )
    speed: Array = parameter(
        "speed at which it has grown by a factor 1.4, va, motor side",
        unit="rad/s",
        low=1.0,
        high=50.0,
        source="chosen",
        null=None,
        minimum=1e-3,
    )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        growth = np.sqrt(1 + np.abs(state.motor_speed) / self.speed)
        return Torques(motor=-self.level * state.friction_sign**2 * growth), memory
