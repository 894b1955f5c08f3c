"""Trainings of a few steps."""

from agents.residual.hyperparameters import ALGORITHMS, changed
from agents.residual.plan import Training

_ON = ("n_envs=2", "n_steps=8", "batch_size=8", "segment_steps=16", "n_epochs=2")
_OFF = ("n_envs=2", "learning_starts=8", "batch_size=8", "segment_steps=16", "buffer_size=40", "gradient_steps=2")
SMALL = {"ppo": _ON, "recurrent_ppo": (*_ON, "lstm_cells=8"), "sac": _OFF, "tqc": _OFF}
"""Changes of hyper-parameters: segments of 16 steps."""


def tiny(algorithm="ppo", *changes, **options):
    """A training of three segments."""
    own = {"factored": algorithm != "recurrent_ppo", "steps": 48, "base": "lugre_dynamic"} | options
    values = dict(change.split("=") for change in (*SMALL[algorithm], *changes))
    chosen = changed(algorithm, [f"{name}={value}" for name, value in values.items()])
    return Training(algorithm=algorithm, hyperparameters=chosen, **own)


assert SMALL.keys() == ALGORITHMS.keys()
