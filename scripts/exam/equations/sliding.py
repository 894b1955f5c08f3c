"""Friction in sliding, in other shapes than constant, linear and square."""

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
class FallingCoulomb(Variant, TorqueEffect):
    """More friction of seals, that lift off a little where they slide fast."""

    name: ClassVar[str] = "falling_coulomb"
    variant_of: ClassVar[str] = "coulomb_level"
    title: ClassVar[str] = "Coulomb friction that falls slowly with speed"
    equation: ClassVar[str] = r"\tau_f \mathrel{+}= a f_c\, (1 + |v| / v_w)^{-1/10}\, s(v)"
    side: ClassVar[Side] = "motor"
    needs_friction: ClassVar[bool] = True

    share: Array = parameter("a, of the Coulomb torque", unit="1", low=-0.3, high=0.3, source="as coulomb_level")
    speed: Array = parameter(
        "v_w, motor side", unit="rad/s", null=None, low=3.0, high=30.0, minimum=1e-3, source="chosen"
    )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        level = self.share * state.coulomb * (1 + np.abs(state.motor_speed) / self.speed) ** -0.1
        return Torques(motor=-level * state.friction_sign), memory


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class PowerViscous(Variant, TorqueEffect):
    """More drag of grease, by a power law of the speed as non-Newtonian fluids follow."""

    name: ClassVar[str] = "power_viscous"
    variant_of: ClassVar[str] = "viscous_level"
    title: ClassVar[str] = "viscous friction by a power law"
    equation: ClassVar[str] = r"\tau_f \mathrel{+}= a f_v v_r\, |v / v_r|^p\, \mathrm{sgn}(v)"
    side: ClassVar[Side] = "motor"
    needs_friction: ClassVar[bool] = True

    share: Array = parameter(
        "a, of viscous friction at speed v_r", unit="1", low=-0.5, high=0.5, source="as viscous_level"
    )
    exponent: Array = parameter("p", unit="1", null=None, low=0.85, high=1.15, minimum=0.1, source="chosen: near 1")
    speed: Array = parameter(
        "v_r, motor side", unit="rad/s", null=None, low=10.0, high=30.0, minimum=1e-3, source="chosen: fast motions"
    )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        v = state.motor_speed
        drag = self.speed * np.abs(v / self.speed) ** self.exponent * np.sign(v)
        return Torques(motor=-self.share * state.viscous * drag), memory


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ShearThinning(Variant, TorqueEffect):
    """Grease that gets thinner, or thicker, where it is sheared fast, and then no more."""

    name: ClassVar[str] = "shear_thinning"
    variant_of: ClassVar[str] = "nonlinear_viscous"
    title: ClassVar[str] = "viscosity that saturates with the shear rate"
    equation: ClassVar[str] = r"\tau_f \mathrel{+}= a f_v v\, |v| / (v_0 + |v|)"
    side: ClassVar[Side] = "motor"
    needs_friction: ClassVar[bool] = True

    share: Array = parameter(
        "a, of viscous friction at high speed", unit="1", low=-0.6, high=0.6, source="chosen: half of it thins"
    )
    speed: Array = parameter(
        "v_0, motor side", unit="rad/s", null=None, low=100.0, high=400.0, minimum=1e-3, source="chosen"
    )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        v, fast = state.motor_speed, np.abs(state.motor_speed)
        return Torques(motor=-self.share * state.viscous * v * fast / (self.speed + fast)), memory


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class OneWaySeal(Variant, TorqueEffect):
    """A lip seal that is pressed on in one direction and lifted in the other, less so at speed."""

    name: ClassVar[str] = "one_way_seal"
    variant_of: ClassVar[str] = "asymmetry"
    title: ClassVar[str] = "friction that depends on direction, less at speed"
    equation: ClassVar[str] = r"\tau_f \mathrel{+}= a f_c\, s^2\, (1 + |v| / v_a)^{-1/5}"
    side: ClassVar[Side] = "motor"
    needs_friction: ClassVar[bool] = True

    share: Array = parameter("a, of the Coulomb torque", unit="1", low=-0.2, high=0.2, source="as asymmetry")
    speed: Array = parameter(
        "v_a, motor side", unit="rad/s", null=None, low=3.0, high=30.0, minimum=1e-3, source="chosen"
    )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        fading = (1 + np.abs(state.motor_speed) / self.speed) ** -0.2
        return Torques(motor=-self.share * state.coulomb * state.friction_sign**2 * fading), memory
