"""Outside the library: torques that follow the clock, another joint, or one place along the joint."""

import numpy as np

from ffgym.core.types import Array
from ffgym.effects import State
from scripts.exam.equations.frame import any_phase, of_coulomb, outsider, shape, size, sum_of_others

_KNOT = 0.25
"""Time between the random values that a drift passes through [s]; chosen: seconds, as of a current sensor's drift."""

_SCRAMBLE = 43758.5453
"""Factor that leaves of a sine only digits without order: the usual hash of shaders, elementwise and without state."""

_ANGLE = ("angle", "position")
_SPEED = ("speed", "velocity")


@outsider(r"\tau \mathrel{+}= a f_c \sin(2 \pi f t + \varphi)")
def floor_vibration(
    s: State,
    share: Array = of_coulomb(0.0, 0.2, minimum=0.0),
    frequency: Array = shape("f", "Hz", 10.0, 30.0, "mains and presses", minimum=0.0),
    phase: Array = any_phase(),
) -> Array:
    """Torque at a frequency of the surroundings: a press nearby shakes the floor, and one motor's feedback."""
    return share * s.coulomb * np.sin(2 * np.pi * frequency * s.time + phase)


@outsider(r"\tau \mathrel{+}= a f_c \tanh(6 \sin 2 \pi f t)")
def switched_load(
    s: State,
    share: Array = of_coulomb(0.0, 0.2, minimum=0.0),
    frequency: Array = shape("f", "Hz", 0.5, 3.0, minimum=0.0),
) -> Array:
    """Torque that switches with the clock: a pump or fan goes on and off in turns, and pulls at one motor."""
    return share * s.coulomb * np.tanh(6 * np.sin(2 * np.pi * frequency * s.time))


@outsider(r"\tau \mathrel{+}= a f_c\, e^{-((t \bmod T) - T/2)^2 / w^2}")
def shocks(
    s: State,
    share: Array = of_coulomb(0.0, 1.0, minimum=0.0),
    period: Array = shape("T", "s", 0.4, 1.5, minimum=1e-2),
    width: Array = shape("w", "s", 0.02, 0.06, "chosen: a blow", minimum=1e-4),
) -> Array:
    """Torque pulses at even times: something strikes the arm at even times."""
    since = (np.mod(s.time, period) - period / 2) / width
    return share * s.coulomb * np.exp(-since * since)


@outsider(r"\tau \mathrel{+}= a f_c\, r(t), \quad r(k\, T) \in [-1, 1] \text{ by chance}")
def wandering_torque(
    s: State,
    share: Array = of_coulomb(0.0, 0.3, minimum=0.0),
    draw: Array = shape("which of all ways", "1", 0.0, 1.0, "any"),
) -> Array:
    """Torque that wanders by chance: no variable explains its values, with smooth ways between them."""

    def value(knot: Array) -> Array:
        """A number in [-1, 1] that looks like chance, for each whole number."""
        digits = _SCRAMBLE * np.sin(12.9898 * knot + 78.233 * draw)
        return np.asarray(2 * (digits - np.floor(digits)) - 1)

    knot = np.floor(s.time / _KNOT)
    part = s.time / _KNOT - knot
    blend = part * part * (3 - 2 * part)
    return share * s.coulomb * ((1 - blend) * value(knot) + blend * value(knot + 1))


@outsider(r"\tau_f \mathrel{+}= a f_c\, e^{-t / t_0}\, s(v)")
def running_in(
    s: State, share: Array = of_coulomb(0.0, 0.6, minimum=0.0), time: Array = shape("t_0", "s", 2.0, 5.0, minimum=1e-2)
) -> Array:
    """Friction that fades along each motion: grease spreads again; no matter of temperature."""
    level = share * s.coulomb * np.exp(-s.time / time)
    return -level * s.friction_sign


@outsider(r"\tau_i \mathrel{+}= f_{c,i} \sum_j a_{ij} \sin(6 q_j + \varphi_i)", _ANGLE)
def rubbing_hose(
    s: State, share: Array = size("a_ij", "1", -0.3, 0.3, per="pair"), phase: Array = any_phase()
) -> Array:
    """Torque by the angle of another joint: a hose along the arm pulls at one joint where another joint bends it."""
    sine = sum_of_others(share, np.sin(6 * s.joint_angle))
    cosine = sum_of_others(share, np.cos(6 * s.joint_angle))
    return s.coulomb * (sine * np.cos(phase) + cosine * np.sin(phase))


@outsider(r"\tau_i \mathrel{+}= f_{c,i} \sum_j a_{ij} v_j^2 / (v_r^2 + v_j^2)", _SPEED)
def stirred_oil(
    s: State,
    share: Array = size("a_ij", "1", -0.3, 0.3, per="pair"),
    speed: Array = shape("v_r", "rad/s", 5.0, 15.0, minimum=1e-3),
) -> Array:
    """Torque by the speed of another joint, whatever its direction: oil that one gear stirs pushes another."""
    total = np.zeros_like(s.motor_speed)
    for j in range(total.shape[-1]):
        square = s.motor_speed[..., j : j + 1] * s.motor_speed[..., j : j + 1]
        total = total + share[..., :, j] * square / (speed * speed + square)
    return s.coulomb * total


@outsider(r"\tau_{f,i} \mathrel{+}= f_{c,i}\, s(v_i) \sum_j a_{ij} |v_j| / (v_r + |v_j|)", _SPEED)
def shared_seal(
    s: State,
    share: Array = size("a_ij", "1", 0.0, 0.4, minimum=0.0, per="pair"),
    speed: Array = shape("v_r", "rad/s", 5.0, 15.0, minimum=1e-3),
) -> Array:
    """Friction by the speed of another joint: a seal between two shafts."""
    total = np.zeros_like(s.motor_speed)
    for j in range(total.shape[-1]):
        fast = np.abs(s.motor_speed[..., j : j + 1])
        total = total + share[..., :, j] * fast / (speed + fast)
    return -s.coulomb * s.friction_sign * total


@outsider(r"\tau_f \mathrel{+}= a f_c\, e^{-((q - q_0) / w)^2}\, s(v)", _ANGLE)
def damaged_tooth(
    s: State,
    share: Array = of_coulomb(0.0, 1.0, minimum=0.0),
    place: Array = shape("q_0", "rad", -np.pi, np.pi, "within the motions"),
    width: Array = shape("w", "rad", 0.004, 0.02, "chosen: a tooth", minimum=1e-5),
) -> Array:
    """Friction at one place of the joint: it rubs there; no wave along the turn, as position_friction is."""
    off = (s.joint_angle - place) / width
    return -share * s.coulomb * np.exp(-off * off) * s.friction_sign
