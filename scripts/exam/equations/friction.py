"""Friction of the motor in other equations than those of the library."""

from typing import Any

import numpy as np

from ffgym.core.types import Array
from ffgym.effects import State, Torques
from ffgym.robot.friction import advance_slip
from scripts.exam.equations.frame import Torque, Variant, any_phase, bending_speed, shape, size, two_waves

_WIDTHS = np.array([0.25, 0.5, 0.75, 1.0])
"""Where elements of Maxwell slip break loose, in units of the last one; chosen: even."""

_LONG = 10.0
"""Rest [s] at which the breakaway torque has grown by its share; also what a machine at rest has rested."""

_POLE = -95.0
"""Temperature [degC] in Vogel's law at which oil would be solid; chosen, near that of mineral gear oils."""


class Friction(Variant, Torque):
    """A torque of friction."""

    needs_friction = True


class FallingCoulomb(
    Friction, of="coulomb_level", equation=r"\tau_f \mathrel{+}= a f_c\, (1 + |v| / v_w)^{-1/10}\, s(v)"
):
    """Coulomb friction that falls slowly with speed: seals lift off a little where they slide fast."""

    share: Array = size("a, of the Coulomb torque", "1", -0.3, 0.3, "as coulomb_level")
    speed: Array = bending_speed("v_w", 3.0, 30.0)

    def _torque(self, s: State) -> Array:
        level = self.share * s.coulomb * (1 + np.abs(s.motor_speed) / self.speed) ** -0.1
        return -level * s.friction_sign


class PowerViscous(
    Friction, of="viscous_level", equation=r"\tau_f \mathrel{+}= a f_v v_r\, |v / v_r|^p\, \mathrm{sgn}(v)"
):
    """Viscous friction by a power law: the drag of grease, as non-Newtonian fluids follow."""

    share: Array = size("a, of viscous friction at speed v_r", "1", -0.5, 0.5, "as viscous_level")
    exponent: Array = shape("p", "1", 0.85, 1.15, "chosen: near 1", minimum=0.1)
    speed: Array = bending_speed("v_r", 10.0, 30.0, source="chosen: fast motions")

    def _torque(self, s: State) -> Array:
        v = s.motor_speed
        drag = self.speed * np.abs(v / self.speed) ** self.exponent * np.sign(v)
        return -self.share * s.viscous * drag


def _height() -> Any:
    return size("a, of the Coulomb torque", "1", 0.0, 1.0, "as stribeck_peak", minimum=0.0)


def _width(high: float) -> Any:
    return shape("w, of the Stribeck velocity", "1", 0.7, high, "chosen: near 1", minimum=0.01)


class TanhStribeck(
    Friction, of="stribeck_peak", equation=r"\tau_f \mathrel{+}= a f_c\, (1 - \tanh(|v| / (w v_s)))\, s(v)"
):
    """Stribeck peak as a hyperbolic tangent: a second one on top of the described one.

    Reference:
        Makkar, Dixon, Sawyer, Hu (2005), IEEE/ASME AIM: a continuously differentiable friction model.
    """

    share: Array = _height()
    width: Array = _width(2.0)

    def _torque(self, s: State) -> Array:
        x = np.abs(s.motor_speed) / (self.width * s.stribeck_velocity)
        peak = self.share * s.coulomb * (1 - np.tanh(x))
        return -peak * s.friction_sign


class LorentzStribeck(
    Friction, of="stribeck_peak", equation=r"\tau_f \mathrel{+}= a f_c\, s(v) / (1 + (v / (w v_s))^2)"
):
    """Stribeck peak as a Lorentz curve: the same as a Lorentz curve, whose skirts are wide."""

    share: Array = _height()
    width: Array = _width(1.3)

    def _torque(self, s: State) -> Array:
        x = s.motor_speed / (self.width * s.stribeck_velocity)
        return -self.share * s.coulomb / (1 + x * x) * s.friction_sign


class MaxwellSlip(
    Friction,
    of="presliding",
    equation=r"\tau_f \mathrel{+}= a f_c \left( \tfrac14 \sum_i x_i / \Delta_i - s(v) \right), \quad "
    r"\dot x_i = v,\; |x_i| \le \Delta_i",
):
    r"""Presliding by Maxwell slip: springs that break loose one after the other carry a share, not bristles.

    In sliding both carry the same. Stiffer than the bristles if they break loose earlier than these.

    Reference:
        Al-Bender, Lampaert, Swevers (2005), IEEE TAC 50(11): generalised Maxwell slip, without its dynamics in sliding.
    """

    share: Array = size("a, of the Coulomb torque", "1", 0.0, 0.8, "chosen: most of it", minimum=0.0, maximum=1.0)
    travel: Array = shape(
        "travel at which the last element slips, motor side",
        "rad",
        0.02,
        0.06,
        "chosen: wider than the bristles of the built-in robots, 8 mrad",
        minimum=1e-6,
    )

    def initial_memory(self, state: State) -> Array:
        """Elements at rest carry nothing; shape (..., N, 4)."""
        return np.zeros((*state.motor_angle.shape, len(_WIDTHS)))

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        carried = (memory[..., 0] + memory[..., 1] + memory[..., 2] + memory[..., 3]) / len(_WIDTHS)
        later = advance_slip(memory, state.motor_speed, state.motor_speed, dt, self.travel[..., None] * _WIDTHS)
        return Torques(motor=-self.share * state.coulomb * (carried - state.friction_sign)), later


class OneWaySeal(Friction, of="asymmetry", equation=r"\tau_f \mathrel{+}= a f_c\, s^2\, (1 + |v| / v_a)^{-1/5}"):
    """Friction that depends on direction, less at speed: a lip seal, pressed on one way and lifted the other."""

    share: Array = size("a, of the Coulomb torque", "1", -0.2, 0.2, "as asymmetry")
    speed: Array = bending_speed("v_a", 3.0, 30.0)

    def _torque(self, s: State) -> Array:
        fading = (1 + np.abs(s.motor_speed) / self.speed) ** -0.2
        return -self.share * s.coulomb * s.friction_sign**2 * fading


class DirectionalEfficiency(
    Friction,
    of="load_friction",
    equation=r"\tau_f \mathrel{+}= \mu\, (1 + k e^{-|v / v_s|}) \left( \tfrac{1 + r}{2} |\tau_l| s + "
    r"\tfrac{1 - r}{2} \tau_l |s| \right) / n",
    needs_elasticity=True,
):
    """Efficiency by direction of power: a share of the load is lost, more where the load drives, and at low speed.

    The motor drives if load and speed have one sign. It takes energy at any sign, as r >= 0.
    """

    share: Array = size("mu, lost where the motor drives", "1", 0.0, 0.15, "as load_friction", minimum=0.0)
    ratio: Array = shape("r, of what is lost where the load drives", "1", 1.0, 1.6, minimum=0.0)
    slow: Array = shape("k, more at low speed", "1", 0.0, 0.5, minimum=0.0)

    def _torque(self, s: State) -> Array:
        load, sign = s.load_at_motor, s.friction_sign
        both = (1 + self.ratio) / 2 * np.abs(load) * sign + (1 - self.ratio) / 2 * load * np.abs(sign)
        slow = 1 + self.slow * np.exp(-np.abs(s.motor_speed / s.stribeck_velocity))
        return -self.share * slow * both


class VogelOil(
    Friction,
    of="temperature_friction",
    equation=r"\tau_f \mathrel{+}= c f_v \left( e^{B / (T - T_\infty) - B / (T_r - T_\infty)} - 1 \right) v",
):
    """Viscosity of oil by Vogel's law: viscosity tables follow it; the description holds in a cold room.

    Reference:
        Vogel (1921), Physikalische Zeitschrift 22.
    """

    share: Array = size("c, of viscous friction that is oil", "1", 0.0, 1.0, minimum=0.0, maximum=1.0)
    vogel: Array = shape("B", "K", 600.0, 1200.0, "mineral gear oils", minimum=0.0)
    reference: Array = shape(
        "T_r, temperature at which the description holds", "degC", 20.0, 60.0, "chosen: that of the room", default=20.0
    )

    def _torque(self, s: State) -> Array:
        exponent = self.vogel * (1 / (s.temperature - _POLE) - 1 / (self.reference - _POLE))
        return -self.share * s.viscous * np.expm1(exponent) * s.motor_speed


class ShearThinning(Friction, of="nonlinear_viscous", equation=r"\tau_f \mathrel{+}= a f_v v\, |v| / (v_0 + |v|)"):
    """Viscosity that saturates with the shear rate: grease gets thinner, or thicker, where it is sheared fast."""

    share: Array = size("a, of viscous friction at high speed", "1", -0.6, 0.6, "chosen: half of it thins")
    speed: Array = bending_speed("v_0", 100.0, 400.0)

    def _torque(self, s: State) -> Array:
        v, fast = s.motor_speed, np.abs(s.motor_speed)
        return -self.share * s.viscous * v * fast / (self.speed + fast)


class TwoWaveFriction(
    Friction, of="position_friction", equation=r"\tau_f \mathrel{+}= a f_c\, w(k q + \varphi)\, s(v)"
):
    """Position-dependent friction of two waves: friction of planets and cage, which pass at rates of their own."""

    share: Array = size("a, of the Coulomb torque", "1", 0.0, 0.2, "as position_friction", minimum=0.0, maximum=0.7)
    cycles: Array = shape("k, per radian of the joint", "1/rad", 5.0, 40.0, minimum=0.0, role="cycles")
    phase: Array = any_phase()

    def _torque(self, s: State) -> Array:
        level = self.share * s.coulomb * two_waves(self.cycles * s.joint_angle + self.phase)
        return -level * s.friction_sign


class RateAndState(
    Friction,
    of="dwell_stiction",
    equation=r"\tau_f \mathrel{+}= a f_s \frac{\ln(1 + \theta / t_0)}{\ln(1 + 10\,\mathrm{s} / t_0)}\, s(v), \quad "
    r"\dot\theta = 1 - \theta\, |v| / x_s",
):
    r"""Breakaway that grows with the logarithm of the time of rest: contacts age, and slip renews them.

    The memory :math:`\theta` is the age of the contacts [s]; the exact solution at constant speed is taken.

    Reference:
        Dieterich (1979), J. Geophys. Res. 84(B5): rate- and state-dependent friction with its ageing law.
    """

    share: Array = size(
        "a, of the breakaway torque, after ten seconds of rest", "1", 0.0, 0.5, "as dwell_stiction", minimum=0.0
    )
    time: Array = shape("t_0, rest after which growth is felt", "s", 0.05, 0.5, minimum=1e-3)
    slip: Array = shape(
        "x_s, slip that renews contacts, motor side", "rad", 0.005, 0.05, "as dwell_stiction", minimum=1e-5
    )

    def initial_memory(self, state: State) -> Array:
        """Contacts of a machine at rest are old."""
        return np.full((*state.motor_angle.shape, 1), _LONG)

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        age, rate = memory[..., 0], np.abs(state.motor_speed) / self.slip
        decay = rate * dt
        passed = np.where(decay > 0, -np.expm1(-decay) / np.where(rate > 0, rate, 1.0), dt)
        grown = np.log1p(age / self.time) / np.log1p(_LONG / self.time)
        torque = -self.share * state.static * grown * state.friction_sign
        return Torques(motor=torque), (age * np.exp(-decay) + passed)[..., None]
