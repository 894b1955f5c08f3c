"""Motors that creep after a stop, read with noise and in steps: what replays of such logs share is no fault."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.diagnosis.log import assemble_log
from ffgym.diagnosis.noise import find_encoder_steps, simulate_null_residuals
from ffgym.diagnosis.nuisance import ParameterPrior
from ffgym.diagnosis.prepare import prepare
from ffgym.diagnosis.replay import replay
from ffgym.diagnosis.residual_rows import find_valid_rows
from ffgym.diagnosis.weights import estimate_misread_friction
from ffgym.simulation.plant import Machine
from ffgym.simulation.protocols import load_protocols
from scripts.exam.bench import Bench

BLOCK = 60
"""Rows of a mean [8 ms each]: torque noise of one row is an eighth of itself there."""


@pytest.fixture(scope="module")
def log(arm):
    machine = Machine(robot=arm.robot)
    return assemble_log(
        arm.robot, Bench(arm=arm, protocols=tuple(load_protocols("dwell_restart"))).record(machine, seed=3)
    )


@pytest.fixture(scope="module")
def nominal(log):
    return prepare(log, Machine(robot=log.robot), ParameterPrior(), np.random.default_rng(0))


def worst_means(log, draws):
    """Largest mean over a block, mean of all draws, in RMS of noise, each joint."""
    rows = np.where(find_valid_rows(log)[..., None, None], draws["torque"], 0.0)[:, 0]
    rms = np.sqrt(np.mean(rows**2, axis=(0, 2)))
    blocks = rows[: len(rows) // BLOCK * BLOCK].reshape(-1, BLOCK, *rows.shape[1:])
    return np.abs(blocks.mean(axis=(1, 3))).max(axis=0) / rms


@pytest.mark.slow
def test_what_noise_does_to_standing_friction_on_average_is_taken_off(log, nominal):
    run, like, exact = nominal.run, nominal.problem.like, nominal.run.log.recordings
    rng = np.random.default_rng(5)
    with_it = simulate_null_residuals(log, run, nominal.problem.bias, like, rng).draws
    loosened = estimate_misread_friction(exact, run.log, run, find_encoder_steps(log))
    bias = {**nominal.problem.bias, "torque": nominal.problem.bias["torque"] + loosened}
    without = simulate_null_residuals(log, run, bias, like, np.random.default_rng(5)).draws
    assert worst_means(log, without).min() > 1.0
    assert np.median(worst_means(log, with_it)) < 0.4 * np.median(worst_means(log, without))


def test_an_exact_reading_loosens_nothing(log, nominal):
    exact = nominal.run.log
    silent = replace(exact, trembling=np.zeros_like(exact.trembling))
    silent = assemble_log(log.robot, exact.recordings, like=silent)
    run = replay(silent, Machine(robot=log.robot))
    assert np.abs(estimate_misread_friction(exact.recordings, silent, run, np.zeros((1, 6)))).max() == 0.0
