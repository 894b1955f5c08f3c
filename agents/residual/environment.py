"""Training environment of residual policies: features in, residuals out, the law below in between."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from gymnasium import spaces
from stable_baselines3.common.vec_env import VecEnvWrapper

from ffgym.agents.amortised.draws import draw_machines
from ffgym.agents.residual.bases import base_law
from ffgym.agents.residual.composition import LIMIT, Composition, PolicyInput, take_where
from ffgym.agents.residual.plan import ENCODER_BITS, ENVIRONMENT, MACHINES_SEED, POSITION, Training
from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.envs import Sensing
from ffgym.envs.sb3 import SB3VecEnv, make_sb3_env
from ffgym.simulation.plant import PlantDistribution


@dataclass(kw_only=True, eq=False)
class LoopChanges:
    """Changes of the residual on its way to the motors, drawn for each episode, which a loop must bear."""

    gain: float
    """Largest factor; factors are drawn evenly in their logarithm from 1 to it."""
    delay: int
    """Largest delay [samples]; delays are drawn evenly from 0 to it."""
    n_envs: int
    """Number of sub-environments B."""
    n_joints: int
    """Number of residuals N of each."""
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))
    factors: Array = field(init=False)
    """Factor of each sub-environment, shape (B,); 1 before its first episode."""
    delays: IntArray = field(init=False)
    """Delay of each sub-environment [samples], shape (B,); 0 before its first episode."""
    past: Array = field(init=False)
    """Residuals, the newest first, shape (D + 1, B, N)."""

    def __post_init__(self) -> None:
        self.factors, self.delays = np.ones(self.n_envs), np.zeros(self.n_envs, dtype=np.int64)
        self.past = np.zeros((self.delay + 1, self.n_envs, self.n_joints))

    def begin(self, where: BoolArray) -> None:
        """Draw changes for the sub-environments where an episode begins, (B,)."""
        factors = np.exp(self.rng.uniform(0.0, np.log(self.gain), self.n_envs))
        delays = self.rng.integers(0, self.delay + 1, self.n_envs)
        self.factors, self.delays = np.where(where, factors, self.factors), np.where(where, delays, self.delays)
        self.past[:, where] = 0.0

    def apply(self, residual: Array) -> Array:
        """Return the residuals that act now, (B, N), after new ones were given."""
        self.past = np.concatenate([residual[None], self.past[:-1]])
        late = self.past[self.delays, np.arange(len(residual))]
        return np.asarray(self.factors[:, None] * late)


class ResidualVecEnv(VecEnvWrapper):
    """Observations are features of a `Composition`, float32 (B, N F); actions its residuals in [-1, 1], (B, N)."""

    def __init__(self, venv: SB3VecEnv, composition: Composition, changes: LoopChanges | None = None) -> None:
        size, n = composition.features.size, composition.features.layout.n_joints
        super().__init__(
            venv,
            observation_space=spaces.Box(-LIMIT, LIMIT, shape=(size,), dtype=np.float32),
            action_space=spaces.Box(-1.0, 1.0, shape=(n,), dtype=np.float32),
        )
        self.composition = composition
        self._changes = changes
        self._seen: PolicyInput | None = None
        self._residual = np.zeros((venv.num_envs, n))

    def reset(self) -> Array:
        """Begin episodes, and return their features."""
        if self._changes is not None:
            self._changes.begin(np.ones(self.num_envs, dtype=np.bool_))
        self._seen = self.composition.begin(self.venv.reset())  # type: ignore[arg-type]
        return self._seen.features.astype(np.float32)

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Seed sub-environments, and changes of their loops."""
        if self._changes is not None:
            self._changes.rng = np.random.default_rng(seed)
        return self.venv.seed(seed)

    def step_async(self, actions: Array) -> None:
        """Send residuals on top of the law's actions."""
        assert self._seen is not None  # reset comes first
        self._residual = np.clip(np.asarray(actions, dtype=np.float64), -1.0, 1.0)
        acting = self._residual if self._changes is None else self._changes.apply(self._residual)
        self.venv.step_async(self.composition.action(self._seen, acting))

    def step_wait(self) -> tuple[Array, Array, Array, list[dict[str, Any]]]:
        """Return features, rewards and ends; last observations of episodes are features too."""
        observation, reward, done, infos = self.venv.step_wait()
        assert isinstance(observation, np.ndarray)
        assert self._seen is not None
        # features before episodes begin anew
        last = observation
        if done.any():
            last = observation.copy()
            for i in np.flatnonzero(done):
                last[i] = infos[i]["terminal_observation"]
        seen = self.composition.follow(self._seen.memory, last, self._residual)
        # features of new episodes
        if done.any():
            for i in np.flatnonzero(done):
                infos[i]["terminal_observation"] = seen.features[i].astype(np.float32)
            seen = take_where(done, self.composition.begin(observation), seen)
            if self._changes is not None:
                self._changes.begin(done)
        self._seen = seen
        return seen.features.astype(np.float32), reward, done, infos


def make_environment(training: Training, n_envs: int | None = None, **changes: Any) -> ResidualVecEnv:
    """Make the environment of a training.

    Args:
        training: the training.
        n_envs: robots side by side; defaults to the training's.
        changes: keyword arguments of the environment in place of the training's.
    """
    robot = training.known()
    own: dict[str, Any] = {
        "robot": training.robot,
        "positions": [POSITION],
        "order": "one",
        "reward": training.reward,
        "action_scale": training.action_scale,
        "preview": training.preview,
        "sensing": Sensing(encoder_bits=ENCODER_BITS),
        "n_threads": 1,
    }
    if training.machines:
        own["plant"] = draw_machines(robot, training.machines, MACHINES_SEED)
    elif training.randomization:
        own["randomization"] = PlantDistribution()
    env = make_sb3_env(ENVIRONMENT, n_envs=n_envs or training.integer("n_envs"), **own | changes)
    law = base_law(training.base, training.machine, robot)
    layout = env.get_attr("observation_layout")[0]
    composition = Composition.over(law, robot, layout, memory=training.memory, bound=training.bound)
    loop = None
    if training.gain_margin > 1 or training.delay_margin > 0:
        loop = LoopChanges(
            gain=training.gain_margin, delay=training.delay_margin, n_envs=env.num_envs, n_joints=layout.n_joints
        )
    return ResidualVecEnv(env, composition, loop)
