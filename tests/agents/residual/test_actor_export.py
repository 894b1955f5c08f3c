"""What a network of torch does, its copy in numpy does too."""

import numpy as np
import pytest
import torch
from gymnasium import spaces
from torch import nn

from ffgym.agents.residual.actor import LSTM, Actor
from ffgym.agents.residual.environment import make_environment
from ffgym.agents.residual.sb3 import export_actor, make_algorithm
from ffgym.core.errors import FFGymError
from tests.agents.residual.residual_samples import random_actor, tiny

CASES = [("ppo", True), ("ppo", False), ("recurrent_ppo", False), ("sac", True), ("sac", False), ("tqc", True)]


@pytest.fixture(scope="module")
def env():
    env = make_environment(tiny())
    yield env
    env.close()


@pytest.mark.parametrize(("algorithm", "factored"), CASES)
def test_torch_and_numpy_act_alike_whatever_the_algorithm(algorithm, factored, env):
    model = make_algorithm(tiny(algorithm, factored=factored), env, seed=3, segment=0)
    with torch.no_grad():
        for values in model.policy.parameters():
            values.add_(0.3 * torch.randn_like(values))
    actor = export_actor(model.policy)
    rng = np.random.default_rng(0)
    theirs, ours = None, actor.initial_state((2,))
    actions = []
    for begins in ([True, True], [False, False], [False, True], [False, False]):
        features = rng.normal(size=(2, actor.n_features)).astype(np.float32)
        wanted, theirs = model.predict(features, theirs, np.array(begins), deterministic=True)
        found, ours = actor.act(features, ours, np.array(begins))
        np.testing.assert_allclose(found, wanted, atol=1e-5)
        actions.append(found)
    assert np.ptp(actions) > 0.1
    again = Actor.from_parts(actor.settings(), actor.arrays())
    np.testing.assert_array_equal(again.act(features, again.initial_state((2,)))[0], again.act(features, ours * 0)[0])


@pytest.mark.parametrize("algorithm", ["ppo", "recurrent_ppo", "sac", "tqc"])
def test_an_untrained_actor_adds_nothing(algorithm, env):
    actor = export_actor(make_algorithm(tiny(algorithm), env, seed=0, segment=0).policy)
    features = np.random.default_rng(1).normal(size=(5, actor.n_features))
    np.testing.assert_array_equal(actor.act(features, actor.initial_state((5,)))[0], np.zeros((5, 6)))


@pytest.mark.parametrize("factored", [True, False])
def test_a_row_does_not_depend_on_its_neighbours(factored):
    rng = np.random.default_rng(2)
    actor = random_actor(rng, factored=factored)
    features = rng.normal(size=(33, 18))
    state = rng.normal(size=actor.initial_state((33,)).shape)
    together, after = actor.act(features, state)
    for k in (0, 7, 32):
        alone, own = actor.act(features[k], state[k])
        np.testing.assert_array_equal(alone, together[k])
        np.testing.assert_array_equal(own, after[k])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"activation": "sine"}, "Unknown activation 'sine'"),
        ({"output": "none"}, "Unknown output 'none'"),
        ({"layers": ()}, "layers must be one or more"),
        ({"n_motors": 3}, r"weight of layer 1 has shape \(2, 7\), must be \(3, 7\)"),
        ({"factored": True, "lstm": LSTM(inputs=None, hidden=None)}, "An LSTM sees all motors at once"),
    ],
)
def test_networks_that_do_not_fit_together_are_refused(options, message):
    with pytest.raises(FFGymError, match=message):
        random_actor(np.random.default_rng(0), **options)


def test_a_network_of_another_form_is_no_actor():
    class Policy:
        action_space = spaces.Box(-1, 1, (2,))
        mlp_extractor = type("Extractor", (), {"policy_net": nn.Sequential(nn.Linear(3, 3), nn.Softplus())})
        action_net = nn.Linear(3, 2)

    with pytest.raises(FFGymError, match="so there is no actor"):
        export_actor(Policy())
