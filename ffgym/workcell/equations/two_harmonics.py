"""Errors that repeat with every turn of the motor, at two harmonics that are locked to each other."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects import ResolverEffect, ResolverError, State, TorqueEffect, Torques
from ffgym.effects.effect import Side
from ffgym.effects.parameters import parameter


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TorqueRipple(TorqueEffect):
    r"""Ripple in proportion to the motor's torque, with half its size at twice its frequency.

    .. math:: \tau = r \, \tau_m \, (\sin(k \theta + \varphi) + \tfrac{1}{2} \sin 2 (k \theta + \varphi))
    """

    name: ClassVar[str] = "two_harmonic_ripple"
    title: ClassVar[str] = "Torque ripple"
    equation: ClassVar[str] = "tau_m (1 + r (sin(k th + ph) + sin(2 (k th + ph))/2))"
    side: ClassVar[Side] = "motor"
    signature: ClassVar[str] = "periodic in the motor angle, in proportion to the torque"
    way_in: ClassVar[str] = "torque on the motor"

    share: Array = parameter("amplitude of the first harmonic, r", unit="1", low=0.0, high=0.05, source="1-5 %: chosen")
    cycles: Array = parameter("cycles per motor turn, k", unit="1", low=1.0, high=12.0, source="chosen", null=None)
    phase: Array = parameter("phase at motor angle 0", unit="rad", low=-np.pi, high=np.pi, source="chosen", null=None)

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        angle = self.cycles * state.motor_angle + self.phase
        return Torques(motor=self.share * state.motor_torque * (np.sin(angle) + np.sin(2 * angle) / 2)), memory


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class GearError(TorqueEffect):
    r"""Kinematic error of the gear: its output leads the motor by an angle that repeats, and the elasticity carries it.

    .. math:: \tau = K \epsilon + d \dot\epsilon, \quad
        \epsilon = A (\sin(k \theta + \varphi) + \tfrac{1}{3} \sin(3 k \theta + \varphi))

    and the motor bears :math:`-\tau_l \, \partial\epsilon / \partial\theta`, so that no energy is made.
    """

    name: ClassVar[str] = "two_harmonic_gear_error"
    title: ClassVar[str] = "Transmission error"
    equation: ClassVar[str] = "q = th/n + A (sin(k th + ph) + sin(3 k th + ph)/3)"
    side: ClassVar[Side] = "link"
    signature: ClassVar[str] = "tool error that is periodic in the motor angle"
    way_in: ClassVar[str] = "torque in the spring"
    needs_elasticity: ClassVar[bool] = True

    amplitude: Array = parameter(
        "of the first harmonic, A, link side",
        unit="rad",
        low=0.0,
        high=1e-4,
        source="chosen: up to where strain wave gears begin",
    )
    cycles: Array = parameter("cycles per motor turn, k", unit="1", low=0.1, high=4.0, source="chosen", null=None)
    phase: Array = parameter("phase at motor angle 0", unit="rad", low=-np.pi, high=np.pi, source="chosen", null=None)

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        angle, k = state.motor_angle, self.cycles
        error = self.amplitude * (np.sin(k * angle + self.phase) + np.sin(3 * k * angle + self.phase) / 3)
        slope = self.amplitude * k * (np.cos(k * angle + self.phase) + np.cos(3 * k * angle + self.phase))
        spring = state.joint_stiffness * error + state.joint_damping * slope * state.motor_speed
        return Torques(spring=spring, motor=-(state.load + spring) * slope), memory


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ResolverEccentricity(ResolverEffect):
    r"""Reading error of a resolver whose rotor runs out of true and whose two windings differ.

    .. math:: \epsilon = A (\sin(\theta + \varphi) + \tfrac{1}{2} \sin(2 \theta - \varphi))
    """

    name: ClassVar[str] = "resolver_eccentricity"
    title: ClassVar[str] = "Resolver error"
    equation: ClassVar[str] = "th_meas = th + A (sin(th + ph) + sin(2 th - ph)/2)"
    side: ClassVar[Side] = "controller"
    signature: ClassVar[str] = "tool error of one and two cycles per motor turn, constant in speed"
    way_in: ClassVar[str] = "reading of the servo"

    amplitude: Array = parameter(
        "of the first harmonic, A, motor side", unit="rad", low=0.0, high=3e-3, source="1-10 arcmin of the motor"
    )
    phase: Array = parameter("phase at motor angle 0", unit="rad", low=-np.pi, high=np.pi, source="chosen", null=None)

    def error(self, motor_angle: Array, motor_speed: Array) -> ResolverError:
        """See base class."""
        first, second = motor_angle + self.phase, 2 * motor_angle - self.phase
        angle = self.amplitude * (np.sin(first) + np.sin(second) / 2)
        return ResolverError(angle=angle, speed=self.amplitude * (np.cos(first) + np.cos(second)) * motor_speed)
