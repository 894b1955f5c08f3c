"""Trainings of a few steps, and policies that nobody trained."""

from itertools import pairwise

import numpy as np

from ffgym.agents.residual.actor import LSTM, Actor, LinearLayer
from ffgym.agents.residual.hyperparameters import ALGORITHMS, hyperparameters
from ffgym.agents.residual.plan import Training
from ffgym.agents.residual.policy import ResidualPolicy

_ON = ("n_envs=2", "n_steps=8", "batch_size=8", "segment_steps=16", "n_epochs=2")
_OFF = ("n_envs=2", "learning_starts=8", "batch_size=8", "segment_steps=16", "buffer_size=40", "gradient_steps=2")
SMALL = {"ppo": _ON, "recurrent_ppo": (*_ON, "lstm_cells=8"), "sac": _OFF, "tqc": _OFF}
"""Changes of hyper-parameters: segments of 16 steps."""


def tiny(algorithm="ppo", *changes, **options):
    """A training of three segments."""
    own = {"factored": algorithm != "recurrent_ppo", "steps": 48, "base": "lugre_dynamic"} | options
    values = dict(change.split("=") for change in (*SMALL[algorithm], *changes))
    chosen = hyperparameters(algorithm, [f"{name}={value}" for name, value in values.items()])
    return Training(algorithm=algorithm, hyperparameters=chosen, **own)


def policy_of(size=0.3, memory=2, seed=5, **options):
    """A policy with random weights."""
    rng = np.random.default_rng(seed)
    widths = (3 * memory + 12, 8, 1)
    layers = tuple(
        LinearLayer(
            weight=(size * rng.normal(size=(b, a))).astype(np.float32), bias=rng.normal(size=b).astype(np.float32)
        )
        for a, b in pairwise(widths)
    )
    actor = Actor(n_motors=6, layers=layers, activation="tanh", output="clip", factored=True)
    own = {"base": "lugre_dynamic", "bound": 0.6, "action_scale": 30.0, "meta": {"seed": seed}}
    return ResidualPolicy(actor=actor, memory=memory, **own | options)


def random_actor(rng, **options):
    """An actor for two motors with random weights."""

    def layer(outputs, inputs):
        return LinearLayer(weight=rng.normal(size=(outputs, inputs)), bias=rng.normal(size=outputs))

    factored = options.get("factored", False)
    lstm = None if factored else LSTM(inputs=layer(20, 18), hidden=layer(20, 5))
    layers = (layer(7, 9 if factored else 5), layer(1 if factored else 2, 7))
    own = {"n_motors": 2, "activation": "relu", "output": "tanh", "factored": False, "lstm": lstm, "layers": layers}
    return Actor(**own | options)


assert SMALL.keys() == ALGORITHMS.keys()
