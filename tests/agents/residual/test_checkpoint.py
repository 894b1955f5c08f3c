"""A checkpoint holds everything that an algorithm learned, not only what two trainings would lose alike."""

from collections.abc import Mapping

import numpy as np
import pytest
import torch

from ffgym.agents.residual.environment import make_environment
from ffgym.agents.residual.hyperparameters import ALGORITHMS
from ffgym.agents.residual.sb3 import make_algorithm
from ffgym.agents.residual.training import read_checkpoint, restore, write_checkpoint
from tests.agents.residual.residual_samples import tiny


def flat(values, name=""):
    """Every number in tables in tables and lists, by its place."""
    if isinstance(values, Mapping):
        return {k: v for key, each in values.items() for k, v in flat(each, f"{name}.{key}").items()}
    if isinstance(values, list | tuple):
        return {k: v for i, each in enumerate(values) for k, v in flat(each, f"{name}[{i}]").items()}
    return {name: values.detach().numpy().copy() if isinstance(values, torch.Tensor) else values}


def state_of(model):
    """What an algorithm knows."""
    _, tensors = model._get_torch_save_params()
    own = flat(model.get_parameters()) | {name: getattr(model, name).detach().numpy().copy() for name in tensors}
    own |= {"steps": model.num_timesteps, "updates": model._n_updates}
    buffer = getattr(model, "replay_buffer", None)
    if buffer is not None:
        own |= {k: v.copy() for k, v in vars(buffer).items() if isinstance(v, np.ndarray)}
        own |= {"pos": buffer.pos, "full": buffer.full}
    return own


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_an_algorithm_comes_back_with_all_that_it_had(algorithm, tmp_path):
    training, file = tiny(algorithm), tmp_path / "checkpoint.pt"
    env = make_environment(training)
    model = make_algorithm(training, env, seed=1, segment=0)
    first = state_of(model)
    for segment in (1, 2):  # the replay buffer of 20 rows is full, and begins anew, in the second
        model.learn(24, reset_num_timesteps=segment == 1)
        write_checkpoint(file, model, segment=segment, curve=((24, -0.5),), about={"a": 1})
        assert [*tmp_path.iterdir()] == [file]
        standing = read_checkpoint(file, {"a": 1})
        assert (standing["segment"], standing["curve"]) == (segment, ((24, -0.5),))
        again = make_algorithm(training, env, seed=2, segment=0)
        restore(again, standing)
        wanted, found = state_of(model), state_of(again)
        assert wanted.keys() == found.keys()
        for name, values in wanted.items():
            np.testing.assert_array_equal(found[name], values, err_msg=name)
    env.close()
    changed = {name for name, values in first.items() if not np.array_equal(wanted[name], values)}
    assert {"steps", "updates"} <= changed
    if algorithm in ("sac", "tqc"):
        assert {"log_ent_coef", "observations", "rewards", "pos", "full"} <= changed
