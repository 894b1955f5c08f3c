r"""Motors of the independent plant: friction as an operator of the way travelled, and servos with and without samples.

Surfaces have the strength :math:`g` that they bear at the present speed and load, and the described stiffness
:math:`\sigma_0` at rest; from one sliding direction to the other they follow

.. math:: F(x) = g - 2 g\, e^{-\sigma_0 x / g}
"""

from abc import ABC, abstractmethod
from collections import deque
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ffgym.core.types import Array, BoolArray

_LONGEST = 5.0
"""Way at which the last block slips, in ways in which the whole yields; chosen: 1 % of the stiffness is left."""

_BLOCKS = 24
"""Blocks in a contact."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Contact:
    """Friction before and after breakaway of (B, N) motors, by bristles or, where there are any, by blocks.

    Bristles yield little by little (Dahl 1968), integrated exactly along the way. Blocks on springs slip at a strength
    of their own each (generalised Maxwell slip); at rest they have slid against where they will move, and came back
    until the force was gone. The memory is the force of the bristles, and beside it that of each block: (B, N, 1 + M).

    Reference:
        Al-Bender, Lampaert, Swevers (2005), IEEE TAC 50(11).
    """

    stiffness: Array
    """Stiffness at rest, and of all blocks together when they turn back after sliding [N m/rad], shape (B, N)."""
    has_blocks: BoolArray
    """Joints where blocks rub, shape (B, N)."""

    @cached_property
    def shares(self) -> tuple[Array, Array]:
        """Share of each block in stiffness and strength, shape (M,) each; both add up to 1."""
        edge = np.linspace(0, _LONGEST, _BLOCKS)  # ways at which blocks slip, in those in which the whole yields
        holding = np.append(np.exp(-edge), 0.0)
        slipped = np.append(1 - (1 + edge) * np.exp(-edge), 1.0)
        return -np.diff(holding), np.diff(slipped)

    @cached_property
    def has_any(self) -> bool:
        """True if blocks rub in any joint."""
        return bool(self.has_blocks.any())

    def at_rest(self, heading: Array, strength: Array) -> Array:
        """Memory without force of motors that will first move in the direction `heading`, +1 or -1, shape (B, N)."""
        bristles = np.zeros_like(strength)[..., None]
        if not self.has_any:
            return bristles
        slid = -(heading * strength)[..., None] * self.shares[1]
        back = heading * np.log(2.0) * strength / self.stiffness
        return np.concatenate([bristles, self._slip(slid, back, strength)], axis=-1)

    def move(self, memory: Array, way: Array, strength: Array) -> tuple[Array, Array]:
        """Force [N m] and memory after a `way` [rad] in one direction, under a strength [N m]; shapes (B, N)."""
        end, before = np.sign(way) * strength, memory[..., 0]
        force = end + (before - end) * np.exp(-self.stiffness * np.abs(way) / strength)
        force = np.where(way == 0, before, force)
        if not self.has_any:
            return force, force[..., None]
        blocks = self._slip(memory[..., 1:], way, strength)
        later = np.concatenate([force[..., None], blocks], axis=-1)
        return np.where(self.has_blocks, blocks.sum(axis=-1), force), later

    def _slip(self, memory: Array, way: Array, strength: Array) -> Array:
        """Force of each block after a way."""
        stiff, strong = self.shares
        limit = strength[..., None] * strong
        force = memory + (2 * self.stiffness * way)[..., None] * stiff
        return np.minimum(np.maximum(force, -limit), limit)


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
    """Makes torque of set-points and measured angles, motor side; one without sample times overrides nothing else."""

    def begin(self, angle: Array, torque: Array, dt: float) -> None:  # noqa: B027
        """Take over motors that stand at an `angle` [rad] under a `torque` beside the feed-forward [N m], (B, N)."""

    def sample(self, k: int, orders: Orders, angle: Array) -> None:  # noqa: B027
        """Look at the motors' angle [rad] when step k begins."""

    @abstractmethod
    def torque(self, state: Array, half: int, orders: Orders, angle: Array, speed: Array) -> tuple[Array, Array]:
        """Feedback torque [N m], and rate of the servo's `state`, at a half step."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Continuous(Servo):
    r"""The documented servo without sample times: :math:`u = K_p e + K_v \dot e + K_i \int e`."""

    position: Array
    speed: Array
    integral: Array

    def torque(self, state: Array, half: int, orders: Orders, angle: Array, speed: Array) -> tuple[Array, Array]:
        """Compute the torque of a servo with an integral part, which is its state."""
        off = orders.position[half] - angle
        return self.position * off + self.speed * (orders.speed[half] - speed) + state, self.integral * off


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
    """Steps per turn of the encoder."""
    corner: float
    """Corner frequency of the speed filter [Hz]."""
    rise: float
    """Time constant of the current [s]."""
    delay: int
    """Samples from order to current."""
    share_ahead: float
    """Share of the speed of set-points that the speed loop is told."""
    _every: int = 1
    _angle: Array = field(default_factory=lambda: np.zeros(0))
    _speed: Array = field(default_factory=lambda: np.zeros(0))
    _integral: Array = field(default_factory=lambda: np.zeros(0))
    _waiting: deque[Array] = field(default_factory=deque)
    _order: Array = field(default_factory=lambda: np.zeros(0))
    _previous: Array = field(default_factory=lambda: np.zeros(0))
    _half: int = 0

    def begin(self, angle: Array, torque: Array, dt: float) -> None:
        """Begin at rest, with a history of angles that do not change."""
        self._every = round(self.period / dt)
        self._angle, self._speed, self._integral = self._quantise(angle), np.zeros_like(angle), torque.copy()
        self._waiting, self._order, self._previous = deque([torque] * self.delay), torque, torque

    def _quantise(self, angle: Array) -> Array:
        step = 2 * np.pi / self.steps_of_turn
        return np.asarray(np.floor(angle / step) * step + step / 2)

    def sample(self, k: int, orders: Orders, angle: Array) -> None:
        """Sample the angle, and compute the torque that is held until the next sample."""
        if k % self._every:
            return
        seen = self._quantise(angle)
        keep = np.exp(-2 * np.pi * self.corner * self.period)
        self._speed = keep * self._speed + (1 - keep) * (seen - self._angle) / self.period
        wanted = self.rate * (orders.position[2 * k] - self._angle) + self.share_ahead * orders.speed[2 * k]
        self._angle = seen
        off = wanted - self._speed
        self._integral = self._integral + self.speed * off * self.period / self.reset
        self._waiting.append(self.speed * off + self._integral)
        self._previous, self._order, self._half = self._order, self._waiting.popleft(), 2 * k

    def torque(self, state: Array, half: int, orders: Orders, angle: Array, speed: Array) -> tuple[Array, Array]:
        """Return the torque that is held."""
        share = (half - self._half) / (2 * self._every)
        wanted = self._previous + share * (self._order - self._previous)
        return state, (wanted - state) / self.rise
