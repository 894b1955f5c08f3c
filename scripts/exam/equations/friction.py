"""Friction of the motor in other equations than those of the library."""

from functools import partial

import numpy as np

from ffgym.core.types import Array
from ffgym.effects import State
from ffgym.robot.friction import advance_slip
from scripts.exam.equations.frame import any_phase, bending_speed, of_coulomb, shape, size, two_waves, variant

_WIDTHS = np.array([0.25, 0.5, 0.75, 1.0])
"""Deflections at which elements of Maxwell slip break loose, in units of the last one; chosen: even."""

_LONG = 10.0
"""Rest [s] at which the breakaway torque has grown by its share; also what a machine at rest has rested."""

_POLE = -95.0
"""Temperature [degC] in Vogel's law at which oil would be solid; chosen, near that of mineral gear oils."""

friction = partial(variant, needs_friction=True)


@friction("coulomb_level", r"\tau_f \mathrel{+}= a f_c\, (1 + |v| / v_w)^{-1/10}\, s(v)")
def falling_coulomb(
    s: State, share: Array = of_coulomb(-0.3, 0.3, "as coulomb_level"), speed: Array = bending_speed("v_w", 3.0, 30.0)
) -> Array:
    """Coulomb friction that falls slowly with speed: seals lift off a little where they slide fast."""
    level = share * s.coulomb * (1 + np.abs(s.motor_speed) / speed) ** -0.1
    return -level * s.friction_sign


@friction("viscous_level", r"\tau_f \mathrel{+}= a f_v v_r\, |v / v_r|^p\, \mathrm{sgn}(v)")
def power_viscous(
    s: State,
    share: Array = size("a, of viscous friction at speed v_r", "1", -0.5, 0.5, "as viscous_level"),
    exponent: Array = shape("p", "1", 0.85, 1.15, "chosen: near 1", minimum=0.1),
    speed: Array = bending_speed("v_r", 10.0, 30.0, source="chosen: fast motions"),
) -> Array:
    """Viscous friction by a power law: the drag of grease, as non-Newtonian fluids follow."""
    v = s.motor_speed
    drag = speed * np.abs(v / speed) ** exponent * np.sign(v)
    return -share * s.viscous * drag


@friction("stribeck_peak", r"\tau_f \mathrel{+}= a f_c\, (1 - \tanh(|v| / (w v_s)))\, s(v)")
def tanh_stribeck(
    s: State,
    share: Array = of_coulomb(0.0, 1.0, "as stribeck_peak", minimum=0.0),
    width: Array = shape("w, of the Stribeck velocity", "1", 0.7, 2.0, "chosen: near 1", minimum=0.01),
) -> Array:
    """Stribeck peak as a hyperbolic tangent: a second one on top of the described one.

    Reference:
        Makkar, Dixon, Sawyer, Hu (2005), IEEE/ASME AIM: a continuously differentiable friction model.
    """
    x = np.abs(s.motor_speed) / (width * s.stribeck_velocity)
    peak = share * s.coulomb * (1 - np.tanh(x))
    return -peak * s.friction_sign


@friction("stribeck_peak", r"\tau_f \mathrel{+}= a f_c\, s(v) / (1 + (v / (w v_s))^2)")
def lorentz_stribeck(
    s: State,
    share: Array = of_coulomb(0.0, 1.0, "as stribeck_peak", minimum=0.0),
    width: Array = shape("w, of the Stribeck velocity", "1", 0.7, 1.3, "chosen: near 1", minimum=0.01),
) -> Array:
    """Stribeck peak as a Lorentz curve: the same as a Lorentz curve, whose skirts are wide."""
    x = s.motor_speed / (width * s.stribeck_velocity)
    return -share * s.coulomb / (1 + x * x) * s.friction_sign


@friction(
    "presliding",
    r"\tau_f \mathrel{+}= a f_c \left( \tfrac14 \sum_i x_i / \Delta_i - s(v) \right), \quad "
    r"\dot x_i = v,\; |x_i| \le \Delta_i",
    start=lambda state: np.zeros((*state.motor_angle.shape, len(_WIDTHS))),
)
def maxwell_slip(
    s: State,
    memory: Array,
    dt: float,
    share: Array = of_coulomb(0.0, 0.8, "chosen: most of it", minimum=0.0, maximum=1.0),
    travel: Array = shape(
        "travel at which the last element slips, motor side",
        "rad",
        0.02,
        0.06,
        "chosen: wider than the bristles of the built-in robots, 8 mrad",
        minimum=1e-6,
    ),
) -> tuple[Array, Array]:
    r"""Presliding by Maxwell slip: springs that break loose one after the other carry a share, not bristles.

    In sliding both carry the same. Stiffer than the bristles if they break loose earlier than these. The memory is how
    far each is wound, shape (..., N, 4).

    Reference:
        Al-Bender, Lampaert, Swevers (2005), IEEE TAC 50(11): generalised Maxwell slip, without its dynamics in sliding.
    """
    carried = (memory[..., 0] + memory[..., 1] + memory[..., 2] + memory[..., 3]) / len(_WIDTHS)
    later = advance_slip(memory, s.motor_speed, s.motor_speed, dt, travel[..., None] * _WIDTHS)
    return -share * s.coulomb * (carried - s.friction_sign), later


@friction("asymmetry", r"\tau_f \mathrel{+}= a f_c\, s^2\, (1 + |v| / v_a)^{-1/5}")
def one_way_seal(
    s: State, share: Array = of_coulomb(-0.2, 0.2, "as asymmetry"), speed: Array = bending_speed("v_a", 3.0, 30.0)
) -> Array:
    """Friction that depends on direction, less at speed: a lip seal, pressed on one way and lifted the other."""
    fading = (1 + np.abs(s.motor_speed) / speed) ** -0.2
    return -share * s.coulomb * s.friction_sign**2 * fading


@friction(
    "load_friction",
    r"\tau_f \mathrel{+}= \mu\, (1 + k e^{-|v / v_s|}) \left( \tfrac{1 + r}{2} |\tau_l| s + "
    r"\tfrac{1 - r}{2} \tau_l |s| \right) / n",
    needs_elasticity=True,
)
def directional_efficiency(
    s: State,
    share: Array = size("mu, lost where the motor drives", "1", 0.0, 0.15, "as load_friction", minimum=0.0),
    ratio: Array = shape("r, of what is lost where the load drives", "1", 1.0, 1.6, minimum=0.0),
    slow: Array = shape("k, more at low speed", "1", 0.0, 0.5, minimum=0.0),
) -> Array:
    """Efficiency by direction of power: a share of the load is lost, more where the load drives, and at low speed.

    The motor drives if load and speed have one sign. It takes energy at any sign, as r >= 0.
    """
    load, sign = s.load_at_motor, s.friction_sign
    both = (1 + ratio) / 2 * np.abs(load) * sign + (1 - ratio) / 2 * load * np.abs(sign)
    return -share * (1 + slow * np.exp(-np.abs(s.motor_speed / s.stribeck_velocity))) * both


@friction(
    "temperature_friction",
    r"\tau_f \mathrel{+}= c f_v \left( e^{B / (T - T_\infty) - B / (T_r - T_\infty)} - 1 \right) v",
)
def vogel_oil(
    s: State,
    share: Array = size("c, of viscous friction that is oil", "1", 0.0, 1.0, minimum=0.0, maximum=1.0),
    vogel: Array = shape("B", "K", 600.0, 1200.0, "mineral gear oils", minimum=0.0),
    reference: Array = shape(
        "T_r, temperature at which the description holds", "degC", 20.0, 60.0, "chosen: that of the room", default=20.0
    ),
) -> Array:
    """Viscosity of oil by Vogel's law: viscosity tables follow it; the description holds in a cold room.

    Reference:
        Vogel (1921), Physikalische Zeitschrift 22.
    """
    exponent = vogel * (1 / (s.temperature - _POLE) - 1 / (reference - _POLE))
    return -share * s.viscous * np.expm1(exponent) * s.motor_speed


@friction("nonlinear_viscous", r"\tau_f \mathrel{+}= a f_v v\, |v| / (v_0 + |v|)")
def shear_thinning(
    s: State,
    share: Array = size("a, of viscous friction at high speed", "1", -0.6, 0.6, "chosen: half of it thins"),
    speed: Array = bending_speed("v_0", 100.0, 400.0),
) -> Array:
    """Viscosity that saturates with the shear rate: grease gets thinner, or thicker, where it is sheared fast."""
    v, fast = s.motor_speed, np.abs(s.motor_speed)
    return -share * s.viscous * v * fast / (speed + fast)


@friction("position_friction", r"\tau_f \mathrel{+}= a f_c\, w(k q + \varphi)\, s(v)")
def two_wave_friction(
    s: State,
    share: Array = of_coulomb(0.0, 0.2, "as position_friction", minimum=0.0, maximum=0.7),
    cycles: Array = shape("k, per radian of the joint", "1/rad", 5.0, 40.0, minimum=0.0, role="cycles"),
    phase: Array = any_phase(),
) -> Array:
    """Position-dependent friction of two waves: friction of planets and cage, which pass at rates of their own."""
    level = share * s.coulomb * two_waves(cycles * s.joint_angle + phase)
    return -level * s.friction_sign


@friction(
    "dwell_stiction",
    r"\tau_f \mathrel{+}= a f_s \frac{\ln(1 + \theta / t_0)}{\ln(1 + 10\,\mathrm{s} / t_0)}\, s(v), \quad "
    r"\dot\theta = 1 - \theta\, |v| / x_s",
    start=lambda state: np.full((*state.motor_angle.shape, 1), _LONG),
)
def rate_and_state(
    s: State,
    memory: Array,
    dt: float,
    share: Array = size(
        "a, of the breakaway torque, after ten seconds of rest", "1", 0.0, 0.5, "as dwell_stiction", minimum=0.0
    ),
    time: Array = shape("t_0, rest after which growth is felt", "s", 0.05, 0.5, minimum=1e-3),
    slip: Array = shape(
        "x_s, slip that renews contacts, motor side", "rad", 0.005, 0.05, "as dwell_stiction", minimum=1e-5
    ),
) -> tuple[Array, Array]:
    r"""Breakaway that grows with the logarithm of the time of rest: contacts age, and slip renews them.

    The memory :math:`\theta` is the age of the contacts [s]; the exact solution at constant speed is taken. Contacts of
    a machine at rest are old.

    Reference:
        Dieterich (1979), J. Geophys. Res. 84(B5): rate- and state-dependent friction with its ageing law.
    """
    age, rate = memory[..., 0], np.abs(s.motor_speed) / slip
    decay = rate * dt
    passed = np.where(decay > 0, -np.expm1(-decay) / np.where(rate > 0, rate, 1.0), dt)
    grown = np.log1p(age / time) / np.log1p(_LONG / time)
    return -share * s.static * grown * s.friction_sign, (age * np.exp(-decay) + passed)[..., None]
