"""What a residual policy sees of each motor: errors and reference in units of what breakaway torque does.

All numbers of a motor are scaled by its own nominal friction, servo and rotor, so that one small network can serve all
motors alike, and nothing has to be normalised by statistics of the data.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ffgym.control import ObservationLayout
from ffgym.core.errors import FFGymError, check_whole
from ffgym.core.types import Array
from ffgym.robot import RobotDescription

LIMIT = 10.0
"""Features are clipped to +-LIMIT."""
ERROR_UNIT = 0.1
"""Unit of the errors that are seen, in what breakaway torque does. Chosen: at 10 mm/s friction that is 30 % off leaves
errors of some hundredths of it, which a network must tell apart from nothing."""
AHEAD = (1, 2, 4, 8)
"""Samples of the reference that are seen; an action is reached at sample 1, and the last is 32 ms ahead, in which a
joint's servo has settled most of an error."""
_PER_SAMPLE = 3
"""Numbers of each remembered sample: error, speed error, residual that was added."""
_PER_AHEAD = 3
"""Numbers of each sample of the reference: direction, speed, acceleration."""


def per_motor(memory: int) -> int:
    """Numbers F per motor with so many samples of errors and residuals."""
    return _PER_SAMPLE * memory + _PER_AHEAD * len(AHEAD)


@dataclass(frozen=True, kw_only=True, eq=False)
class Features:
    """F numbers for each of N motors, from an observation and what is remembered of those before it.

    Of each remembered sample, the newest first: position error in tenths of f_s / K_p, speed error in tenths of
    f_s / K_v, both without what the law below asks for itself, and residual torque in its bound; of each sample ahead:
    tanh of the speed in Stribeck velocities, speed in f_s / f_v, acceleration in f_s / J_m.
    """

    layout: ObservationLayout
    """Of the observations."""
    stribeck_velocity: Array
    """Of the nominal friction, motor side [rad/s], shape (N,)."""
    memory: int = 1
    """Samples M of errors and residuals that are seen, the present one included."""

    def __post_init__(self) -> None:
        check_whole("memory", self.memory, unit="samples", low=1, high=1000)
        if self.layout.preview < AHEAD[-1]:
            raise FFGymError(
                f"A residual policy reads the reference {AHEAD[-1]} samples ahead: make the environment with "
                f"preview={AHEAD[-1]} or more, not {self.layout.preview}."
            )

    @classmethod
    def of(cls, robot: RobotDescription, layout: ObservationLayout, memory: int = 1) -> "Features":
        """Features for a robot that the controller knows as `robot`."""
        return cls(layout=layout, stribeck_velocity=robot.friction.stribeck_velocity, memory=memory)

    @property
    def per_motor(self) -> int:
        """Numbers F per motor."""
        return per_motor(self.memory)

    @property
    def size(self) -> int:
        """All numbers, N F."""
        return self.layout.n_joints * self.per_motor

    def sample(self, observation: Array, own: tuple[Array, Array], residual: Array) -> Array:
        """What is remembered of observations (..., D), shape (..., 3, N).

        Args:
            observation: of the environment.
            own: errors [rad], [rad/s], motor side, that the law below asks for now, shape (..., N) each.
            residual: what the policy added on the way here, in [-1, 1], shape (..., N).
        """
        rows = []
        for name, asked in zip(("error", "error_rate"), own, strict=True):
            error = self._seen(observation, name) - asked / self.layout[name].scale
            rows.append(np.clip(error / ERROR_UNIT, -LIMIT, LIMIT))
        return np.stack([*rows, residual], axis=-2)

    def begin(self, sample: Array) -> Array:
        """What is remembered when an episode begins: the first sample (..., 3, N) stands for those before it."""
        return np.repeat(sample[..., None, :, :], self.memory, axis=-3)

    def remember(self, memory: Array, sample: Array) -> Array:
        """Memory (..., M, 3, N) with the newest sample in front."""
        return np.concatenate([sample[..., None, :, :], memory[..., : self.memory - 1, :, :]], axis=-3)

    def read(self, memory: Array, observation: Array) -> Array:
        """Features, shape (..., N F): all numbers of the first motor, then those of the next."""
        past = memory.reshape(*memory.shape[:-3], _PER_SAMPLE * self.memory, memory.shape[-1])
        rows = [past]
        for k in AHEAD:
            speed, acceleration = (self._seen(observation, f"reference_{name}_{k}") for name in _RATES)
            ahead = np.stack([np.tanh(self._speeds * speed), speed, acceleration], axis=-2)
            rows.append(np.clip(ahead, -LIMIT, LIMIT))
        features = np.swapaxes(np.concatenate(rows, axis=-2), -1, -2)
        return features.reshape(*features.shape[:-2], self.size)

    @cached_property
    def _speeds(self) -> Array:
        """Speeds as observed, in Stribeck velocities."""
        return np.asarray(self.layout["reference_velocity"].scale / self.stribeck_velocity)

    def _seen(self, observation: Array, name: str) -> Array:
        """An entry of observations as it stands there, shape (..., N)."""
        return np.asarray(observation[..., self.layout[name].slice])


_RATES = ("velocity", "acceleration")
