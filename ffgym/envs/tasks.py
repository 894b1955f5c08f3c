"""Tasks, which draw motions, and the interface of engine and layers: episodes and steps of a batch."""

from abc import ABC, abstractmethod
from collections import OrderedDict
from collections.abc import Callable, Hashable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Protocol

import numpy as np
from gymnasium import spaces

from ffgym.core.errors import FFGymError, check_number, check_whole
from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.envs.motion import EpisodeMotion
from ffgym.robot import RigidArm, RobotDescription, robot_of


@dataclass(slots=True, kw_only=True, eq=False)
class Transition:
    """Result of a step in B sub-environments."""

    observation: Array
    """Shape (B, D)."""
    reward: Array
    """Shape (B,); 0 where nothing was stepped."""
    terminated: BoolArray
    """Emergency stop, shape (B,)."""
    truncated: BoolArray
    """End of the motion or of the horizon, shape (B,)."""


class EngineStage(Protocol):
    """The engine, or a layer on top of it."""

    observation_space: spaces.Box
    action_space: spaces.Box
    decision_dt: float
    """Time between actions [s]."""

    def reset(self, ids: IntArray, options: Sequence[Mapping[str, Any]]) -> Array:
        """Begin episodes in sub-environments `ids`, with options for each; returns all observations, (B, D)."""

    def step(self, action: Array, active: BoolArray | None = None) -> Transition:
        """Take one decision where `active`, shape (B,), None is everywhere; `action` (B, N) is finite."""

    def save(self) -> list[dict[str, Any]]:
        """Copy all that steps and resets change, here first, then in the stages below."""

    def restore(self, saved: Sequence[Mapping[str, Any]]) -> None:
        """Go back to what `save` copied."""


def copy_changing(owner: Any, names: Sequence[str]) -> dict[str, Any]:
    """Copy attributes of an object: arrays, lists of objects that stay as they are, generators by their state."""
    return {name: _copy(getattr(owner, name)) for name in names}


def restore_changing(owner: Any, saved: Mapping[str, Any]) -> None:
    """Give an object back the attributes that `copy_changing` copied; generators stay the same objects."""
    for name, value in saved.items():
        setattr(owner, name, _copy(value))


@dataclass(frozen=True, eq=False)
class _SavedGenerator:
    """A generator of random numbers, and its state."""

    rng: np.random.Generator
    state: Any


def _copy(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.copy()
    if isinstance(value, list | tuple):
        return type(value)(_copy(each) for each in value)
    if isinstance(value, np.random.Generator):
        return _SavedGenerator(value, deepcopy(value.bit_generator.state))
    if isinstance(value, _SavedGenerator):
        value.rng.bit_generator.state = deepcopy(value.state)
        return value.rng
    return value


class Observer(Protocol):
    """Observer of an engine, which leaves it as it is."""

    def begin(self, ids: IntArray) -> None:
        """Take note that sub-environments `ids` have begun an episode."""

    def follow(self, ids: IntArray) -> None:
        """Take note that sub-environments `ids` have done a control step."""


KEPT = 128
"""Motions kept per environment: more than all of the thesis' circle test, in any order of its circles."""


class Tasks(ABC):
    """A family of motions of one robot."""

    option_names: ClassVar[tuple[str, ...]]
    """Options of `reset(options=...)` that fix a motion."""

    def __init__(self, robot: RobotDescription | str | Path) -> None:
        self.robot = robot_of(robot)
        self.arm = RigidArm(self.robot)
        self._cache: OrderedDict[Hashable, EpisodeMotion] = OrderedDict()

    @abstractmethod
    def draw(self, rng: np.random.Generator, options: Mapping[str, Any]) -> EpisodeMotion:
        """Draw a motion; `options` fix parts of it.

        Raises:
            FFGymError: if an option is not valid, or the robot cannot follow the motion.
        """

    def draw_series(self, rng: np.random.Generator, options: Mapping[str, Any]) -> tuple[EpisodeMotion, ...]:
        """Draw the motions of an episode, by default one, as `draw` does; the machine rests at the start of each."""
        return (self.draw(rng, options),)

    def list_options(self) -> list[dict[str, Any]]:
        """List the options of every motion of the family, in order; empty if they cannot be listed."""
        return []

    def _keep_motion(self, key: Hashable, make: Callable[[], EpisodeMotion]) -> EpisodeMotion:
        """Return the motion of a key, made once; the least recently used ones are forgotten."""
        if key not in self._cache:
            self._cache[key] = make()
            if len(self._cache) > KEPT:
                self._cache.popitem(last=False)
        self._cache.move_to_end(key)
        return self._cache[key]


def check_not_empty(name: str, values: tuple[Any, ...], example: str) -> tuple[Any, ...]:
    """Return `values` if there are any."""
    if not values:
        raise FFGymError(f"{name} is empty, must hold at least one, e.g. {example}.")
    return values


@dataclass(frozen=True, kw_only=True)
class Sensing:
    """Measurement of the agent's motor angle; the servo sees the exact one. The default is exact."""

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
    def step(self) -> float:
        """Resolution of the angle [rad], 0 without encoder."""
        return 0.0 if self.encoder_bits is None else 2 * np.pi / 2**self.encoder_bits


class MotorSensors:
    """Motor sensors of B sub-environments; a measured angle is kept, since a speed needs two of them."""

    def __init__(self, n: int, n_joints: int, dt: float) -> None:
        self._dt = dt
        self._step, self._noise = np.zeros((n, 1)), np.zeros((n, 1))
        self._angle, self._speed = np.zeros((n, n_joints)), np.zeros((n, n_joints))
        self._rngs: list[np.random.Generator | None] = [None] * n
        self._sort()

    def set(self, i: int, sensing: Sensing, rng: np.random.Generator) -> None:
        """Choose the sensors of one sub-environment, and the randomness of their noise."""
        self._rngs[i] = rng
        self._step[i], self._noise[i] = sensing.step, sensing.noise
        self._sort()

    def _sort(self) -> None:
        """Sort sub-environments by what their sensors do, once for all steps."""
        rounds, noisy = self._step > 0, self._noise > 0
        self._rounds, self._exact, self._noisy = rounds, ~(rounds | noisy), np.flatnonzero(noisy)
        # where angles are not rounded, they are divided by a step of 1
        self._divisor = np.where(rounds, self._step, 1.0)
        self._all_round, self._some_exact = bool(rounds.all()), bool(self._exact.any())
        self.exact = bool(self._exact.all())
        """True if all of them measure the true angle and speed."""

    def save(self) -> dict[str, Any]:
        """Copy sensors and what they measured last."""
        return copy_changing(self, ("_step", "_noise", "_angle", "_speed", "_rngs"))

    def restore(self, saved: Mapping[str, Any]) -> None:
        """Go back to what `save` copied."""
        restore_changing(self, saved)
        self._sort()

    def read(self, angle: Array, speed: Array, fresh: BoolArray | None, first: BoolArray) -> tuple[Array, Array]:
        """Measure angle [rad] and speed [rad/s], shape (B, N).

        A new sample is taken where `fresh` (B,), None is everywhere; elsewhere the last one stays. At the `first` one
        of an episode (B,), without a backward difference, the speed is true.
        """
        if self.exact:
            return angle, speed
        measured = angle
        if self._noisy.size:
            measured = angle.copy()
            for i in self._noisy if fresh is None else self._noisy[fresh[self._noisy]]:
                rng = self._rngs[i]
                assert rng is not None  # noise comes with its generator
                measured[i] += self._noise[i] * rng.standard_normal(measured.shape[1])
        rounded = np.rint(measured / self._divisor) * self._divisor
        measured = rounded if self._all_round else np.where(self._rounds, rounded, measured)
        rate = (measured - self._angle) / self._dt
        if np.count_nonzero(first):
            rate = np.where(first[:, None], speed, rate)
        if fresh is not None:
            measured = np.where(fresh[:, None], measured, self._angle)
            rate = np.where(fresh[:, None], rate, self._speed)
        self._angle, self._speed = measured, rate
        if self._some_exact:
            return np.where(self._exact, angle, measured), np.where(self._exact, speed, rate)
        return measured, rate


def masks_for(info: dict[str, Any], n: int) -> dict[str, BoolArray]:
    """Make the masks of info that all `n` sub-environments have; one read-only array."""
    every = np.ones(n, dtype=np.bool_)
    every.flags.writeable = False
    return dict.fromkeys([f"_{name}" for name in info], every)


def score(done: BoolArray, returns: Array, lengths: IntArray) -> dict[str, Any]:
    """Collect return and length of the episodes that are done."""
    mask = done.copy()
    values = {
        "return": np.where(done, returns, 0.0),
        "length": np.where(done, lengths, 0),
        "_return": mask,
        "_length": mask,
    }
    return {"score": values, "_score": mask}


def finals(observation: Array, info: dict[str, Any], done: BoolArray) -> dict[str, Any]:
    """Collect last observation and info of the episodes that are done, for the autoreset mode SAME_STEP."""
    final_obs = np.full(len(done), None, dtype=object)
    for i in np.flatnonzero(done):
        final_obs[i] = observation[i].copy()
    final_info = {name: value for name, value in info.items() if not name.startswith("_")}
    final_info |= {f"_{name}": done.copy() for name in final_info}
    return {"final_obs": final_obs, "_final_obs": done.copy(), "final_info": final_info, "_final_info": done.copy()}
