"""Outside the library: torques that follow the clock, whatever the robot does."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects import State, Torques
from ffgym.effects.parameters import parameter
from scripts.exam.equations.variant import Clue, Outsider

_KNOT = 0.25
"""Time between the random values that a drift passes through [s]; chosen: seconds, as of a current sensor's drift."""

_SCRAMBLE = 43758.5453
"""Factor that leaves of a sine only digits without order: the usual hash of shaders, elementwise and without state."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class FloorVibration(Outsider):
    """A press nearby shakes the floor, and the controller's feedback of one motor with it."""

    name: ClassVar[str] = "floor_vibration"
    title: ClassVar[str] = "torque at a frequency of the surroundings"
    equation: ClassVar[str] = r"\tau \mathrel{+}= a f_c \sin(2 \pi f t + \varphi)"

    share: Array = parameter("a, of the Coulomb torque", unit="1", low=0.0, high=0.2, minimum=0.0, source="chosen")
    frequency: Array = parameter(
        "f", unit="Hz", null=None, low=10.0, high=30.0, minimum=0.0, source="mains and presses"
    )
    phase: Array = parameter("phi", unit="rad", null=None, low=0.0, high=2 * np.pi, source="any", role="phase")

    def clue(self, joints: tuple[str, ...], joint: str) -> Clue:
        """See base class."""
        return Clue(words=("time",), frequency=float(self.frequency[joints.index(joint)]))

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        wave = np.sin(2 * np.pi * self.frequency * state.time + self.phase)
        return Torques(motor=self.share * state.coulomb * wave), memory


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SwitchedLoad(Outsider):
    """A pump or fan that is switched on and off in turns, and pulls at one motor."""

    name: ClassVar[str] = "switched_load"
    title: ClassVar[str] = "torque that switches with the clock"
    equation: ClassVar[str] = r"\tau \mathrel{+}= a f_c \tanh(6 \sin 2 \pi f t)"

    share: Array = parameter("a, of the Coulomb torque", unit="1", low=0.0, high=0.2, minimum=0.0, source="chosen")
    frequency: Array = parameter("f", unit="Hz", null=None, low=0.5, high=3.0, minimum=0.0, source="chosen")

    def clue(self, joints: tuple[str, ...], joint: str) -> Clue:
        """See base class."""
        return Clue(words=("time",), frequency=float(self.frequency[joints.index(joint)]))

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        wave = np.tanh(6 * np.sin(2 * np.pi * self.frequency * state.time))
        return Torques(motor=self.share * state.coulomb * wave), memory


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Shocks(Outsider):
    """Something strikes the arm at even times."""

    name: ClassVar[str] = "shocks"
    title: ClassVar[str] = "torque pulses at even times"
    equation: ClassVar[str] = r"\tau \mathrel{+}= a f_c\, e^{-((t \bmod T) - T/2)^2 / w^2}"

    share: Array = parameter("a, of the Coulomb torque", unit="1", low=0.0, high=1.0, minimum=0.0, source="chosen")
    period: Array = parameter("T", unit="s", null=None, low=0.4, high=1.5, minimum=1e-2, source="chosen")
    width: Array = parameter("w", unit="s", null=None, low=0.02, high=0.06, minimum=1e-4, source="chosen: a blow")

    def clue(self, joints: tuple[str, ...], joint: str) -> Clue:
        """See base class."""
        return Clue(words=("time",), frequency=float(1 / self.period[joints.index(joint)]))

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        since = (np.mod(state.time, self.period) - self.period / 2) / self.width
        return Torques(motor=self.share * state.coulomb * np.exp(-since * since)), memory


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class WanderingTorque(Outsider):
    """A torque that wanders by chance: values that no variable explains, with smooth ways between them."""

    name: ClassVar[str] = "wandering_torque"
    title: ClassVar[str] = "torque that wanders by chance"
    equation: ClassVar[str] = r"\tau \mathrel{+}= a f_c\, r(t), \quad r(k\, T) \in [-1, 1] \text{ by chance}"

    share: Array = parameter("a, of the Coulomb torque", unit="1", low=0.0, high=0.3, minimum=0.0, source="chosen")
    draw: Array = parameter("which of all ways", unit="1", null=None, low=0.0, high=1.0, source="any")

    def clue(self, joints: tuple[str, ...], joint: str) -> Clue:
        """See base class."""
        return Clue(words=("time",))

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        knot = np.floor(state.time / _KNOT)
        part = state.time / _KNOT - knot
        blend = part * part * (3 - 2 * part)
        value = (1 - blend) * self._value(knot) + blend * self._value(knot + 1)
        return Torques(motor=self.share * state.coulomb * value), memory

    def _value(self, knot: Array) -> Array:
        """A number in [-1, 1] that looks like chance, for each whole number."""
        digits = _SCRAMBLE * np.sin(12.9898 * knot + 78.233 * self.draw)
        value: Array = 2 * (digits - np.floor(digits)) - 1
        return value


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RunningIn(Outsider):
    """Friction that is high when a motion begins and fades in it, as grease spreads again; not by temperature."""

    name: ClassVar[str] = "running_in"
    title: ClassVar[str] = "friction that fades along each motion"
    equation: ClassVar[str] = r"\tau_f \mathrel{+}= a f_c\, e^{-t / t_0}\, s(v)"

    share: Array = parameter("a, of the Coulomb torque", unit="1", low=0.0, high=0.6, minimum=0.0, source="chosen")
    time: Array = parameter("t_0", unit="s", null=None, low=2.0, high=5.0, minimum=1e-2, source="chosen")

    def clue(self, joints: tuple[str, ...], joint: str) -> Clue:
        """See base class."""
        return Clue(words=("time",))

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        level = self.share * state.coulomb * np.exp(-state.time / self.time)
        return Torques(motor=-level * state.friction_sign), memory
