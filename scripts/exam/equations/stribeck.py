"""Stribeck curves that are not the Gaussian of the LuGre model."""

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
class TanhStribeck(Variant, TorqueEffect):
    """A second peak on top of the one that is described, as a hyperbolic tangent.

    Reference:
        Makkar, Dixon, Sawyer, Hu (2005), IEEE/ASME AIM: a continuously differentiable friction model.
    """

    name: ClassVar[str] = "tanh_stribeck"
    variant_of: ClassVar[str] = "stribeck_peak"
    title: ClassVar[str] = "Stribeck peak as a hyperbolic tangent"
    equation: ClassVar[str] = r"\tau_f \mathrel{+}= a f_c\, (1 - \tanh(|v| / (w v_s)))\, s(v)"
    side: ClassVar[Side] = "motor"
    needs_friction: ClassVar[bool] = True

    share: Array = parameter(
        "a, of the Coulomb torque", unit="1", low=0.0, high=1.0, minimum=0.0, source="as stribeck_peak"
    )
    width: Array = parameter(
        "w, of the Stribeck velocity", unit="1", null=None, low=0.7, high=2.0, minimum=0.01, source="chosen: near 1"
    )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        x = np.abs(state.motor_speed) / (self.width * state.stribeck_velocity)
        peak = self.share * state.coulomb * (1 - np.tanh(x))
        return Torques(motor=-peak * state.friction_sign), memory


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class LorentzStribeck(Variant, TorqueEffect):
    """The same as a Lorentz curve, whose skirts are wide."""

    name: ClassVar[str] = "lorentz_stribeck"
    variant_of: ClassVar[str] = "stribeck_peak"
    title: ClassVar[str] = "Stribeck peak as a Lorentz curve"
    equation: ClassVar[str] = r"\tau_f \mathrel{+}= a f_c\, s(v) / (1 + (v / (w v_s))^2)"
    side: ClassVar[Side] = "motor"
    needs_friction: ClassVar[bool] = True

    share: Array = parameter(
        "a, of the Coulomb torque", unit="1", low=0.0, high=1.0, minimum=0.0, source="as stribeck_peak"
    )
    width: Array = parameter(
        "w, of the Stribeck velocity", unit="1", null=None, low=0.7, high=1.3, minimum=0.01, source="chosen: near 1"
    )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        x = state.motor_speed / (self.width * state.stribeck_velocity)
        return Torques(motor=-self.share * state.coulomb / (1 + x * x) * state.friction_sign), memory
