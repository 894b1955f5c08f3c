"""Hyper-parameters for plain stable-baselines3 in the form of rl-zoo3, and what they reach."""

import re
from inspect import signature
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from stable_baselines3 import PPO

import ffgym
from ffgym.core.registration import ENVIRONMENTS
from ffgym.envs import make_sb3_env

ROOT = Path(__file__).parents[2]
NUMBERS = yaml.safe_load((ROOT / "agents" / "zoo" / "ppo.yml").read_text(encoding="utf-8"))
OF_ZOO = {"n_timesteps", "n_envs", "env_kwargs"}
"""Entries that rl-zoo3 reads itself; all others it gives to the algorithm."""


@pytest.mark.parametrize("name", NUMBERS)
def test_numbers_are_those_of_an_environment_and_of_the_algorithm(name):
    assert name in ENVIRONMENTS
    own = NUMBERS[name]
    assert own.keys() - OF_ZOO <= signature(PPO).parameters.keys()
    assert own["learning_rate"].startswith("lin_")
    assert own["n_steps"] * own["n_envs"] % own["batch_size"] == 0
    make_sb3_env(name, n_envs=1, **own["env_kwargs"]).close()


def lessons() -> dict[str, Any]:
    """Return the functions of the tutorial that train and examine a policy, by name."""
    page = (ROOT / "docs" / "tutorials" / "environments.md").read_text(encoding="utf-8")
    learning, exam = re.findall(r"```python\n(.*?)```", page, flags=re.S)[1:3]
    names: dict[str, Any] = {"np": np, "ffgym": ffgym}
    exec(compile(learning, "environments.md", "exec"), names)
    exec(compile(exam.partition("model = learn")[0], "environments.md", "exec"), names)
    return names


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "motions", "circles", "most"), [("ffgym/OneAxis-v1", 2, 1, 0.4), ("ffgym/WorkcellCircles-v1", 12, 3, 0.98)]
)
def test_the_full_budget_beats_the_base_as_the_tutorial_says(name, motions, circles, most):
    tutorial = lessons()
    assert tutorial["error_left"](tutorial["learn"](name), name, motions, circles) < most


@pytest.mark.slow
def test_half_of_the_budget_beats_elastic_feed_forward_on_the_circles_of_a_workcell():
    name, tutorial = "ffgym/WorkcellCircles-v1", lessons()
    model = tutorial["learn"](name, steps=NUMBERS[name]["n_timesteps"] // 2)
    # three seeds leave 0.94 to 0.96
    assert tutorial["error_left"](model, name, motions=12, circles=3) < 0.98
