"""Errors that repeat with the turn of a motor or joint, as two waves that are locked to each other."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects import ResolverEffect, ResolverError, State, TorqueEffect, Torques
from ffgym.effects.effect import Side
from ffgym.effects.parameters import parameter
from scripts.exam.equations.variant import Variant

_SECOND = 0.4
"""Height of the second wave; chosen: the first is the main one, and two thirds of it are not all."""

_SHIFT = 1.0
"""Its phase beyond twice that of the first [rad]; chosen: neither even nor odd."""


def _two_waves(angle: Array) -> Array:
    wave: Array = np.sin(angle) + _SECOND * np.sin(2 * angle + _SHIFT)
    return wave


def _slope(angle: Array) -> Array:
    slope: Array = np.cos(angle) + 2 * _SECOND * np.cos(2 * angle + _SHIFT)
    return slope


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TwoWaveFriction(Variant, TorqueEffect):
    """Friction of planets and cage, which pass at rates of their own."""

    name: ClassVar[str] = "two_wave_friction"
    variant_of: ClassVar[str] = "position_friction"
    title: ClassVar[str] = "position-dependent friction of two waves"
    equation: ClassVar[str] = r"\tau_f \mathrel{+}= a f_c\, w(k q + \varphi)\, s(v)"
    side: ClassVar[Side] = "motor"
    needs_friction: ClassVar[bool] = True

    share: Array = parameter(
        "a, of the Coulomb torque", unit="1", low=0.0, high=0.2, minimum=0.0, maximum=0.7, source="as position_friction"
    )
    cycles: Array = parameter(
        "k, per radian of the joint",
        unit="1/rad",
        null=None,
        low=5.0,
        high=40.0,
        minimum=0.0,
        source="chosen",
        role="cycles",
    )
    phase: Array = parameter("phi", unit="rad", null=None, low=0.0, high=2 * np.pi, source="any", role="phase")

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        level = self.share * state.coulomb * _two_waves(self.cycles * state.joint_angle + self.phase)
        return Torques(motor=-level * state.friction_sign), memory


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TwoWaveCogging(Variant, TorqueEffect):
    """Cogging of teeth that are not quite alike."""

    name: ClassVar[str] = "two_wave_cogging"
    variant_of: ClassVar[str] = "cogging"
    title: ClassVar[str] = "cogging of two waves"
    equation: ClassVar[str] = r"\tau \mathrel{+}= A\, w(k \theta + \varphi)"
    side: ClassVar[Side] = "motor"

    amplitude: Array = parameter("A, motor side", unit="N m", low=0.0, high=0.3, minimum=0.0, source="as cogging")
    cycles: Array = parameter(
        "k, per motor turn", unit="1", null=None, low=1.0, high=36.0, source="as cogging", role="cycles"
    )
    phase: Array = parameter("phi", unit="rad", null=None, low=0.0, high=2 * np.pi, source="any", role="phase")

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        return Torques(motor=self.amplitude * _two_waves(self.cycles * state.motor_angle + self.phase)), memory


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TwoWaveRipple(Variant, TorqueEffect):
    """Ripple of currents that are off and of windings that differ."""

    name: ClassVar[str] = "two_wave_ripple"
    variant_of: ClassVar[str] = "torque_ripple"
    title: ClassVar[str] = "torque ripple of two waves"
    equation: ClassVar[str] = r"\tau \mathrel{+}= r\, u\, w(k \theta + \varphi)"
    side: ClassVar[Side] = "motor"

    share: Array = parameter("r", unit="1", low=0.0, high=0.05, minimum=0.0, maximum=0.7, source="as torque_ripple")
    cycles: Array = parameter(
        "k, per motor turn", unit="1", null=None, low=1.0, high=18.0, source="as torque_ripple", role="cycles"
    )
    phase: Array = parameter("phi", unit="rad", null=None, low=0.0, high=2 * np.pi, source="any", role="phase")

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        wave = _two_waves(self.cycles * state.motor_angle + self.phase)
        return Torques(motor=self.share * state.motor_torque * wave), memory


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TwoWaveGearError(Variant, TorqueEffect):
    r"""Kinematic error of two waves. What acts back on the motor makes that no energy is made.

    .. math:: \tau_{spring} = k e + d \dot e, \quad \tau_m = -(\tau_l + \tau_{spring})\, \partial e / \partial\theta,
        \quad e = A\, w(k \theta + \varphi)
    """

    name: ClassVar[str] = "two_wave_gear_error"
    variant_of: ClassVar[str] = "kinematic_error"
    title: ClassVar[str] = "kinematic error of two waves"
    equation: ClassVar[str] = r"q = \theta / n + A\, w(k \theta + \varphi)"
    side: ClassVar[Side] = "link"
    needs_elasticity: ClassVar[bool] = True

    amplitude: Array = parameter(
        "A, link side", unit="rad", low=0.0, high=3e-4, minimum=0.0, source="as kinematic_error"
    )
    cycles: Array = parameter(
        "k, per motor turn", unit="1", null=None, low=1.0, high=2.0, source="as kinematic_error", role="cycles"
    )
    phase: Array = parameter("phi", unit="rad", null=None, low=0.0, high=2 * np.pi, source="any", role="phase")

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        angle = self.cycles * state.motor_angle + self.phase
        error, slope = self.amplitude * _two_waves(angle), self.amplitude * self.cycles * _slope(angle)
        spring = state.joint_stiffness * error + state.joint_damping * slope * state.motor_speed
        return Torques(spring=spring, motor=-(state.load + spring) * slope), memory


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TwoWaveResolver(Variant, ResolverEffect):
    """A resolver whose rotor is off centre and whose windings differ."""

    name: ClassVar[str] = "two_wave_resolver"
    variant_of: ClassVar[str] = "resolver_ripple"
    title: ClassVar[str] = "resolver error of two waves"
    equation: ClassVar[str] = r"\theta_{meas} = \theta + A\, w(\theta + \varphi)"
    side: ClassVar[Side] = "motor"
    way_in: ClassVar[str] = "reading of the servo"

    amplitude: Array = parameter(
        "A, motor side", unit="rad", low=0.0, high=3e-3, minimum=0.0, source="as resolver_ripple"
    )
    cycles: Array = parameter(
        "k, per motor turn", unit="1", null=None, low=1.0, high=1.0, source="one, and two beside", role="cycles"
    )
    phase: Array = parameter("phi", unit="rad", null=None, low=0.0, high=2 * np.pi, source="any", role="phase")

    def error(self, motor_angle: Array, motor_speed: Array) -> ResolverError:
        """See base class."""
        angle = self.cycles * motor_angle + self.phase
        slope = self.amplitude * self.cycles * _slope(angle)
        return ResolverError(angle=self.amplitude * _two_waves(angle), speed=slope * motor_speed)
