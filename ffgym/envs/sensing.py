"""How the motor angle is measured that an agent sees."""

from dataclasses import dataclass

import numpy as np

from ffgym.core.errors import check_number, check_whole
from ffgym.core.types import Array, BoolArray


@dataclass(frozen=True, kw_only=True)
class Sensing:
    """How the agent's motor angle is measured; the servo sees the exact one. The default is exact."""

    encoder_bits: int | None = None
    """Resolution [bit/turn]; the speed is then the backward difference of the measured angle over a control step."""
    noise: float = 0.0
    """Standard deviation of white noise on the angle before it is rounded, motor side [rad]."""

    def __post_init__(self) -> None:
        if self.encoder_bits is not None:
            bits = check_whole("encoder_bits", self.encoder_bits, unit="bit/turn", low=1, high=32)
            object.__setattr__(self, "encoder_bits", bits)
        object.__setattr__(self, "noise", check_number("angle noise", self.noise, unit="rad", low=0.0))

    @property
    def is_exact(self) -> bool:
        """Whether angle and speed are the true ones."""
        return self.encoder_bits is None and self.noise == 0.0

    @property
    def step(self) -> float:
        """Smallest angle that is told apart [rad], 0 without encoder."""
        return 0.0 if self.encoder_bits is None else 2 * np.pi / 2**self.encoder_bits


class MotorSensors:
    """Motor sensors of B sub-environments; a measured angle is kept, since a speed needs two of them."""

    def __init__(self, n: int, n_joints: int, dt: float) -> None:
        self._dt = dt
        self._step, self._noise = np.zeros((n, 1)), np.zeros((n, 1))
        self._exact = np.ones((n, 1), dtype=np.bool_)
        self._angle, self._speed = np.zeros((n, n_joints)), np.zeros((n, n_joints))
        self._rngs: list[np.random.Generator | None] = [None] * n
        self.exact = True
        """Whether all of them measure the true angle and speed."""

    def set(self, i: int, sensing: Sensing, rng: np.random.Generator) -> None:
        """Choose the sensors of one sub-environment, and the randomness of their noise."""
        self._rngs[i] = rng
        self._step[i], self._noise[i], self._exact[i] = sensing.step, sensing.noise, sensing.is_exact
        self.exact = bool(self._exact.all())

    def read(
        self,
        angle: Array,
        speed: Array,
        fresh: BoolArray | None,
        first: BoolArray,
    ) -> tuple[Array, Array]:
        """Measured angle [rad] and speed [rad/s], shape (B, N), of the true ones.

        Args:
            angle: true motor angle [rad], shape (B, N).
            speed: true motor speed [rad/s], shape (B, N).
            fresh: where a new sample is taken, shape (B,); elsewhere the last one stays. None is everywhere.
            first: where it is the first one of an episode, shape (B,): there is no difference yet, the speed is true.
        """
        if self.exact:
            return angle, speed
        fresh = np.ones(len(angle), dtype=np.bool_) if fresh is None else fresh
        measured = angle.copy()
        for i in np.flatnonzero(fresh & (self._noise[:, 0] > 0)).tolist():
            rng = self._rngs[i]
            assert rng is not None  # noise comes with its generator
            measured[i] += self._noise[i] * rng.standard_normal(measured.shape[1])
        coarse = self._step[:, 0] > 0
        measured[coarse] = np.round(measured[coarse] / self._step[coarse]) * self._step[coarse]
        rate = np.where(first[:, None], speed, (measured - self._angle) / self._dt)
        self._angle = np.where(fresh[:, None], measured, self._angle)
        self._speed = np.where(fresh[:, None], rate, self._speed)
        return np.where(self._exact, angle, self._angle), np.where(self._exact, speed, self._speed)
