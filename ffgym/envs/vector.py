"""Vector environment: Gymnasium's interface and automatic reset, around the engine."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from inspect import signature
from typing import Any, ClassVar

import gymnasium as gym
import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from ffgym.control.observation import ObservationLayout
from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.envs.arguments import check_actions, options_for_each, parse_autoreset_mode, reset_mask, seeds_for_each
from ffgym.envs.core import TrackingCore
from ffgym.envs.layers import stack_layers
from ffgym.envs.rendering import EpisodeRenderer, check_render_mode
from ffgym.envs.settings import EnvSettings, check_horizon
from ffgym.envs.tasks import Tasks, Transition, copy_changing, finals, masks_for, restore_changing, score

_CHANGING = ("_seeds", "_ended", "_flags", "_return", "_length")
"""Attributes of the vector environment that steps and resets change, beside those of its stages."""


@dataclass(frozen=True, eq=False, repr=False)
class EnvState:
    """State of an environment, for `set_state` of the same one."""

    owner: "TrackingVectorEnv"
    own: Mapping[str, Any]
    stages: Sequence[Mapping[str, Any]]


class TrackingVectorEnv(gym.vector.VectorEnv[Array, Array, Any]):
    """B robots that track motions; one step is one control step of all of them.

    Rewards have shape (B,), `info` holds arrays of shape (B, ...) with masks `_key`, as Gymnasium's own. When an
    episode ends, `info["score"]` has its return and length.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 25}  # noqa: RUF012  (Gymnasium's way)

    tasks: ClassVar[type[Tasks]]
    """Motions of an environment of this kind; its keyword arguments are the environment's, beside `EnvSettings`."""

    def __init__(
        self,
        num_envs: int = 1,
        *,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        max_episode_steps: int | None = None,
        **arguments: Any,
    ) -> None:
        """Make the robots.

        Args:
            num_envs: number of robots.
            autoreset_mode: Gymnasium's NextStep, SameStep or Disabled.
            render_mode: 'rgb_array' or None.
            max_episode_steps: longest episode [control steps], by which Gymnasium's `make_vec` tells the limit of an
                id; the shorter one of it and `horizon` counts.
            arguments: those of `tasks` and of `EnvSettings`.
        """
        own = list(signature(self.tasks).parameters)
        if max_episode_steps is not None:
            longest = check_horizon(max_episode_steps)
            arguments["horizon"] = min(longest, arguments.get("horizon") or longest)
        tasks = self.tasks(**{name: value for name, value in arguments.items() if name in own})
        settings = EnvSettings.of({name: value for name, value in arguments.items() if name not in own}, own)
        self.autoreset_mode = parse_autoreset_mode(autoreset_mode)
        self.metadata = type(self).metadata | {"autoreset_mode": self.autoreset_mode}
        self.render_mode = check_render_mode(render_mode, num_envs)
        self.core = TrackingCore(tasks, num_envs, settings)
        self._stage = stack_layers(self.core, settings.layers)
        self.num_envs = self.core.n
        self.single_observation_space = self._stage.observation_space
        self.single_action_space = self._stage.action_space
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._seeds: list[int | None] = [None] * self.num_envs
        self._ended = np.zeros(self.num_envs, dtype=np.bool_)
        self._flags = (self._ended.copy(), self._ended.copy())
        """Ends of the episodes: terminated, truncated."""
        self._return, self._length = np.zeros(self.num_envs), np.zeros(self.num_envs, dtype=np.int64)
        self._masks: dict[str, BoolArray] = {}
        self._renderer = None if self.render_mode is None else EpisodeRenderer(self.core, self.render_mode)

    @property
    def observation_layout(self) -> ObservationLayout:
        """Layout of an observation, with units and scales."""
        return self.core.observation_layout

    @property
    def action_torque(self) -> Array:
        """Torque of an action of 1, motor side [N m], shape (N,).

        Raises:
            FFGymError: if actions are corrections of set-points, see `action_size`.
        """
        if self.core.corrections is not None:
            raise FFGymError("Actions of this environment correct set-points, see its action_size in rad.")
        return self.action_size

    @property
    def action_size(self) -> Array:
        """Size of an action of 1, motor side: torque [N m], or position of the set-point [rad], shape (N,)."""
        return self.core.action_size.copy()

    @property
    def control_dt(self) -> float:
        """Time between samples of the reference [s]."""
        return self.core.robot.servo.control_dt

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
            options: settings of the episode: options of the task (see its page), plant, randomization, reward, sensing,
                horizon. `options["each"]`: a list with one such dict per sub-environment.

        Raises:
            FFGymError: if an option or a seed is not valid; nothing has changed then. (A failure later, in a layer,
                leaves the environment waiting for another reset.)
        """
        chosen, mask = options_for_each(options, self.num_envs)
        if mask is not None and None in self.core.starts.rngs:
            raise FFGymError("The first reset must be of all sub-environments; leave options['reset_mask'] out.")
        ids = np.flatnonzero(reset_mask(mask, self.num_envs))
        seeds = seeds_for_each(seed, self.num_envs)
        with self.core.all_or_nothing(ids):
            used = self._seed(seeds, ids)
            observation = self._begin(ids, [chosen[i] for i in ids])
        self._seeds = used
        return observation, self._info()

    def step(self, actions: Array) -> tuple[Array, Any, Any, Any, dict[str, Any]]:
        """Add torque for one decision: shape (B, N), clipped to [-1, 1].

        A sub-environment whose episode ended in an earlier step follows the autoreset mode: with NextStep
        it begins anew in this step, whatever its action; with Disabled it waits for `reset`, its flags stay and its
        reward is 0. (SameStep leaves no such sub-environment.)

        Raises:
            FFGymError: if an action has the wrong shape or is not finite, or no episode is running, before anything
                has moved.
        """
        going = ~self._ended if np.count_nonzero(self._ended) else None
        actions = self._check_actions(actions, going)
        if going is None or going.any():
            result = self._stage.step(actions, going)
        else:  # all episodes have ended
            no, still = np.zeros(self.num_envs, dtype=np.bool_), np.zeros(self.num_envs)
            empty = np.zeros(self.observation_space.shape or ())
            result = Transition(observation=empty, reward=still, terminated=no, truncated=no.copy())
        # return and length of each running episode
        self._return += result.reward
        self._length += 1 if going is None else going
        # episodes that ended in an earlier step
        observation, terminated, truncated = result.observation, result.terminated, result.truncated
        if going is not None and self.autoreset_mode is AutoresetMode.NEXT_STEP:
            observation = self._begin_again(self._ended)
        elif going is not None:
            terminated, truncated = terminated | self._flags[0], truncated | self._flags[1]
        # episodes that end in this step
        info = self._info()
        done = result.terminated | result.truncated
        if np.count_nonzero(done):
            info |= score(done, self._return, self._length)
            self._ended, self._flags = self._ended | done, (terminated.copy(), truncated.copy())
            if self.autoreset_mode is AutoresetMode.SAME_STEP:
                info |= finals(observation, info, done)
                observation = self._begin_again(done)
                info |= self._info()
        return observation, result.reward, terminated, truncated, info

    def get_state(self) -> EnvState:
        """Return all that decides how the episodes go on, as a copy, for planning: see `set_state`.

        Raises:
            FFGymError: if no episode has begun, or episodes are recorded.
        """
        if None in self.core.starts.rngs:
            raise FFGymError("There is no state before the first reset; call reset.")
        return EnvState(self, copy_changing(self, _CHANGING), self._stage.save())

    def set_state(self, state: EnvState) -> None:
        """Go back to a state of this environment, bit for bit: physics, motion, randomness, layers, flags, score.

        Raises:
            FFGymError: if the state is of another environment.
        """
        if not isinstance(state, EnvState) or state.owner is not self:
            raise FFGymError(f"state = {state!r} must be one that get_state of this environment returned.")
        self._stage.restore(state.stages)
        restore_changing(self, state.own)

    def _begin_again(self, which: BoolArray) -> Array:
        """Begin new episodes without options; return all observations."""
        ids = np.flatnonzero(which)
        return self._begin(ids, [{}] * len(ids))

    def _info(self) -> dict[str, Any]:
        """Return the info of all sub-environments, with Gymnasium's masks."""
        info = self.core.info()
        if not self._masks:
            self._masks = masks_for(info, self.num_envs)
        return info | self._masks

    def _begin(self, ids: IntArray, options: Sequence[Mapping[str, Any]]) -> Array:
        observation = self._stage.reset(ids, options)
        self._ended[ids], self._return[ids], self._length[ids] = False, 0.0, 0
        for flag in self._flags:
            flag[ids] = False
        return observation

    def _check_actions(self, actions: Any, going: BoolArray | None) -> Array:
        """Check actions where an episode is `going`, before anything has moved; return them as numbers."""
        if self.closed:
            raise FFGymError("This environment is closed; make another one.")
        idle = ~self.core.running if going is None else going & ~self.core.running
        if np.count_nonzero(idle):
            raise FFGymError(f"Sub-environments {np.flatnonzero(idle).tolist()} have no episode running; call reset.")
        if self.autoreset_mode is AutoresetMode.DISABLED and going is not None and not going.any():
            raise FFGymError("No episode is running, all have ended; call reset.")
        return check_actions(actions, (self.num_envs, self.core.robot.n_joints), going)

    def _seed(self, seeds: Sequence[int | None], ids: IntArray) -> list[int | None]:
        """Give sub-environments their randomness, new where a seed is given or there was none; returns all seeds."""
        used = self._seeds.copy()
        for i, seed in enumerate(seeds):
            if self.core.starts.rngs[i] is None or (seed is not None and i in ids):
                rng, used[i] = seeding.np_random(seed)
                self.core.starts.seed(i, rng, fresh=True)
        return used

    def __reduce__(self) -> Any:
        """Refuse to be copied or pickled: the engine cannot."""
        raise FFGymError("An environment cannot be copied or pickled; make another one from its spec: env.spec.make().")

    @property  # type: ignore[misc]  # Gymnasium's vector environments give a tuple too, and have nothing to set
    def np_random(self) -> tuple[np.random.Generator, ...]:  # type: ignore[override]
        """Randomness of each sub-environment."""
        return tuple(rng for rng in self.core.starts.rngs if rng is not None)

    @property
    def np_random_seed(self) -> tuple[int | None, ...]:  # type: ignore[override]
        """Seed of each sub-environment; None before the first reset."""
        return tuple(self._seeds)

    def show(self) -> None:
        """Show sub-environment 0 in MuJoCo's viewer."""
        if self._renderer is not None:
            self._renderer.show()

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Render one picture per sub-environment, each (height, width, 3) of uint8."""
        if self.closed:
            raise FFGymError("This environment is closed; make another one.")
        if self._renderer is None:
            raise FFGymError("There is nothing to render: make the environment with render_mode='rgb_array'.")
        return tuple(self._renderer.frame(i) for i in range(self.num_envs))

    def close_extras(self, **kwargs: Any) -> None:
        """Free the renderer."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None
