"""Algorithms of stable-baselines3 and sb3-contrib, made from a training's hyper-parameters."""

from typing import Any

import numpy as np
from sb3_contrib import TQC, RecurrentPPO
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.noise import ActionNoise
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from torch import nn

from ffgym.agents.residual.learning.environment import ResidualVecEnv
from ffgym.agents.residual.learning.networks import (
    ResidualActorCritic,
    ResidualRecurrentActorCritic,
    ResidualSACPolicy,
    ResidualTQCPolicy,
)
from ffgym.agents.residual.plan import Training
from ffgym.core.types import Array

_ACTIVATIONS: dict[str, type[nn.Module]] = {"tanh": nn.Tanh, "relu": nn.ReLU}


class _BaseActsFirst(OffPolicyAlgorithm):
    """Until learning starts the base acts, with a little noise, in place of residuals drawn from all of their range."""

    prefill_std: float

    def _sample_action(
        self, learning_starts: int, action_noise: ActionNoise | None = None, n_envs: int = 1
    ) -> tuple[Array, Array]:
        if self.num_timesteps >= learning_starts:
            return super()._sample_action(learning_starts, action_noise, n_envs)
        shape = (n_envs, *self.action_space.shape)  # type: ignore[misc]
        noise = np.random.normal(scale=self.prefill_std, size=shape)  # noqa: NPY002 (SB3's own)
        action: Array = np.clip(noise, -1.0, 1.0)
        return action, action


class _SAC(_BaseActsFirst, SAC):
    """SAC that begins with the base."""


class _TQC(_BaseActsFirst, TQC):
    """TQC that begins with the base."""


def algorithm_of(training: Training, env: ResidualVecEnv, *, seed: int, segment: int) -> BaseAlgorithm:
    """The algorithm at the beginning of a segment, untrained.

    Args:
        training: what is trained.
        env: where.
        seed: of torch, numpy, python and the environment, all of which are seeded here.
        segment: number of the segment, for the learning rate.
    """
    common: dict[str, Any] = {
        "env": env,
        "seed": seed,
        "device": "cpu",
        "learning_rate": training.learning_rate(segment),
        "gamma": training.number("gamma"),
        "batch_size": training.integer("batch_size"),
    }
    network: dict[str, Any] = {
        "activation_fn": _ACTIVATIONS[str(training.hyperparameters["activation"])],
        "factored": training.factored,
        "first_std": training.number("first_std"),
    }
    if training.algorithm in ("ppo", "recurrent_ppo"):
        return _on_policy(training, common, network)
    return _off_policy(training, common, network)


def _on_policy(training: Training, common: dict[str, Any], network: dict[str, Any]) -> BaseAlgorithm:
    names = ("gae_lambda", "clip_range", "ent_coef", "vf_coef", "max_grad_norm")
    common |= {name: training.number(name) for name in names}
    common |= {name: training.integer(name) for name in ("n_steps", "n_epochs")}
    network |= {"net_arch": {"pi": training.widths("hidden"), "vf": training.widths("critic_hidden")}}
    if training.algorithm == "ppo":
        return PPO(ResidualActorCritic, policy_kwargs=network, **common)
    network |= {"lstm_hidden_size": training.integer("lstm_cells"), "shared_lstm": True, "enable_critic_lstm": False}
    return RecurrentPPO(ResidualRecurrentActorCritic, policy_kwargs=network, **common)


def _off_policy(training: Training, common: dict[str, Any], network: dict[str, Any]) -> BaseAlgorithm:
    names = ("buffer_size", "train_freq", "gradient_steps", "learning_starts")
    common |= {name: training.integer(name) for name in names}
    n_motors = common["env"].action_space.shape[0]
    common |= {
        "tau": training.number("tau"),
        "ent_coef": f"auto_{training.number('first_ent_coef')!r}",
        "target_entropy": training.number("entropy_per_motor") * n_motors,
    }
    network |= {"net_arch": {"pi": training.widths("hidden"), "qf": training.widths("critic_hidden")}}
    model: _BaseActsFirst
    if training.algorithm == "sac":
        model = _SAC(ResidualSACPolicy, policy_kwargs=network, **common)
    else:
        network |= {name: training.integer(name) for name in ("n_critics", "n_quantiles")}
        drop = training.integer("top_quantiles_to_drop")
        model = _TQC(ResidualTQCPolicy, policy_kwargs=network, top_quantiles_to_drop_per_net=drop, **common)
    model.prefill_std = training.number("prefill_std")
    return model
