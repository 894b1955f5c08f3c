"""Oil that thins as the gearbox warms up, by the law that lubricants follow, and grease that hardly does."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects import State, TorqueEffect, Torques
from ffgym.effects.effect import Side
from ffgym.effects.parameters import parameter

_POLE = -105.0
"""Temperature [degC] in Vogel's law at which oil would be solid; typical of mineral gear oils (ISO VG 150 to 320)."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ColdOil(TorqueEffect):
    r"""Viscous friction beyond its value at the temperature for which the description holds.

    .. math:: \tau = -f \, (\eta(T) / \eta(T_0) - 1) \, v, \quad \eta(T) = e^{B / (T - T_\infty)}

    Only the gearbox's share f of viscous friction is oil; bearings and seals of the motor are not.

    Reference:
        Vogel (1921), Physikalische Zeitschrift 22: the equation that viscosity tables of lubricants follow.
    """

    name: ClassVar[str] = "cold_oil"
    title: ClassVar[str] = "Viscosity of the oil"
    equation: ClassVar[str] = "tau_f += f (eta(T)/eta(T0) - 1) v, eta = exp(B/(T - Tinf))"
    side: ClassVar[Side] = "motor"
    signature: ClassVar[str] = "viscous friction that falls while the machine warms up"
    way_in: ClassVar[str] = "torque on the motor"
    needs_friction: ClassVar[bool] = True

    viscous: Array = parameter(
        "viscous friction of the oil at the reference temperature, f, motor side",
        unit="N m s/rad",
        low=0.0,
        high=0.1,
        source="chosen: a share of the viscous friction of the joint",
        minimum=0.0,
    )
    vogel: Array = parameter(
        "Vogel's B",
        unit="K",
        low=600.0,
        high=1200.0,
        source="mineral gear oils: viscosity halves over about 15 K near 30 degC",
        null=None,
        minimum=0.0,
    )
    reference: Array = parameter(
        "temperature at which the description holds, T0",
        unit="degC",
        low=20.0,
        high=60.0,
        source="chosen: a machine that has run for hours",
        null=None,
    )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        exponent = self.vogel * (1 / (state.temperature - _POLE) - 1 / (self.reference - _POLE))
        return Torques(motor=-self.viscous * np.expm1(exponent) * state.motor_speed), memory
