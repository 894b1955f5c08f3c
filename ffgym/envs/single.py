"""Single environment: the vector environment with one robot."""

from typing import Any, ClassVar, SupportsFloat

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from ffgym.control.observation import ObservationLayout
from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.types import Array
from ffgym.envs.arguments import check_seed
from ffgym.envs.vector import EnvState, TrackingVectorEnv


class TrackingEnv(gym.Env[Array, Array]):
    """One robot that tracks a motion; its bits are those of a sub-environment of the vector environment."""

    metadata: dict[str, Any] = {"render_modes": ["rgb_array", "human"], "render_fps": 25}  # noqa: RUF012  (Gymnasium's way)

    kind: ClassVar[type[TrackingVectorEnv]]
    """Vector environment of the same keyword arguments."""

    def __init__(self, *, render_mode: str | None = None, **arguments: Any) -> None:
        for name in ("num_envs", "autoreset_mode"):
            if name in arguments:
                raise FFGymError(f"{name} = {arguments[name]!r} is for many robots: use gymnasium.make_vec.")
        self._batch = self.kind(
            1, autoreset_mode=AutoresetMode.DISABLED, render_mode=render_mode, **({"n_threads": 1} | arguments)
        )
        self.render_mode = render_mode
        self.observation_space = self._batch.single_observation_space
        self.action_space = self._batch.single_action_space

    @property
    def core(self) -> Any:
        """The engine."""
        return self._batch.core

    @property
    def observation_layout(self) -> ObservationLayout:
        """Layout of an observation, with units and scales."""
        return self._batch.observation_layout

    @property
    def action_torque(self) -> Array:
        """Torque of an action of 1, see `TrackingVectorEnv.action_torque`."""
        return self._batch.action_torque

    @property
    def action_size(self) -> Array:
        """Size of an action of 1, see `TrackingVectorEnv.action_size`."""
        return self._batch.action_size

    @property
    def control_dt(self) -> float:
        """Time between samples of the reference [s]."""
        return self._batch.control_dt

    @property
    def decision_dt(self) -> float:
        """Time between actions [s]."""
        return self._batch.decision_dt

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Begin an episode.

        Args:
            seed: seed of everything that is drawn; None goes on with the present randomness.
            options: settings of the episode: options of the task (see its page), plant, randomization, reward, sensing,
                horizon.

        Raises:
            FFGymError: if an option or the seed is not valid; nothing has changed then. (A failure later, in a layer,
                leaves the environment waiting for another reset.)
        """
        before = self._np_random, self._np_random_seed
        try:
            super().reset(seed=None if seed is None else check_seed(seed))
            with self.core.all_or_nothing(np.array([0])):
                self.core.starts.seed(0, self.np_random, fresh=seed is not None)
                observation, info = self._batch.reset(options=options)
        except BaseException:
            self._np_random, self._np_random_seed = before
            raise
        if self.render_mode == "human":
            self._batch.show()
        return observation[0], _first(info)

    def step(self, action: Array) -> tuple[Array, SupportsFloat, bool, bool, dict[str, Any]]:
        """Add torque for one decision: shape (N,), clipped to [-1, 1].

        Raises:
            FFGymError: if the action has the wrong shape or is not finite, or no episode is running.
        """
        action = check_shape("action", action, self.action_space.shape or ())
        observation, reward, terminated, truncated, info = self._batch.step(action[None])
        if self.render_mode == "human":
            self._batch.show()
        return observation[0], float(reward[0]), bool(terminated[0]), bool(truncated[0]), _first(info)

    def get_state(self) -> EnvState:
        """Return all that decides how the episode goes on, as a copy, for planning; see `set_state`.

        Raises:
            FFGymError: if no episode has begun, or episodes are recorded.
        """
        return self._batch.get_state()

    def set_state(self, state: EnvState) -> None:
        """Go back to a state of this environment, bit for bit; Gymnasium's wrappers keep counters of their own.

        Raises:
            FFGymError: if the state is of another environment.
        """
        self._batch.set_state(state)

    def render(self) -> NDArray[np.uint8] | None:
        """Render the present state, (height, width, 3) of uint8; None in mode 'human', which shows it."""
        if self.render_mode == "human":
            self._batch.show()
            return None
        pictures = self._batch.render()
        return None if pictures is None else pictures[0]

    def __reduce__(self) -> Any:
        """Refuse to be copied or pickled: the engine cannot."""
        raise FFGymError("An environment cannot be copied or pickled; make another one from its spec: env.spec.make().")

    def close(self) -> None:
        """Free the renderer."""
        self._batch.close()


def _first(info: dict[str, Any]) -> dict[str, Any]:
    """Return the info of sub-environment 0, without masks."""
    first = {}
    for name, value in info.items():
        if not name.startswith("_"):
            own = _first(value) if isinstance(value, dict) else value[0]
            first[name] = own.item() if isinstance(own, np.generic) else own.copy()  # Python's own numbers and text
    return first
