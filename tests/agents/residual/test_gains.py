"""Servo gains: a linear feedback as a residual policy, and the row that learned feedback is measured by."""

import shlex
from dataclasses import replace

import numpy as np
import pytest
import tyro

from ffgym.agents.artefacts import locate_artefact, read_manifest
from ffgym.agents.residual.gains import SERVO_GAINS, SERVO_GAINS_DRIVES, SERVO_GAINS_STABLE, make_gains
from ffgym.agents.residual.policy import load_policy
from ffgym.agents.residual.validation import validate
from ffgym.core.errors import FFGymError
from scripts.tune_gains import Config


def published(name=SERVO_GAINS):
    manifest = read_manifest(name)
    (artefact,) = manifest.artefacts
    return load_policy(locate_artefact(name, artefact))


def test_gains_are_a_clipped_sum_of_errors_and_the_last_residual():
    actor = make_gains([0.5, 0.2, 0.4], n_motors=2).actor
    per_motor = actor.n_features // 2
    features = np.random.default_rng(0).uniform(-1, 1, size=(3, 2, per_motor))
    features[0, 0, 0] = 9.0
    residual, _ = actor.act(features.reshape(3, -1), actor.initial_state((3,)))
    wanted = np.clip(features[..., 0] * 0.5 + features[..., 1] * 0.2 + features[..., 2] * 0.4, -1, 1)
    np.testing.assert_allclose(residual, wanted, rtol=1e-6)  # weights are kept in single precision
    assert residual[0, 0] == 1.0


def test_gains_that_grow_or_are_not_three_are_refused():
    with pytest.raises(FFGymError, match=r"gains\[2\] = 1 .* the filter grows"):
        make_gains([0.5, 0.2, 1.0], n_motors=6)
    with pytest.raises(FFGymError, match="gains has shape"):
        make_gains([0.5, 0.2], n_motors=6)


def test_the_published_gains_take_half_of_the_error_of_their_base_on_other_robots_than_they_were_tuned_on():
    policy = published()
    found = validate(policy, plants=1, seed=7)  # the search had a seed of its own
    assert found.log_ratio < np.log(0.6)
    tried = policy.meta["search"]
    assert min(value for _, value in tried) == policy.meta["log_ratio"]
    gains = policy.actor.layers[0].weight[0]
    assert not gains[3:].any()
    np.testing.assert_allclose(gains[:3], min(tried, key=lambda each: each[1])[0], rtol=1e-6)


def test_the_command_of_gains_asks_for_the_same_search():
    config = Config(name=SERVO_GAINS_DRIVES, robot="irb4600_60_205_arm_drives", effects=True, evaluations=9)
    assert tyro.cli(Config, args=shlex.split(config.command)[3:]) == config
    assert read_manifest(SERVO_GAINS_DRIVES).command == replace(config, evaluations=60).command
    margins = {"gain_margin": 2.0, "delay_margin": 1, "start": (0.0, 0.1, 0.5), "step": 0.3}
    stable = replace(config, name=SERVO_GAINS_STABLE, evaluations=12, **margins)
    assert tyro.cli(Config, args=shlex.split(stable.command)[3:]) == stable
    assert read_manifest(SERVO_GAINS_STABLE).command == stable.command


@pytest.mark.slow
def test_gains_for_drives_are_better_on_machines_than_those_for_ideal_drives():
    machines = {"robot": "irb4600_60_205_arm_drives", "plants": 1, "seed": 7, "effects": True}
    ideal, drives = (validate(published(name), **machines).log_ratio for name in (SERVO_GAINS, SERVO_GAINS_DRIVES))
    assert drives < ideal < 0
