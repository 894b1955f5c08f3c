"""Frame of an exam's equations, which leaves to each of them its words, its parameters and its formula."""

import re
from dataclasses import dataclass
from typing import Any, ClassVar, dataclass_transform

import numpy as np

from ffgym.core.types import Array
from ffgym.effects import Effect, State, TorqueEffect, Torques, parameter
from ffgym.effects.effect import Side


def size(meaning: str, unit: str, low: float, high: float, source: str = "chosen", **more: Any) -> Any:
    """Size of an effect, 0 without it."""
    return parameter(meaning, unit=unit, low=low, high=high, source=source, **more)


def shape(meaning: str, unit: str, low: float, high: float, source: str = "chosen", **more: Any) -> Any:
    """What an effect has beside its size."""
    return parameter(meaning, unit=unit, null=None, low=low, high=high, source=source, **more)


@dataclass_transform(
    kw_only_default=True, frozen_default=True, eq_default=False, field_specifiers=(parameter, size, shape)
)
class Equation(Effect):
    """An effect in an equation of its own, declared by the keywords of its class; it becomes a dataclass by that."""

    way_in: ClassVar[str] = "torque at every physics step"

    def __init_subclass__(cls, *, equation: str = "", side: Side = "motor", **more: Any) -> None:
        """Declare an effect, whose title its docstring begins with; a class without an equation is a frame.

        Args:
            equation: what is added to which equation.
            side: where it acts.
            more: other class variables that differ from those of the frame.
        """
        super().__init_subclass__()
        if not equation:
            return
        cls.name = re.sub(r"(?<!^)(?=[A-Z])", "_", cls.__name__).lower()
        cls.title, cls.equation, cls.side = str(cls.__doc__).partition(":")[0], equation, side
        for name, value in more.items():
            setattr(cls, name, value)
        dataclass(frozen=True, kw_only=True, eq=False)(cls)


class Torque(Equation, TorqueEffect):
    """One torque that needs no memory."""

    acts_on: ClassVar[str] = "motor"
    """Field of `Torques`."""

    def _torque(self, s: State) -> Array:
        """Torque [N m], shape (..., N); not called where `torques` is written anew."""
        raise NotImplementedError

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        return Torques(**{self.acts_on: self._torque(state)}), memory


class Variant(Equation):
    """An effect of the library in an equation of its own, so that who fits the library's meets a foreign one."""

    variant_of: ClassVar[str]
    """Name of the effect that a diagnosis should give."""
    signature: ClassVar[str] = "as of the effect that it is a variant of"
    members: ClassVar[dict[str, type["Variant"]]] = {}
    """All that were declared, by name."""

    def __init_subclass__(cls, *, of: str = "", **more: Any) -> None:
        """See base class; `of` is `variant_of`."""
        super().__init_subclass__(**more)
        if of:
            cls.variant_of = of
            Variant.members[cls.name] = cls


@dataclass(frozen=True, kw_only=True)
class Clue:
    """What an answer must say of an effect that no library holds."""

    words: tuple[str, ...]
    """One of them must stand in the variable that a pattern names."""
    joint: str | None = None
    """Whose variable that is; None is nobody's, as time is."""
    frequency: float | None = None
    """[Hz], of a line in time; a multiple of it is right, too. None if there is none."""


class Outsider(Torque):
    """An effect that no effect of the library can express, of a size `share`."""

    signature: ClassVar[str] = "only in patterns of the residual"
    words: ClassVar[tuple[str, ...]] = ("time",)
    """See `Clue`."""
    members: ClassVar[dict[str, type["Outsider"]]] = {}
    """All that were declared, by name."""
    share: Array

    def __init_subclass__(cls, **more: Any) -> None:
        """See base class."""
        super().__init_subclass__(**more)
        if more:
            Outsider.members[cls.name] = cls

    def line(self) -> Array | None:
        """Frequency of its line in time [Hz], shape (N,); None if there is none."""
        return None

    def clue(self, joints: tuple[str, ...], joint: str) -> Clue:
        """What an answer must name, for the effect on `joint` of a robot with these `joints`."""
        row, line = joints.index(joint), self.line()
        if self.words == Outsider.words:
            return Clue(words=self.words, frequency=None if line is None else float(line[row]))
        of_others = self.share.ndim == 2
        return Clue(words=self.words, joint=joints[int(np.argmax(np.abs(self.share[row])))] if of_others else joint)


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


def any_phase() -> Any:
    """Phase of a wave."""
    return shape("phi", "rad", 0.0, 2 * np.pi, "any", role="phase")


def cycles_per_turn(low: float, high: float, source: str) -> Any:
    """Periods of a wave in a turn of the motor."""
    return shape("k, per motor turn", "1", low, high, source, role="cycles")


def bending_speed(letter: str, low: float, high: float, source: str = "chosen") -> Any:
    """Speed that gives a curve of friction its shape."""
    return shape(f"{letter}, motor side", "rad/s", low, high, source, minimum=1e-3)
