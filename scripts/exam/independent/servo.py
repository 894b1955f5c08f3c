"""Servos of the independent plant: one as descriptions say, and a cascade as drives have."""

from abc import ABC, abstractmethod
from collections import deque
from dataclasses import dataclass, field
from typing import final

import numpy as np

from ffgym.core.types import Array


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Orders:
    """Set-points of the motors at every half step, shape (2 K + 1, B, N) each."""

    position: Array
    """[rad]."""
    speed: Array
    """[rad/s]."""
    ahead: Array
    """Feed-forward torque [N m]."""


class Servo(ABC):
    """Makes torque of set-points and measured angles, motor side."""

    @abstractmethod
    def begin(self, angle: Array, torque: Array, dt: float) -> None:
        """Take over motors that stand at an `angle` [rad] under a `torque` beside the feed-forward [N m], (B, N)."""

    @abstractmethod
    def sample(self, k: int, orders: Orders, angle: Array) -> None:
        """Look at the motors' angle [rad] when step k begins."""

    @abstractmethod
    def torque(self, state: Array, half: int, orders: Orders, angle: Array, speed: Array) -> tuple[Array, Array]:
        """Feedback torque [N m], and rate of the servo's `state`, at a half step."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Continuous(Servo):
    r"""The documented servo without sample times: :math:`u = K_p e + K_v \dot e + K_i \int e`."""

    position: Array
    speed: Array
    integral: Array

    def begin(self, angle: Array, torque: Array, dt: float) -> None:
        """See base class; the state is the integral part."""

    def sample(self, k: int, orders: Orders, angle: Array) -> None:
        """See base class."""

    def torque(self, state: Array, half: int, orders: Orders, angle: Array, speed: Array) -> tuple[Array, Array]:
        """See base class."""
        off = orders.position[half] - angle
        return self.position * off + self.speed * (orders.speed[half] - speed) + state, self.integral * off


@final
@dataclass(kw_only=True, eq=False)
class Cascade(Servo):
    """Position loop around a speed loop, sampled; speed by difference of a quantised angle, and filtered.

    Orders are reached in a straight line by the next sample, and currents follow in `rise`; the state is the current as
    torque. Measured angles are a sample old.
    """

    rate: Array
    """Gain of the position loop [1/s], (B, N) as all gains."""
    speed: Array
    """Gain of the speed loop [N m s/rad]."""
    reset: Array
    """Time constant of its integral [s]."""
    period: float
    """Sample time [s]."""
    steps_of_turn: float
    """Of the encoder."""
    corner: float
    """Of the speed filter [Hz]."""
    rise: float
    """Time constant of the current [s]."""
    delay: int
    """Samples from order to current."""
    share_ahead: float
    """Of the speed of set-points that the speed loop is told."""
    _every: int = 1
    _angle: Array = field(default_factory=lambda: np.zeros(0))
    _speed: Array = field(default_factory=lambda: np.zeros(0))
    _integral: Array = field(default_factory=lambda: np.zeros(0))
    _waiting: deque[Array] = field(default_factory=deque)
    _order: Array = field(default_factory=lambda: np.zeros(0))
    _previous: Array = field(default_factory=lambda: np.zeros(0))
    _half: int = 0

    def begin(self, angle: Array, torque: Array, dt: float) -> None:
        """See base class."""
        self._every = round(self.period / dt)
        self._angle, self._speed, self._integral = self._quantised(angle), np.zeros_like(angle), torque.copy()
        self._waiting, self._order, self._previous = deque([torque] * self.delay), torque, torque

    def _quantised(self, angle: Array) -> Array:
        step = 2 * np.pi / self.steps_of_turn
        return np.asarray(np.floor(angle / step) * step + step / 2)

    def sample(self, k: int, orders: Orders, angle: Array) -> None:
        """See base class."""
        if k % self._every:
            return
        seen = self._quantised(angle)
        keep = np.exp(-2 * np.pi * self.corner * self.period)
        self._speed = keep * self._speed + (1 - keep) * (seen - self._angle) / self.period
        wanted = self.rate * (orders.position[2 * k] - self._angle) + self.share_ahead * orders.speed[2 * k]
        self._angle = seen
        off = wanted - self._speed
        self._integral = self._integral + self.speed * off * self.period / self.reset
        self._waiting.append(self.speed * off + self._integral)
        self._previous, self._order, self._half = self._order, self._waiting.popleft(), 2 * k

    def torque(self, state: Array, half: int, orders: Orders, angle: Array, speed: Array) -> tuple[Array, Array]:
        """See base class."""
        share = (half - self._half) / (2 * self._every)
        wanted = self._previous + share * (self._order - self._previous)
        return state, (wanted - state) / self.rise
