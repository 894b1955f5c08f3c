"""Physics of the workcell, in equations of its own: they resemble those of the library that a diagnosis knows."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects import Effect, ResolverEffect, ResolverError, State, TorqueEffect, Torques
from ffgym.effects.effect import FrictionEffect
from ffgym.effects.parameters import parameter
from ffgym.robot.friction import advance_slip


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SlowStribeck(FrictionEffect):
    r"""Friction of seals and grease that falls off with speed.

    .. math:: \tau = -A \, e^{-|v / v_2|} \, s
    """

    name = "slow_stribeck"
    title = "Second Stribeck term"
    equation = "tau_f += A exp(-|v/v2|) s"
    signature = "friction that falls from slow to medium speed"
    way_in = "torque on the motor"

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

    def friction(self, state: State) -> Array:
        """Return the part of the friction that fades with speed."""
        fading = self.level * np.exp(-np.abs(state.motor_speed) / self.speed)
        return fading * state.friction_sign


_YIELDS = np.array([0.25, 0.5, 1.0])
"""Displacements at which elements break loose, in units of the last one; chosen: even in the logarithm."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SlipElements(TorqueEffect):
    r"""Rate-independent hysteresis beside the LuGre bristles.

    .. math:: \tau = -\frac{F}{3} \sum_i x_i / \Delta_i, \quad \dot x_i = v, \quad |x_i| \le \Delta_i

    Reference:
        Al-Bender, Lampaert, Swevers (2005), IEEE TAC 50(11): the generalised Maxwell-slip model, of which this is the
        part that does not depend on speed.
    """

    name = "slip_elements"
    title = "Presliding in steps"
    equation = "tau_f += F/3 sum_i x_i/D_i, |x_i| <= D_i"
    side = "motor"
    signature = "loop of torque over displacement after a reversal, the same at any speed"
    way_in = "torque on the motor"

    level: Array = parameter(
        "friction once all elements slip, F, motor side", unit="N m", low=0.0, high=0.2, source="chosen", minimum=0.0
    )
    travel: Array = parameter(
        "displacement at which the last element slips, motor side",
        unit="rad",
        low=0.005,
        high=0.1,
        source="chosen: some presliding displacements of the LuGre model",
        null=None,
        minimum=1e-6,
    )

    def initial_memory(self, state: State) -> Array:
        """Return elements that carry no load, shape (..., N, 3)."""
        return np.zeros((*state.motor_angle.shape, len(_YIELDS)))

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """Return the torque of the elements, and their displacements a step later."""
        total = memory[..., 0] + memory[..., 1] + memory[..., 2]
        widths = self.travel[..., None] * _YIELDS
        after = advance_slip(memory, state.motor_speed, state.motor_speed, dt, widths)
        return Torques(motor=-self.level / len(_YIELDS) * total), after


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class OneWayFriction(FrictionEffect):
    r"""Friction of tooth flanks and seals that are pressed harder one way.

    .. math:: \tau = -a \, s^2 \, (1 + |v| / v_a)^{1/2}

    It stands against the positive direction and helps the negative one; at rest on relaxed bristles it is gone.
    """

    name = "one_way_friction"
    title = "Friction that differs by direction"
    equation = "tau_f += a s^2 sqrt(1 + |v|/va)"
    signature = "an offset while moving, that is gone at rest and grows slowly with speed"
    way_in = "torque on the motor"

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

    def friction(self, state: State) -> Array:
        """Return friction that is even in the speed."""
        growth = np.sqrt(1 + np.abs(state.motor_speed) / self.speed)
        return self.level * state.friction_sign**2 * growth


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class GearLosses(FrictionEffect):
    r"""Friction in proportion to the transmitted torque: one share where the motor drives, another where the load does.

    .. math:: \tau = -\bar\mu \, |\tau_l / n| \, s - \delta \, (\tau_l / n) \, |s|, \quad
        \bar\mu = (\mu_d + \mu_b) / 2, \quad \delta = (\mu_d - \mu_b) / 2

    where the motor drives if load and speed have one sign. Continuous, as s passes through 0 where bristles turn.
    """

    name = "gear_losses"
    title = "Losses by load and direction of power"
    equation = "tau_f += mu_drive |tl/n| s where power flows to the link, mu_back |tl/n| s where it flows back"
    signature = "friction that grows with the load, more on the way up than on the way down"
    way_in = "torque on the motor"
    needs_elasticity = True

    driving: Array = parameter(
        "share of the torque lost where the motor drives", unit="1", low=0.0, high=0.15, source="chosen", minimum=0.0
    )
    driven: Array = parameter(
        "share of the torque lost where the load drives", unit="1", low=0.0, high=0.15, source="chosen", minimum=0.0
    )

    def friction(self, state: State) -> Array:
        """Return losses by load, sign of the speed and direction of power."""
        mean, half = (self.driving + self.driven) / 2, (self.driving - self.driven) / 2
        load, sign = state.load_at_motor, state.friction_sign
        return mean * np.abs(load) * sign + half * load * np.abs(sign)


_POLE = -105.0
"""Temperature [degC] in Vogel's law at which oil would be solid; typical of mineral gear oils (ISO VG 150 to 320)."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ColdOil(FrictionEffect):
    r"""Viscous friction beyond its value at the temperature for which the description holds.

    .. math:: \tau = -f \, (\eta(T) / \eta(T_0) - 1) \, v, \quad \eta(T) = e^{B / (T - T_\infty)}

    Only the gearbox's share f of viscous friction is oil; bearings and seals of the motor are not.

    Reference:
        Vogel (1921), Physikalische Zeitschrift 22: the equation that viscosity tables of lubricants follow.
    """

    name = "cold_oil"
    title = "Viscosity of the oil"
    equation = "tau_f += f (eta(T)/eta(T0) - 1) v, eta = exp(B/(T - Tinf))"
    signature = "viscous friction that falls while the machine warms up"
    way_in = "torque on the motor"

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

    def friction(self, state: State) -> Array:
        """Return viscous friction beyond that at the reference temperature."""
        exponent = self.vogel * (1 / (state.temperature - _POLE) - 1 / (self.reference - _POLE))
        return self.viscous * np.expm1(exponent) * state.motor_speed


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SmoothHysteresis(TorqueEffect):
    r"""Torque that lags the deflection delta of the elasticity, whatever the rate.

    .. math:: \tau = -h z, \quad \dot z = \frac{\dot\delta}{\delta_y} \left(1 - |z|^p \,
        \frac{1 + \mathrm{sgn}(z \dot\delta)}{2}\right)

    Reference:
        Wen (1976), ASCE Journal of the Engineering Mechanics Division 102(2), with equal parts beta and gamma.
    """

    name = "smooth_hysteresis"
    title = "Hysteresis of the elasticity"
    equation = "tau_spring += h z, Bouc-Wen z of yield dy and exponent p"
    side = "link"
    signature = "lost motion of the tool where the load changes its direction"
    way_in = "torque in the spring"
    needs_elasticity = True

    level: Array = parameter(
        "largest hysteresis torque h, link side", unit="N m", low=0.0, high=60.0, source="chosen", minimum=0.0
    )
    yielding: Array = parameter(
        "deflection over which it turns round, link side",
        unit="rad",
        low=2e-5,
        high=5e-4,
        source="chosen: a tenth to one lost motion of an arc minute",
        null=None,
        minimum=1e-7,
    )
    exponent: Array = parameter("p", unit="1", low=1.0, high=3.0, source="chosen", null=None, minimum=1.0)

    def initial_memory(self, state: State) -> Array:
        """Return a relaxed spring, shape (..., N, 1)."""
        return np.zeros((*state.motor_angle.shape, 1))

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """Return the hysteresis torque of the spring; the state z advances by a step of Euler's method."""
        z, rate = memory[..., 0], state.deflection_rate
        loading = (1 + np.sign(z * rate)) / 2
        moved = z + rate * dt / self.yielding * (1 - np.abs(z) ** self.exponent * loading)
        return Torques(spring=-self.level * z), np.minimum(np.maximum(moved, -1.0), 1.0)[..., None]


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TorqueRipple(TorqueEffect):
    r"""Ripple in proportion to the motor's torque, with half its size at twice its frequency.

    .. math:: \tau = r \, \tau_m \, (\sin(k \theta + \varphi) + \tfrac{1}{2} \sin 2 (k \theta + \varphi))
    """

    name = "two_harmonic_ripple"
    title = "Torque ripple"
    equation = "tau_m (1 + r (sin(k th + ph) + sin(2 (k th + ph))/2))"
    side = "motor"
    signature = "periodic in the motor angle, in proportion to the torque"
    way_in = "torque on the motor"

    share: Array = parameter("amplitude of the first harmonic, r", unit="1", low=0.0, high=0.05, source="1-5 %: chosen")
    cycles: Array = parameter("cycles per motor turn, k", unit="1", low=1.0, high=12.0, source="chosen", null=None)
    phase: Array = parameter("phase at motor angle 0", unit="rad", low=-np.pi, high=np.pi, source="chosen", null=None)

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """Return the ripple of the motor torque at the motor angle."""
        angle = self.cycles * state.motor_angle + self.phase
        return Torques(motor=self.share * state.loop_torque * (np.sin(angle) + np.sin(2 * angle) / 2)), memory


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class GearError(TorqueEffect):
    r"""Kinematic error of the gear: its output leads the motor by an angle that repeats, and the elasticity carries it.

    .. math:: \tau = K \epsilon + d \dot\epsilon, \quad
        \epsilon = A (\sin(k \theta + \varphi) + \tfrac{1}{3} \sin(3 k \theta + \varphi))

    and the motor bears :math:`-\tau_l \, \partial\epsilon / \partial\theta`, so that no energy is made.
    """

    name = "two_harmonic_gear_error"
    title = "Transmission error"
    equation = "q = th/n + A (sin(k th + ph) + sin(3 k th + ph)/3)"
    side = "link"
    signature = "tool error that is periodic in the motor angle"
    way_in = "torque in the spring"
    needs_elasticity = True

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
        """Return the torque that winds the spring, and the one that acts back on the motor."""
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

    name = "resolver_eccentricity"
    title = "Resolver error"
    equation = "th_meas = th + A (sin(th + ph) + sin(2 th - ph)/2)"
    side = "controller"
    signature = "tool error of one and two cycles per motor turn, constant in speed"
    way_in = "reading of the servo"

    amplitude: Array = parameter(
        "of the first harmonic, A, motor side", unit="rad", low=0.0, high=3e-3, source="1-10 arcmin of the motor"
    )
    phase: Array = parameter("phase at motor angle 0", unit="rad", low=-np.pi, high=np.pi, source="chosen", null=None)

    def error(self, motor_angle: Array, motor_speed: Array) -> ResolverError:
        """Return the wave of both harmonics at the motor angle, and its rate."""
        first, second = motor_angle + self.phase, 2 * motor_angle - self.phase
        angle = self.amplitude * (np.sin(first) + np.sin(second) / 2)
        return ResolverError(angle=angle, speed=self.amplitude * (np.cos(first) + np.cos(second)) * motor_speed)


_EQUATIONS: tuple[type[Effect], ...] = (
    SlowStribeck,
    SlipElements,
    OneWayFriction,
    GearLosses,
    ColdOil,
    GearError,
    SmoothHysteresis,
    TorqueRipple,
    ResolverEccentricity,
)

EQUATIONS: Mapping[str, type[Effect]] = MappingProxyType({effect.name: effect for effect in _EQUATIONS})
"""Every equation by name."""
