"""Frame of an exam's equations: a function of the state and of its numbers, which are its arguments, is an effect."""

from collections.abc import Callable
from dataclasses import dataclass
from inspect import Parameter, signature
from typing import Any, ClassVar

import numpy as np

from ffgym.core.types import Array
from ffgym.effects import Effect, NativeEffect, ResolverEffect, ResolverError, State, TorqueEffect, Torques, parameter
from ffgym.robot import RobotDescription

Formula = Callable[..., Any]
"""Torque [N m], shape (..., N), of a state and of numbers that have `size` or `shape` as defaults; where the effect has
a memory, torque and later memory of state, memory and time step."""


class Equation(Effect):
    """An effect in an equation of its own, made of a function by `variant` or `outsider`."""

    formula: ClassVar[Formula]
    numbers: ClassVar[tuple[str, ...]]
    """Names of its parameters."""

    def _of(self, *seen: Any) -> Any:
        """The formula with the effect's own numbers."""
        return type(self).formula(*seen, **{name: getattr(self, name) for name in self.numbers})


class Variant(Equation):
    """An effect of the library in an equation of its own, so that who fits the library's meets a foreign one."""

    variant_of: ClassVar[str]
    """Name of the effect that a diagnosis should give."""
    signature: ClassVar[str] = "as of the effect that it is a variant of"


@dataclass(frozen=True, kw_only=True)
class Clue:
    """Answer that is asked for an effect that no library holds."""

    words: tuple[str, ...]
    """One of them must stand in the variable that a pattern names."""
    joint: str | None = None
    """Whose variable that is; None is that of no joint, as time is."""
    frequency: float | None = None
    """[Hz], of a line in time; a multiple of it is right, too. None if there is none."""


class Outsider(Equation):
    """An effect that no effect of the library can express, of a size `share`."""

    signature: ClassVar[str] = "only in patterns of the residual"
    words: ClassVar[tuple[str, ...]]
    """Words of the clue, see `Clue`."""
    share: Array

    def clue(self, joints: tuple[str, ...], joint: str) -> Clue:
        """Make the clue of the effect on `joint` of a robot with these `joints`."""
        row = joints.index(joint)
        if self.words == TIME:
            line = 1 / self.period if hasattr(self, "period") else getattr(self, "frequency", None)
            return Clue(words=self.words, frequency=None if line is None else float(line[row]))
        of_others = self.share.ndim == 2
        return Clue(words=self.words, joint=joints[int(np.argmax(np.abs(self.share[row])))] if of_others else joint)


TIME = ("time",)

VARIANTS: dict[str, type[Variant]] = {}
"""Effects of the library in other equations, by name; their order is that of the questions of an exam."""

OUTSIDERS: dict[str, type[Outsider]] = {}
"""Effects that the library cannot express, by name, in the order of the questions."""


class _ByTorque(Equation, TorqueEffect):
    way_in: ClassVar[str] = "torque at every physics step"
    acts_on: ClassVar[str]
    """Field of `Torques`, if the formula does not give all of them."""
    start: ClassVar[Formula | None]
    """Memory of a state at rest; None remembers nothing."""

    def initial_memory(self, state: State) -> Array:
        """Return the memory of the equation at rest."""
        return super().initial_memory(state) if self.start is None else np.asarray(type(self).start(state))  # type: ignore[misc]

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """Evaluate the equation for all joints, and move its memory on."""
        found = self._of(state) if self.start is None else self._of(state, memory, dt)
        torque, later = (found, memory) if self.start is None else found
        return torque if isinstance(torque, Torques) else Torques(**{self.acts_on: torque}), later


class _InDescription(Equation, NativeEffect):
    def in_description(self, robot: RobotDescription) -> RobotDescription:
        """Return the robot with the numbers that the equation gives."""
        changed: RobotDescription = self._of(robot)
        return changed


class _ByResolver(Equation, ResolverEffect):
    way_in: ClassVar[str] = "reading of the servo"

    def error(self, motor_angle: Array, motor_speed: Array) -> ResolverError:
        """Evaluate the error of the resolver angle."""
        angle, speed = self._of(motor_angle, motor_speed)
        return ResolverError(angle=angle, speed=speed)


_WAYS: dict[str, type[Equation]] = {"torque": _ByTorque, "description": _InDescription, "resolver": _ByResolver}


def variant(of: str, equation: str, by: str = "torque", **about: Any) -> Callable[[Formula], type[Variant]]:
    """Declare a function to be an effect `of` the library in another equation.

    Args:
        of: name of the library's effect.
        equation: what is added to which equation.
        by: the function's value: a 'torque', another 'description', or errors of angle and speed of a 'resolver'.
        about: other class variables, e.g. `side`, `acts_on` and `start`.
    """

    def declare(formula: Formula) -> type[Variant]:
        found = _effect_of(formula, (Variant, _WAYS[by]), equation=equation, variant_of=of, **about)
        return VARIANTS.setdefault(found.name, found)

    return declare


def outsider(equation: str, words: tuple[str, ...] = TIME) -> Callable[[Formula], type[Outsider]]:
    """Declare a torque to be an effect that the library cannot express; `words` are those of its clue."""

    def declare(formula: Formula) -> type[Outsider]:
        found = _effect_of(formula, (Outsider, _ByTorque), equation=equation, words=words)
        return OUTSIDERS.setdefault(found.name, found)

    return declare


def _effect_of(formula: Formula, bases: tuple[type, ...], **about: Any) -> Any:
    """Class of an effect, whose title the docstring of its function begins with."""
    given = signature(formula).parameters
    numbers = {name: each.default for name, each in given.items() if each.default is not Parameter.empty}
    own = {
        "__doc__": formula.__doc__,
        "__module__": formula.__module__,
        "__qualname__": formula.__name__,
        "__annotations__": dict.fromkeys(numbers, Array),
        "name": formula.__name__,
        "title": str(formula.__doc__).partition(":")[0],
        "formula": staticmethod(formula),
        "numbers": tuple(numbers),
    }
    about = {"side": "motor", "acts_on": "motor", "start": None, **about}
    return dataclass(frozen=True, kw_only=True, eq=False)(type(formula.__name__, bases, {**own, **about, **numbers}))


def size(meaning: str, unit: str, low: float, high: float, source: str = "chosen", **more: Any) -> Any:
    """Size of an effect, 0 without it."""
    return parameter(meaning, unit=unit, low=low, high=high, source=source, **more)


def of_coulomb(low: float, high: float, source: str = "chosen", **more: Any) -> Any:
    """Size as a share of the Coulomb torque."""
    return size("a, of the Coulomb torque", "1", low, high, source, **more)


def shape(meaning: str, unit: str, low: float, high: float, source: str = "chosen", **more: Any) -> Any:
    """Declare a number that an effect has beside its size."""
    return parameter(meaning, unit=unit, null=None, low=low, high=high, source=source, **more)


def any_phase() -> Any:
    """Phase of a wave."""
    return shape("phi", "rad", 0.0, 2 * np.pi, "any", role="phase")


def cycles_per_turn(low: float, high: float, source: str) -> Any:
    """Periods of a wave in a turn of the motor."""
    return shape("k, per motor turn", "1", low, high, source, role="cycles")


def bending_speed(letter: str, low: float, high: float, source: str = "chosen") -> Any:
    """Speed that gives a curve of friction its shape."""
    return shape(f"{letter}, motor side", "rad/s", low, high, source, minimum=1e-3)


def sum_of_others(share: Array, of: Array) -> Array:
    """Sum over j of share_ij `of`_j, one by one, so that a row's bits depend on nothing else."""
    total = np.zeros_like(of)
    for j in range(of.shape[-1]):
        total = total + share[..., :, j] * of[..., j : j + 1]
    return total


def lagging(z: Array, way: Array, width: Array) -> Array:
    r"""Hysteresis z in [-1, 1] after a `way` in one direction, shape (..., N) each.

    .. math:: z_+ = \sigma + (z - \sigma)\, e^{-|\Delta x| / w}, \quad \sigma = \mathrm{sgn}(\Delta x)

    The exact solution of :math:`dz/dx = (1 - z \sigma) / w`, so that the loop is the same at any rate and step.

    Reference:
        Dahl (1968), "A solid friction model", Aerospace Corporation; Wen (1976) with exponent 1 and equal parts.
    """
    towards = np.sign(way)
    after: Array = towards + (z - towards) * np.exp(-np.abs(way) / width)
    return np.where(way == 0, z, after)


_SECOND = 0.4
"""Height of the second wave; chosen: the first is the main one, and two thirds of it are not all."""

_SHIFT = 1.0
"""Its phase beyond twice that of the first [rad]; chosen: neither even nor odd."""


def two_waves(angle: Array) -> Array:
    """Two waves that are locked to each other, of an angle [rad]."""
    wave: Array = np.sin(angle) + _SECOND * np.sin(2 * angle + _SHIFT)
    return wave


def slope_of_waves(angle: Array) -> Array:
    """Derivative of `two_waves`."""
    slope: Array = np.cos(angle) + 2 * _SECOND * np.cos(2 * angle + _SHIFT)
    return slope
