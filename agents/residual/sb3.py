"""Policies and algorithms of stable-baselines3, and their trained networks as the actor in numpy.

A policy's actor begins with residuals of zero. Its arguments are `first_std`, the standard deviation of exploration at
the beginning in units of the bound, and `factored`: one network of each motor's own numbers for all motors (True), or
one network that sees all of them (False).
"""

import math
from typing import Any

import numpy as np
import torch
from sb3_contrib import TQC, RecurrentPPO
from sb3_contrib.common.recurrent.policies import RecurrentActorCriticPolicy
from sb3_contrib.tqc.policies import TQCPolicy
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.noise import ActionNoise
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor, MlpExtractor, create_mlp
from stable_baselines3.common.type_aliases import Schedule
from stable_baselines3.sac.policies import SACPolicy
from torch import nn

from ffgym.agents.residual.actor import LSTM, Actor, LinearLayer
from ffgym.agents.residual.environment import ResidualVecEnv
from ffgym.agents.residual.plan import Training
from ffgym.core.errors import FFGymError
from ffgym.core.types import Array


class PerMotor(nn.Module):
    """One network for all motors: (B, N F) -> (B, N H)."""

    def __init__(self, n_motors: int, network: nn.Module) -> None:
        super().__init__()
        self.n_motors, self.network = n_motors, network

    def forward(self, features: torch.Tensor) -> torch.Tensor:
        """Run it on each motor's numbers."""
        batch = features.shape[0]
        out: torch.Tensor = self.network(features.reshape(batch * self.n_motors, -1))
        return out.reshape(batch, -1)


class _FactoredExtractor(MlpExtractor):
    """Actor's layers per motor; the critic sees all motors."""

    def __init__(self, features: int, n_motors: int, net_arch: dict[str, list[int]], activation: type[nn.Module]):
        super().__init__(features, net_arch, activation)
        layers = create_mlp(features // n_motors, -1, net_arch["pi"], activation)
        self.policy_net = PerMotor(n_motors, nn.Sequential(*layers))  # type: ignore[assignment]
        self.latent_dim_pi = n_motors * net_arch["pi"][-1]


class ResidualActorCritic(ActorCriticPolicy):
    """Policy of PPO: Gaussian actions about a mean that is zero at first."""

    def __init__(self, *args: Any, factored: bool = False, first_std: float = 0.1, **kwargs: Any) -> None:
        self.factored = factored
        super().__init__(*args, **kwargs | {"log_std_init": math.log(first_std)})

    def _build_mlp_extractor(self) -> None:
        if not self.factored:
            super()._build_mlp_extractor()
            return
        assert isinstance(self.net_arch, dict)
        n = self.action_space.shape[0]  # type: ignore[index]
        self.mlp_extractor = _FactoredExtractor(self.features_dim, n, self.net_arch, self.activation_fn)

    def _build(self, lr_schedule: Schedule) -> None:
        super()._build(lr_schedule)
        n = self.action_space.shape[0]  # type: ignore[index]
        if self.factored:
            self.action_net = PerMotor(n, nn.Linear(self.mlp_extractor.latent_dim_pi // n, 1))
        _zero(self.action_net)
        settings = {"lr": lr_schedule(1)} | self.optimizer_kwargs
        self.optimizer = self.optimizer_class(self.parameters(), **settings)


class ResidualRecurrentActorCritic(RecurrentActorCriticPolicy):
    """Policy of RecurrentPPO: an LSTM that sees all motors, and a mean that is zero at first."""

    def __init__(self, *args: Any, factored: bool = False, first_std: float = 0.1, **kwargs: Any) -> None:
        if factored:
            raise ValueError("the LSTM sees all motors at once")
        super().__init__(*args, **kwargs | {"log_std_init": math.log(first_std)})

    def _build(self, lr_schedule: Schedule) -> None:
        super()._build(lr_schedule)
        _zero(self.action_net)


class _BeginsAsNothing:
    """Squashed Gaussian actions about zero at first."""

    def __init__(self, *args: Any, factored: bool = False, first_std: float = 0.1, **kwargs: Any) -> None:
        self.factored, self.first_std = factored, first_std
        super().__init__(*args, **kwargs)

    def make_actor(self, features_extractor: BaseFeaturesExtractor | None = None) -> Any:
        """Make the actor, factored if asked for, with actions about zero."""
        actor = super().make_actor(features_extractor)  # type: ignore[misc]
        if self.factored:
            n, width = actor.action_space.shape[0], actor.net_arch[-1]
            layers = create_mlp(actor.features_dim // n, -1, actor.net_arch, actor.activation_fn)
            actor.latent_pi = PerMotor(n, nn.Sequential(*layers))
            actor.mu, actor.log_std = (PerMotor(n, nn.Linear(width, 1)) for _ in range(2))
            actor.to(actor.device)
        _zero(actor.mu)
        _zero(actor.log_std, math.log(self.first_std))
        return actor


class ResidualSACPolicy(_BeginsAsNothing, SACPolicy):
    """Policy of SAC."""


class ResidualTQCPolicy(_BeginsAsNothing, TQCPolicy):
    """Policy of TQC."""


def _zero(head: nn.Module, bias: float = 0.0) -> None:
    """Let a last layer give `bias` whatever it sees."""
    layer = head.network if isinstance(head, PerMotor) else head
    assert isinstance(layer, nn.Linear)
    nn.init.zeros_(layer.weight)
    nn.init.constant_(layer.bias, bias)


_ACTIVATIONS: dict[str, type[nn.Module]] = {"tanh": nn.Tanh, "relu": nn.ReLU}
_NAMES = {module: name for name, module in _ACTIVATIONS.items()}


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


def make_algorithm(training: Training, env: ResidualVecEnv, *, seed: int, segment: int) -> BaseAlgorithm:
    """Make the algorithm at the beginning of a segment, untrained.

    Args:
        training: the training.
        env: its environment.
        seed: seed of torch, numpy, python and the environment, all of which are seeded here.
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


def export_actor(policy: Any) -> Actor:
    """Export the actor of a policy of `ffgym.agents.residual.sb3`, without exploration.

    Raises:
        FFGymError: if its networks are of another form.
    """
    n = int(policy.action_space.shape[0])
    if hasattr(policy, "action_net"):
        hidden, head, output = policy.mlp_extractor.policy_net, policy.action_net, "clip"
    else:
        hidden, head, output = policy.actor.latent_pi, policy.actor.mu, "tanh"
    # linear layers and the one activation between them
    factored = isinstance(head, PerMotor)
    modules = [*_inner(hidden), *_inner(head)]
    linear = [module for module in modules if isinstance(module, nn.Linear)]
    between = {type(module) for module in modules if not isinstance(module, nn.Linear)}
    if len(between) != 1 or not between <= set(_NAMES) or len(modules) != 2 * len(linear) - 1:
        raise FFGymError(f"Layers {modules} are no linear ones with one activation between them, so there is no actor.")
    return Actor(
        n_motors=n,
        layers=tuple(LinearLayer(weight=_array(layer.weight), bias=_array(layer.bias)) for layer in linear),
        activation=_NAMES[between.pop()],
        output=output,
        factored=factored,
        lstm=_lstm(policy.lstm_actor) if hasattr(policy, "lstm_actor") else None,
    )


def _inner(module: nn.Module) -> list[nn.Module]:
    """List the layers one after the other."""
    if isinstance(module, PerMotor):
        return _inner(module.network)
    return list(module) if isinstance(module, nn.Sequential) else [module]


def _lstm(module: nn.LSTM) -> LSTM:
    if module.num_layers != 1 or module.bidirectional:
        raise FFGymError(f"{module} has more than one layer or direction, so there is no actor.")
    weights = dict(module.named_parameters())
    return LSTM(
        inputs=LinearLayer(weight=_array(weights["weight_ih_l0"]), bias=_array(weights["bias_ih_l0"])),
        hidden=LinearLayer(weight=_array(weights["weight_hh_l0"]), bias=_array(weights["bias_hh_l0"])),
    )


def _array(values: torch.Tensor) -> Array:
    return values.detach().cpu().numpy().astype(np.float64)
