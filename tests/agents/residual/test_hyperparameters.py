"""Hyper-parameters: every one is in its file, explained, checked."""

import tomllib

import pytest

from ffgym.agents.residual.hyperparameters import ALGORITHMS, FILE, check_hyperparameters, hyperparameters
from ffgym.agents.residual.plan import Training
from ffgym.core.errors import FFGymError


def text_of(algorithm):
    return FILE.read_text(encoding="utf-8").split(f"\n[{algorithm}]\n")[1].split("\n[")[0]


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_each_algorithm_has_a_file_with_all_of_its_hyperparameters(algorithm):
    values = hyperparameters(algorithm)
    assert values.keys() == ALGORITHMS[algorithm].keys()
    assert check_hyperparameters(algorithm, values) == values


@pytest.mark.parametrize("algorithm", ["ppo", "sac"])
def test_each_number_of_the_first_files_has_its_reason_beside_it(algorithm):
    for line in text_of(algorithm).splitlines():
        if "=" in line.partition("#")[0] and not line.startswith("final_learning_rate"):
            assert line.partition("#")[2].strip(), line


@pytest.mark.parametrize("algorithm", ["recurrent_ppo", "tqc"])
def test_what_has_no_reason_in_the_other_files_is_as_in_the_first(algorithm):
    other = hyperparameters({"recurrent_ppo": "ppo", "tqc": "sac"}[algorithm])
    for line in text_of(algorithm).splitlines():
        name, equals, rest = line.partition("=")
        if equals and "#" not in line and not name.startswith(("#", "final_learning_rate")):
            assert tomllib.loads(f"v = {rest}")["v"] == (
                list(other[name.strip()]) if isinstance(other[name.strip()], tuple) else other[name.strip()]
            ), name


def test_some_can_be_changed_by_name_and_value():
    values = hyperparameters("ppo", ["gamma=0.5", "hidden=[8, 4]", "activation=relu"])
    assert (values["gamma"], values["hidden"], values["activation"]) == (0.5, (8, 4), "relu")
    assert hyperparameters("ppo", []) == hyperparameters("ppo")


@pytest.mark.parametrize(
    ("algorithm", "change", "message"),
    [
        ("ppo", "gama=0.5", "Unknown hyper-parameter of ppo 'gama'. Available: activation, batch_size, clip_range"),
        ("sac", "n_steps=4", "Unknown hyper-parameter of sac 'n_steps'"),
        ("ppo", "gamma", "'gamma' is no name=value"),
        ("ppo", "gamma=1.5", "gamma = 1.5 is out of range"),
        ("ppo", "gamma=much", "gamma must be a number, got 'much'"),
        ("ppo", "hidden=[]", r"hidden = \[\] must be a list of one to four widths"),
        ("ppo", "n_envs=2.5", "n_envs = 2.5 must be a whole number"),
        ("ppo", "activation=sine", "Unknown activation 'sine'"),
        ("ppo", "segment_steps=100", "segment_steps = 100 of ppo must be a multiple of 4096"),
        ("ppo", "batch_size=500", "batch_size = 500 of ppo must divide n_steps . n_envs = 4096"),
        ("tqc", "top_quantiles_to_drop=10", "must be less than n_quantiles = 10"),
    ],
)
def test_what_is_no_hyperparameter_is_one_clear_error(algorithm, change, message):
    with pytest.raises(FFGymError, match=message):
        hyperparameters(algorithm, [change])


def test_a_hyperparameter_is_changed_once_and_none_may_be_missing():
    with pytest.raises(FFGymError, match=r"'gamma=0.2' stands twice"):
        hyperparameters("ppo", ["gamma=0.1", "gamma=0.2"])
    with pytest.raises(FFGymError, match="Hyper-parameters of ppo lack clip_range, gamma"):
        check_hyperparameters(
            "ppo", {k: v for k, v in hyperparameters("ppo").items() if k not in ("gamma", "clip_range")}
        )
    with pytest.raises(FFGymError, match="Unknown algorithm 'dqn'"):
        hyperparameters("dqn")


def test_the_learning_rate_falls_evenly_from_segment_to_segment():
    training = Training(steps=4 * 65536)
    rates = [training.learning_rate(segment) for segment in range(training.n_segments)]
    assert rates == pytest.approx([3e-3, 2.1e-3, 1.2e-3, 3e-4])
    assert Training(steps=1).learning_rate(0) == 3e-3


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"algorithm": "recurrent_ppo"}, "train it with factored=False"),
        ({"base": "ilc_tcp"}, "Unknown base 'ilc_tcp'. Available: elastic, lugre_dynamic"),
        ({"bound": 0.0}, "bound of the residual = 0.0"),
        ({"memory": 0}, "memory = 0.0 samples"),
        ({"steps": 0}, "steps = 0"),
        ({"steps": 10**9}, "steps = 1000000000"),
        ({"seed": -1}, "seed = -1"),
        ({"algorithm": "sac", "steps": 2000}, "steps = 2000 must be more than learning_starts = 2000.*lower learning_"),
    ],
)
def test_a_training_that_makes_no_sense_is_refused(options, message):
    with pytest.raises(FFGymError, match=message):
        Training(**options)


def test_a_robot_without_a_place_for_circles_is_refused():
    with pytest.raises(FFGymError, match="'one_axis' has no position 'p1'"):
        Training(robot="one_axis").known()
    with pytest.raises(FFGymError, match="Base 'model' needs text of a machine file"):
        Training(base="model").known()
