"""Policies of stable-baselines3 whose actor begins as nothing, and may be one small network shared by all motors.

Every actor here is given `first_std`, the standard deviation of exploration at the beginning in units of the bound, and
`factored`: whether one network of each motor's own numbers serves all motors, or one network sees all of them.
"""

import math
from typing import Any

import torch
from sb3_contrib.common.recurrent.policies import RecurrentActorCriticPolicy
from sb3_contrib.tqc.policies import Actor as TQCActor
from sb3_contrib.tqc.policies import TQCPolicy
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor, MlpExtractor, create_mlp
from stable_baselines3.common.type_aliases import Schedule
from stable_baselines3.sac.policies import Actor as SACActor
from stable_baselines3.sac.policies import SACPolicy
from torch import nn


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
    """Of PPO: Gaussian actions about a mean that is zero at first."""

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
    """Of RecurrentPPO: an LSTM that sees all motors, and a mean that is zero at first."""

    def __init__(self, *args: Any, factored: bool = False, first_std: float = 0.1, **kwargs: Any) -> None:
        if factored:
            raise ValueError("the LSTM sees all motors at once")
        super().__init__(*args, **kwargs | {"log_std_init": math.log(first_std)})

    def _build(self, lr_schedule: Schedule) -> None:
        super()._build(lr_schedule)
        _zero(self.action_net)


class ResidualSACPolicy(SACPolicy):
    """Of SAC: squashed Gaussian actions about zero at first."""

    def __init__(self, *args: Any, factored: bool = False, first_std: float = 0.1, **kwargs: Any) -> None:
        self.factored, self.first_std = factored, first_std
        super().__init__(*args, **kwargs)

    def make_actor(self, features_extractor: BaseFeaturesExtractor | None = None) -> SACActor:
        """See base class."""
        return _begun(super().make_actor(features_extractor), self.factored, self.first_std)


class ResidualTQCPolicy(TQCPolicy):
    """Of TQC, as that of SAC."""

    def __init__(self, *args: Any, factored: bool = False, first_std: float = 0.1, **kwargs: Any) -> None:
        self.factored, self.first_std = factored, first_std
        super().__init__(*args, **kwargs)

    def make_actor(self, features_extractor: BaseFeaturesExtractor | None = None) -> TQCActor:
        """See base class."""
        return _begun(super().make_actor(features_extractor), self.factored, self.first_std)


def _begun(actor: Any, factored: bool, first_std: float) -> Any:
    """The actor with its last layers at zero action and `first_std`, and per motor where it is factored."""
    if factored:
        n, width = actor.action_space.shape[0], actor.net_arch[-1]
        layers = create_mlp(actor.features_dim // n, -1, actor.net_arch, actor.activation_fn)
        actor.latent_pi = PerMotor(n, nn.Sequential(*layers))
        actor.mu, actor.log_std = (PerMotor(n, nn.Linear(width, 1)) for _ in range(2))
        actor.to(actor.device)
    _zero(actor.mu)
    _zero(actor.log_std, math.log(first_std))
    return actor


def _zero(head: nn.Module, bias: float = 0.0) -> None:
    """Let a last layer give `bias` whatever it sees."""
    layer = head.network if isinstance(head, PerMotor) else head
    assert isinstance(layer, nn.Linear)
    nn.init.zeros_(layer.weight)
    nn.init.constant_(layer.bias, bias)
