"""The vector environment: Gymnasium's interface and automatic reset, around the engine."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from ffgym.envs.core import TrackingCore, Transition
from ffgym.envs.layers import Layer, Stage
from ffgym.envs.observation import ObservationLayout
from ffgym.envs.rendering import EpisodeRenderer, check_render_mode
from ffgym.envs.settings import Settings
from ffgym.envs.tasks import Tasks
from ffgym.errors import FFGymError, check_shape
from ffgym.types import Array, BoolArray, IntArray


class TrackingVectorEnv(gym.vector.VectorEnv[Array, Array, Any]):
    """B robots that track motions; one step is one control step of all of them.

    Rewards have shape (B,), `info` holds arrays of shape (B, ...) with masks `_key`, as Gymnasium's own. When an
    episode ends, `info["score"]` has its return and length.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 25}  # noqa: RUF012  (Gymnasium's way)

    def __init__(
        self,
        num_envs: int,
        tasks: Tasks,
        settings: Settings,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
    ) -> None:
        self.autoreset_mode = _autoreset_mode(autoreset_mode)
        self.metadata = type(self).metadata | {"autoreset_mode": self.autoreset_mode}
        self.render_mode = check_render_mode(render_mode, num_envs)
        self.core = TrackingCore(tasks, num_envs, settings)
        self._stage = stacked(self.core, settings.layers)
        self.num_envs = self.core.n
        self.single_observation_space = self._stage.observation_space
        self.single_action_space = self._stage.action_space
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._seeds: list[int | None] = [None] * self.num_envs
        self._ended = np.zeros(self.num_envs, dtype=np.bool_)
        self._return, self._length = np.zeros(self.num_envs), np.zeros(self.num_envs, dtype=np.int64)
        self._renderer = None if self.render_mode is None else EpisodeRenderer(self.core, self.render_mode)

    @property
    def observation_layout(self) -> ObservationLayout:
        """What stands where in an observation, with units and scales."""
        return self.core.observation_layout

    @property
    def action_scale(self) -> Array:
        """Torque of an action of 1, motor side [N m], shape (N,)."""
        return self.core.action_scale.copy()

    @property
    def decision_dt(self) -> float:
        """Time between actions [s]."""
        return self._stage.decision_dt

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Begin episodes in all sub-environments, or in those of `options["reset_mask"]`.

        Args:
            seed: sub-environment i gets seed + i; or one seed for each; None goes on with the present randomness.
            options: fixed for the episode: what the task offers (see its page), plant, randomization, reward, sensing,
                horizon. `options["each"]`: a list with one such dict per sub-environment.

        Raises:
            FFGymError: if an option or a seed is not valid; nothing has changed then.
        """
        if not isinstance(options, Mapping | None):
            raise FFGymError(f"options = {options!r} must be a dict, e.g. {{'horizon': 250}}.")
        options = dict(options or {})
        mask = self._reset_mask(options.pop("reset_mask", None))
        each = options.pop("each", None)
        chosen = [options] * self.num_envs if each is None else self._each(each, options)
        seeds = self._checked_seeds(seed)
        ids = np.flatnonzero(mask)
        with self.core.all_or_nothing(ids):
            used = self._seed(seeds, ids)
            observation = self._begin(ids, [chosen[i] for i in ids])
        self._seeds = used
        return observation, self._with_masks(self.core.info())

    def step(self, actions: Array) -> tuple[Array, Any, Any, Any, dict[str, Any]]:
        """Add torque for one decision: shape (B, N), clipped to [-1, 1].

        Raises:
            FFGymError: if an action has the wrong shape or is not finite, before anything has moved.
        """
        if self.autoreset_mode is AutoresetMode.NEXT_STEP and self._ended.any():
            return self._step_or_begin(actions)
        result = self._stage.step(self._checked(actions, np.ones(self.num_envs, dtype=np.bool_)))
        self._count(result)
        info = self._with_masks(self.core.info())
        done = result.terminated | result.truncated
        observation = result.observation
        if done.any():
            self._ended = done
            info |= self._score(done)
            if self.autoreset_mode is AutoresetMode.SAME_STEP:
                info |= self._finals(observation, info, done)
                ids = np.flatnonzero(done)
                observation = self._begin(ids, [{}] * len(ids))
                info |= self._with_masks(self.core.info())
        return observation, result.reward, result.terminated, result.truncated, info

    def _step_or_begin(self, actions: Array) -> tuple[Array, Array, BoolArray, BoolArray, dict[str, Any]]:
        """A step in which those that ended in the last one begin anew instead, whatever their action."""
        ended, going = self._ended, ~self._ended
        actions = self._checked(actions, going)
        result = self._stage.step(actions, going) if going.any() else None
        ids = np.flatnonzero(ended)
        observation = self._begin(ids, [{}] * len(ids))
        none = np.zeros(self.num_envs, dtype=np.bool_)
        terminated, truncated = (none, none.copy()) if result is None else (result.terminated, result.truncated)
        reward = np.zeros(self.num_envs) if result is None else result.reward
        if result is not None:
            self._count(result, going)
        info = self._with_masks(self.core.info())
        self._ended = terminated | truncated
        if self._ended.any():
            info |= self._score(self._ended)
        return observation, reward, terminated, truncated, info

    def _begin(self, ids: IntArray, options: Sequence[Mapping[str, Any]]) -> Array:
        observation = self._stage.reset(ids, options)
        self._ended[ids], self._return[ids], self._length[ids] = False, 0.0, 0
        return observation

    def _count(self, result: Transition, going: BoolArray | None = None) -> None:
        self._return += result.reward
        self._length += 1 if going is None else going

    def _score(self, done: BoolArray) -> dict[str, Any]:
        """Return and length of the episodes that are done."""
        mask = done.copy()
        score = {
            "return": np.where(done, self._return, 0.0),
            "length": np.where(done, self._length, 0),
            "_return": mask,
            "_length": mask,
        }
        return {"score": score, "_score": mask}

    def _finals(self, observation: Array, info: dict[str, Any], done: BoolArray) -> dict[str, Any]:
        """Last observation and info of the episodes that are done, as Gymnasium's vector environments give them."""
        final_obs = np.full(self.num_envs, None, dtype=object)
        for i in np.flatnonzero(done):
            final_obs[i] = observation[i].copy()
        final_info = {name: value for name, value in info.items() if not name.startswith("_")}
        final_info |= {f"_{name}": done.copy() for name in final_info}
        return {"final_obs": final_obs, "_final_obs": done.copy(), "final_info": final_info, "_final_info": done.copy()}

    def _with_masks(self, info: dict[str, Any]) -> dict[str, Any]:
        every = np.ones(self.num_envs, dtype=np.bool_)
        every.flags.writeable = False  # one array for all keys
        return info | {f"_{name}": every for name in info}

    def _checked(self, actions: Any, going: BoolArray) -> Array:
        """Actions as numbers, checked where an episode is `going`, before anything has moved."""
        self.core.check_running(going)
        with suppress(TypeError, ValueError, OverflowError):  # then check_shape says what is wrong
            actions = np.array(actions, dtype=np.float64)
            if len(actions) == self.num_envs:
                actions[~going] = 0.0
        return check_shape("actions", actions, (self.num_envs, *(self.single_action_space.shape or ())))

    def _reset_mask(self, mask: Any) -> BoolArray:
        if mask is None:
            return np.ones(self.num_envs, dtype=np.bool_)
        given = mask
        with suppress(ValueError):  # a ragged list
            mask = np.asarray(given)
        if (
            not isinstance(mask, np.ndarray)
            or mask.shape != (self.num_envs,)
            or mask.dtype != np.bool_
            or not mask.any()
        ):
            raise FFGymError(
                f"options['reset_mask'] must be an array of {self.num_envs} bool with at least one True, got {given!r}."
            )
        if None in self.core.rngs:
            raise FFGymError("The first reset must be of all sub-environments; leave options['reset_mask'] out.")
        return mask

    def _each(self, each: Any, shared: dict[str, Any]) -> list[dict[str, Any]]:
        if (
            not isinstance(each, Sequence)
            or len(each) != self.num_envs
            or not all(isinstance(x, Mapping) for x in each)
        ):
            raise FFGymError(f"options['each'] must be a list of {self.num_envs} dicts, one per sub-environment.")
        return [shared | dict(own) for own in each]

    def _checked_seeds(self, seed: int | Sequence[int | None] | None) -> list[int | None]:
        if seed is None:
            return [None] * self.num_envs
        if isinstance(seed, str) or not isinstance(seed, Sequence | np.ndarray):
            return [check_seed(seed) + i for i in range(self.num_envs)]
        if len(seed) != self.num_envs:
            raise FFGymError(f"seed has {len(seed)} entries, must be one number or {self.num_envs}.")
        return [None if each is None else check_seed(each) for each in seed]

    def _seed(self, seeds: Sequence[int | None], ids: IntArray) -> list[int | None]:
        """Give sub-environments their randomness, new where a seed is given or there was none; returns all seeds."""
        used = self._seeds.copy()
        for i, seed in enumerate(seeds):
            if self.core.rngs[i] is None or (seed is not None and i in ids):
                rng, used[i] = seeding.np_random(seed)
                self.core.seed(i, rng, fresh=True)
        return used

    @property  # type: ignore[misc]  # Gymnasium's vector environments give a tuple too, and have nothing to set
    def np_random(self) -> tuple[np.random.Generator, ...]:  # type: ignore[override]
        """Randomness of each sub-environment."""
        return tuple(rng for rng in self.core.rngs if rng is not None)

    @property
    def np_random_seed(self) -> tuple[int | None, ...]:  # type: ignore[override]
        """Seed of each sub-environment; None before the first reset."""
        return tuple(self._seeds)

    def show(self) -> None:
        """Show sub-environment 0 in MuJoCo's viewer."""
        if self._renderer is not None:
            self._renderer.show()

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """One picture per sub-environment, each (height, width, 3) of uint8."""
        if self._renderer is None:
            raise FFGymError("There is nothing to render: make the environment with render_mode='rgb_array'.")
        return tuple(self._renderer.frame(i) for i in range(self.num_envs))

    def close_extras(self, **kwargs: Any) -> None:
        """Free the renderer."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None


def stacked(core: TrackingCore, layers: Sequence[Layer]) -> Stage:
    """The core with layers on top, the first one lowest."""
    stage: Stage = core
    for layer in layers:
        if not isinstance(layer, Layer):
            raise FFGymError(f"layers must hold layers of ffgym.envs such as History(8), got {layer!r}.")
        stage = layer.over(stage, core)
    return stage


def check_seed(seed: Any) -> int:
    """Return a seed if it is a whole number from 0 on.

    Raises:
        FFGymError: if it is not.
    """
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
        raise FFGymError(f"seed = {seed!r} must be a whole number >= 0, or None.")
    return int(seed)


def _autoreset_mode(mode: AutoresetMode | str) -> AutoresetMode:
    try:
        return AutoresetMode(mode)
    except ValueError as error:
        raise FFGymError(
            f"Unknown autoreset_mode {mode!r}. Available: {', '.join(m.value for m in AutoresetMode)}."
        ) from error
