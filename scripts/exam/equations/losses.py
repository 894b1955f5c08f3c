"""Losses of gearboxes by load, by temperature, and by what other shafts do."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects import State, TorqueEffect, Torques
from ffgym.effects.effect import Side
from ffgym.effects.parameters import parameter
from scripts.exam.equations.variant import Variant

_POLE = -95.0
"""Temperature [degC] in Vogel's law at which oil would be solid; chosen, near that of mineral gear oils."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class DirectionalEfficiency(Variant, TorqueEffect):
    r"""A share of the load is lost where the motor drives, a larger one where the load does, more at low speed.

    .. math:: \tau_f \mathrel{+}= \mu\, w(v) \left( \frac{1 + r}{2} |\tau_l| s + \frac{1 - r}{2} \tau_l |s| \right) / n

    The motor drives if load and speed have one sign. It takes energy at any sign, as r >= 0.
    """

    name: ClassVar[str] = "directional_efficiency"
    variant_of: ClassVar[str] = "load_friction"
    title: ClassVar[str] = "efficiency by direction of power"
    equation: ClassVar[str] = (
        r"\tau_f \mathrel{+}= \mu\, (1 + k e^{-|v / v_s|}) \left( \tfrac{1 + r}{2} |\tau_l| s + "
        r"\tfrac{1 - r}{2} \tau_l |s| \right) / n"
    )
    side: ClassVar[Side] = "motor"
    needs_elasticity: ClassVar[bool] = True
    needs_friction: ClassVar[bool] = True

    share: Array = parameter(
        "mu, lost where the motor drives", unit="1", low=0.0, high=0.15, minimum=0.0, source="as load_friction"
    )
    ratio: Array = parameter(
        "r, of what is lost where the load drives", unit="1", null=None, low=1.0, high=1.6, minimum=0.0, source="chosen"
    )
    slow: Array = parameter(
        "k, more at low speed", unit="1", null=None, low=0.0, high=0.5, minimum=0.0, source="chosen"
    )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        load, sign = state.load_at_motor, state.friction_sign
        both = (1 + self.ratio) / 2 * np.abs(load) * sign + (1 - self.ratio) / 2 * load * np.abs(sign)
        slow = 1 + self.slow * np.exp(-np.abs(state.motor_speed / state.stribeck_velocity))
        return Torques(motor=-self.share * slow * both), memory


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class VogelOil(Variant, TorqueEffect):
    """Oil by the law that viscosity tables follow; the description holds at the temperature of the room.

    Reference:
        Vogel (1921), Physikalische Zeitschrift 22.
    """

    name: ClassVar[str] = "vogel_oil"
    variant_of: ClassVar[str] = "temperature_friction"
    title: ClassVar[str] = "viscosity of oil by Vogel's law"
    equation: ClassVar[str] = (
        r"\tau_f \mathrel{+}= c f_v \left( e^{B / (T - T_\infty) - B / (T_r - T_\infty)} - 1 \right) v"
    )
    side: ClassVar[Side] = "motor"
    needs_friction: ClassVar[bool] = True

    share: Array = parameter(
        "c, of viscous friction that is oil", unit="1", low=0.0, high=1.0, minimum=0.0, maximum=1.0, source="chosen"
    )
    vogel: Array = parameter("B", unit="K", null=None, low=600.0, high=1200.0, minimum=0.0, source="mineral gear oils")
    reference: Array = parameter(
        "T_r, temperature at which the description holds",
        unit="degC",
        null=None,
        low=20.0,
        high=60.0,
        default=20.0,
        source="chosen: that of the room",
    )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        exponent = self.vogel * (1 / (state.temperature - _POLE) - 1 / (self.reference - _POLE))
        return Torques(motor=-self.share * state.viscous * np.expm1(exponent) * state.motor_speed), memory


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class DraggingShaft(Variant, TorqueEffect):
    """A shaft inside another drags it along by dry friction of its own, which knows no bristles."""

    name: ClassVar[str] = "dragging_shaft"
    variant_of: ClassVar[str] = "wrist_coupling"
    title: ClassVar[str] = "dry coupling losses of the wrist"
    equation: ClassVar[str] = r"\tau_{f,i} \mathrel{+}= \sum_{j \ne i} c_{ij} f_{c,j} \tanh(v_j / v_0)"
    side: ClassVar[Side] = "motor"
    needs_friction: ClassVar[bool] = True

    share: Array = parameter(
        "c_ij, row: motor that is braked, column: motor that turns",
        unit="1",
        low=-0.3,
        high=0.3,
        per="pair",
        source="as wrist_coupling",
    )
    speed: Array = parameter(
        "v_0 of the motor that is braked", unit="rad/s", null=None, low=0.1, high=0.5, minimum=1e-3, source="chosen"
    )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        total = np.zeros_like(state.motor_speed)
        for j in range(total.shape[-1]):  # one by one, so that a row's bits depend on nothing else
            loss = state.coulomb[..., j : j + 1] * np.tanh(state.motor_speed[..., j : j + 1] / self.speed)
            total = total - self.share[..., :, j] * loss
        return Torques(motor=total), memory
