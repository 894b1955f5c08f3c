"""Scales on which one joint and its magnified error are drawn, without the robot."""

from abc import ABC, abstractmethod
from typing import ClassVar, final

import numpy as np

from ffgym.core.types import Array
from ffgym.envs.rendering.camera import Camera
from ffgym.envs.rendering.paper import GREY, Curve, Mark
from ffgym.recordings.metrics import round_down

TICK = np.deg2rad(15.0)
"""Between two ticks of a dial [rad]."""


class Gauge(ABC):
    """A level scale around `centre` [m], of half size `radius` [m]; what is past runs on, as on a strip chart."""

    word: ClassVar[str]
    """For the joint's position."""
    tick_text: str
    """Distance of ticks."""

    def __init__(self, centre: Array, radius: float) -> None:
        self.centre, self.radius = centre, radius

    @property
    def camera(self) -> Camera:
        """From above."""
        return Camera.along(np.array([0.0, 0.0, 1.0]), self.centre, 1.2 * self.radius)

    @abstractmethod
    def points(self, age: Array, position: Array) -> Array:
        """Points (T, 3) at ages, 0 is now and 1 as old as is shown, and joint positions (T,)."""

    @abstractmethod
    def foot(self, point: Array) -> Array:
        """Where the pointer to a present point (3,) begins."""

    @abstractmethod
    def marks(self) -> list[Mark]:
        """Rim and ticks."""

    @abstractmethod
    def text(self, position: float, digits: int) -> str:
        """A position in the unit of people."""

    def _level(self, x: Array, y: Array) -> Array:
        """Points (T, 3) at x and y (T,), in units of the radius from the centre."""
        return self.centre + self.radius * np.stack([x, y, np.zeros(len(x))], axis=1)


@final
class Dial(Gauge):
    """A dial for a hinge; what is past runs inwards."""

    word = "angle"
    tick_text = f"{np.rad2deg(TICK):g} deg"

    def points(self, age: Array, position: Array) -> Array:
        """See base class."""
        return self._at(1 - 0.6 * age, position)

    def foot(self, point: Array) -> Array:
        """See base class."""
        return self.centre

    def marks(self) -> list[Mark]:
        """See base class."""
        marks: list[Mark] = [Curve(points=self._at(np.ones(181), np.linspace(0, 2 * np.pi, 181)), colour=GREY, width=2)]
        for k in range(round(2 * np.pi / TICK)):
            ends = self._at(np.array([0.94 if k % 6 else 0.86, 1.0]), np.full(2, k * TICK))
            marks.append(Curve(points=ends, colour=GREY, width=2))
        return marks

    def text(self, position: float, digits: int) -> str:
        """See base class."""
        return f"{np.rad2deg(position):.{digits}f} deg"

    def _at(self, radius: Array, angle: Array) -> Array:
        return self._level(radius * np.cos(angle), radius * np.sin(angle))


@final
class Ruler(Gauge):
    """A ruler for a slide, as long as the picture whatever the range; what is past runs down from it."""

    word = "position"

    def __init__(self, centre: Array, radius: float, limits: Array) -> None:
        super().__init__(centre, radius)
        self._limits = limits
        self._tick = round_down(float(np.ptp(limits)) / 10)
        self.tick_text = f"{self._tick * 1e3:g} mm"

    def points(self, age: Array, position: Array) -> Array:
        """See base class."""
        share = (position - self._limits.mean()) / (np.ptp(self._limits) / 2)
        return self._level(0.9 * share, 0.7 - 1.4 * age)

    def foot(self, point: Array) -> Array:
        """See base class."""
        return point + self.radius * np.array([0.0, 0.2, 0.0])

    def marks(self) -> list[Mark]:
        """See base class."""
        marks: list[Mark] = [Curve(points=self.points(np.zeros(2), self._limits), colour=GREY, width=2)]
        first, last = self._limits / self._tick
        for k in np.arange(np.ceil(first - 1e-9), last + 1e-9):
            foot = self.points(np.zeros(1), np.array([k * self._tick]))[0]
            tip = foot + self.radius * np.array([0.0, 0.12 if k == 0 else 0.06, 0.0])
            marks.append(Curve(points=np.stack([foot, tip]), colour=GREY, width=2))
        return marks

    def text(self, position: float, digits: int) -> str:
        """See base class."""
        return f"{position * 1e3:.{digits}f} mm"
