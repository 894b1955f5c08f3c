"""Trained networks of torch as the actor in numpy."""

from typing import Any

import numpy as np
import torch
from torch import nn

from ffgym.agents.residual.actor import LSTM, Actor, Layer
from ffgym.agents.residual.learning.networks import PerMotor
from ffgym.core.errors import FFGymError
from ffgym.core.types import Array

_ACTIVATIONS = {nn.Tanh: "tanh", nn.ReLU: "relu"}


def actor_of(policy: Any) -> Actor:
    """The actor of a policy of `ffgym.agents.residual.learning.networks`: what `predict` does when it does not explore.

    Raises:
        FFGymError: if its networks are of another form.
    """
    n = int(policy.action_space.shape[0])
    if hasattr(policy, "action_net"):
        hidden, head, output = policy.mlp_extractor.policy_net, policy.action_net, "clip"
    else:
        hidden, head, output = policy.actor.latent_pi, policy.actor.mu, "tanh"
    factored = isinstance(head, PerMotor)
    modules = [*_inner(hidden), *_inner(head)]
    linear = [module for module in modules if isinstance(module, nn.Linear)]
    between = {type(module) for module in modules if not isinstance(module, nn.Linear)}
    if len(between) != 1 or not between <= set(_ACTIVATIONS) or len(modules) != 2 * len(linear) - 1:
        raise FFGymError(f"Layers {modules} are no linear ones with one activation between them, so there is no actor.")
    return Actor(
        n_motors=n,
        layers=tuple(Layer(weight=_array(layer.weight), bias=_array(layer.bias)) for layer in linear),
        activation=_ACTIVATIONS[between.pop()],
        output=output,
        factored=factored,
        lstm=_lstm(policy.lstm_actor) if hasattr(policy, "lstm_actor") else None,
    )


def _inner(module: nn.Module) -> list[nn.Module]:
    """Layers one after the other."""
    if isinstance(module, PerMotor):
        return _inner(module.network)
    return list(module) if isinstance(module, nn.Sequential) else [module]


def _lstm(module: nn.LSTM) -> LSTM:
    if module.num_layers != 1 or module.bidirectional:
        raise FFGymError(f"{module} has more than one layer or direction, so there is no actor.")
    weights = dict(module.named_parameters())
    return LSTM(
        inputs=Layer(weight=_array(weights["weight_ih_l0"]), bias=_array(weights["bias_ih_l0"])),
        hidden=Layer(weight=_array(weights["weight_hh_l0"]), bias=_array(weights["bias_hh_l0"])),
    )


def _array(values: torch.Tensor) -> Array:
    return values.detach().cpu().numpy().astype(np.float64)
