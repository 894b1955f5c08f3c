"""Outside the library: torques that follow the clock, another joint, or one place along the joint."""

import numpy as np

from ffgym.core.types import Array
from ffgym.effects import State
from scripts.exam.equations.frame import Outsider, any_phase, shape, size, sum_of_others

_KNOT = 0.25
"""Time between the random values that a drift passes through [s]; chosen: seconds, as of a current sensor's drift."""

_SCRAMBLE = 43758.5453
"""Factor that leaves of a sine only digits without order: the usual hash of shaders, elementwise and without state."""

_ANGLE = ("angle", "position")
_SPEED = ("speed", "velocity")


class FloorVibration(Outsider, equation=r"\tau \mathrel{+}= a f_c \sin(2 \pi f t + \varphi)"):
    """Torque at a frequency of the surroundings: a press nearby shakes the floor, and one motor's feedback."""

    share: Array = size("a, of the Coulomb torque", "1", 0.0, 0.2, minimum=0.0)
    frequency: Array = shape("f", "Hz", 10.0, 30.0, "mains and presses", minimum=0.0)
    phase: Array = any_phase()

    def line(self) -> Array:
        """See base class."""
        return self.frequency

    def _torque(self, s: State) -> Array:
        return self.share * s.coulomb * np.sin(2 * np.pi * self.frequency * s.time + self.phase)


class SwitchedLoad(Outsider, equation=r"\tau \mathrel{+}= a f_c \tanh(6 \sin 2 \pi f t)"):
    """Torque that switches with the clock: a pump or fan goes on and off in turns, and pulls at one motor."""

    share: Array = size("a, of the Coulomb torque", "1", 0.0, 0.2, minimum=0.0)
    frequency: Array = shape("f", "Hz", 0.5, 3.0, minimum=0.0)

    def line(self) -> Array:
        """See base class."""
        return self.frequency

    def _torque(self, s: State) -> Array:
        return self.share * s.coulomb * np.tanh(6 * np.sin(2 * np.pi * self.frequency * s.time))


class Shocks(Outsider, equation=r"\tau \mathrel{+}= a f_c\, e^{-((t \bmod T) - T/2)^2 / w^2}"):
    """Torque pulses at even times: something strikes the arm at even times."""

    share: Array = size("a, of the Coulomb torque", "1", 0.0, 1.0, minimum=0.0)
    period: Array = shape("T", "s", 0.4, 1.5, minimum=1e-2)
    width: Array = shape("w", "s", 0.02, 0.06, "chosen: a blow", minimum=1e-4)

    def line(self) -> Array:
        """See base class."""
        return 1 / self.period

    def _torque(self, s: State) -> Array:
        since = (np.mod(s.time, self.period) - self.period / 2) / self.width
        return self.share * s.coulomb * np.exp(-since * since)


class WanderingTorque(
    Outsider, equation=r"\tau \mathrel{+}= a f_c\, r(t), \quad r(k\, T) \in [-1, 1] \text{ by chance}"
):
    """Torque that wanders by chance: no variable explains its values, with smooth ways between them."""

    share: Array = size("a, of the Coulomb torque", "1", 0.0, 0.3, minimum=0.0)
    draw: Array = shape("which of all ways", "1", 0.0, 1.0, "any")

    def _torque(self, s: State) -> Array:
        knot = np.floor(s.time / _KNOT)
        part = s.time / _KNOT - knot
        blend = part * part * (3 - 2 * part)
        value = (1 - blend) * self._value(knot) + blend * self._value(knot + 1)
        return self.share * s.coulomb * value

    def _value(self, knot: Array) -> Array:
        """A number in [-1, 1] that looks like chance, for each whole number."""
        digits = _SCRAMBLE * np.sin(12.9898 * knot + 78.233 * self.draw)
        value: Array = 2 * (digits - np.floor(digits)) - 1
        return value


class RunningIn(Outsider, equation=r"\tau_f \mathrel{+}= a f_c\, e^{-t / t_0}\, s(v)"):
    """Friction that fades along each motion: grease spreads again; no matter of temperature."""

    share: Array = size("a, of the Coulomb torque", "1", 0.0, 0.6, minimum=0.0)
    time: Array = shape("t_0", "s", 2.0, 5.0, minimum=1e-2)

    def _torque(self, s: State) -> Array:
        level = self.share * s.coulomb * np.exp(-s.time / self.time)
        return -level * s.friction_sign


class RubbingHose(
    Outsider, equation=r"\tau_i \mathrel{+}= f_{c,i} \sum_j a_{ij} \sin(6 q_j + \varphi_i)", words=_ANGLE
):
    """Torque by the angle of another joint: a hose along the arm pulls at one joint where another joint bends it."""

    share: Array = size("a_ij", "1", -0.3, 0.3, per="pair")
    phase: Array = any_phase()

    def _torque(self, s: State) -> Array:
        sine = sum_of_others(self.share, np.sin(6 * s.joint_angle))
        cosine = sum_of_others(self.share, np.cos(6 * s.joint_angle))
        return s.coulomb * (sine * np.cos(self.phase) + cosine * np.sin(self.phase))


class StirredOil(Outsider, equation=r"\tau_i \mathrel{+}= f_{c,i} \sum_j a_{ij} v_j^2 / (v_r^2 + v_j^2)", words=_SPEED):
    """Torque by the speed of another joint, whatever its direction: oil that one gear stirs pushes another."""

    share: Array = size("a_ij", "1", -0.3, 0.3, per="pair")
    speed: Array = shape("v_r", "rad/s", 5.0, 15.0, minimum=1e-3)

    def _torque(self, s: State) -> Array:
        total = np.zeros_like(s.motor_speed)
        for j in range(total.shape[-1]):
            square = s.motor_speed[..., j : j + 1] * s.motor_speed[..., j : j + 1]
            total = total + self.share[..., :, j] * square / (self.speed * self.speed + square)
        return s.coulomb * total


class SharedSeal(
    Outsider, equation=r"\tau_{f,i} \mathrel{+}= f_{c,i}\, s(v_i) \sum_j a_{ij} |v_j| / (v_r + |v_j|)", words=_SPEED
):
    """Friction by the speed of another joint: a seal between two shafts."""

    share: Array = size("a_ij", "1", 0.0, 0.4, minimum=0.0, per="pair")
    speed: Array = shape("v_r", "rad/s", 5.0, 15.0, minimum=1e-3)

    def _torque(self, s: State) -> Array:
        total = np.zeros_like(s.motor_speed)
        for j in range(total.shape[-1]):
            fast = np.abs(s.motor_speed[..., j : j + 1])
            total = total + self.share[..., :, j] * fast / (self.speed + fast)
        return -s.coulomb * s.friction_sign * total


class DamagedTooth(Outsider, equation=r"\tau_f \mathrel{+}= a f_c\, e^{-((q - q_0) / w)^2}\, s(v)", words=_ANGLE):
    """Friction at one place of the joint: it rubs there; no wave along the turn, as position_friction is."""

    share: Array = size("a, of the Coulomb torque", "1", 0.0, 1.0, minimum=0.0)
    place: Array = shape("q_0", "rad", -np.pi, np.pi, "within the motions")
    width: Array = shape("w", "rad", 0.004, 0.02, "chosen: a tooth", minimum=1e-5)

    def _torque(self, s: State) -> Array:
        off = (s.joint_angle - self.place) / self.width
        return -self.share * s.coulomb * np.exp(-off * off) * s.friction_sign
