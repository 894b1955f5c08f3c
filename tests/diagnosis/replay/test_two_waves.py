"""Two waves of a gear error are one error of that shape: in a simulation as in a replay."""

import numpy as np
import pytest

from ffgym.diagnosis.log import assemble_log
from ffgym.diagnosis.replay import predict, replay
from ffgym.diagnosis.settings import settings
from ffgym.effects import EFFECTS
from scripts.exam.equations import VARIANTS
from tests.diagnosis.replay.replay_samples import nominal, recorded, with_effect

AMPLITUDE, PHASE = 2e-4, 0.6
SECOND, SHIFT = 0.4, 1.0
"""Height of the second wave of the exam's equation, and its phase beyond twice that of the first."""


def wave(amplitude, cycles, phase):
    return EFFECTS["kinematic_error"].on(nominal().robot, amplitude=amplitude, cycles=cycles, phase=phase)


@pytest.fixture(scope="module")
def one():
    error = VARIANTS["two_wave_gear_error"].on(nominal().robot, amplitude=AMPLITUDE, cycles=1.0, phase=PHASE)
    return with_effect(error)


@pytest.fixture(scope="module")
def two():
    return with_effect(wave(AMPLITUDE, 1.0, PHASE), wave(SECOND * AMPLITUDE, 2.0, 2 * PHASE + SHIFT))


@pytest.fixture(scope="module")
def recordings(one, two):
    return recorded({"nominal": nominal(), "one": one, "two": two})


@pytest.fixture(scope="module")
def log():
    """With a step of the springs in each sample: between samples, one replay has torques and the other one angles."""
    return assemble_log(
        nominal().robot, [recorded({"nominal": nominal()}, sample_dt=settings().replay.spring_step)["nominal"]]
    )


def test_a_simulation_of_both_is_that_of_the_error(recordings):
    motions = {name: recordings[name].joint_array("motor.effort") for name in ("nominal", "one", "two")}
    changed = np.abs(motions["one"] - motions["nominal"]).max(axis=0)
    assert np.all(np.abs(motions["one"] - motions["two"]).max(axis=0) < 1e-6 * changed)


def test_a_replay_of_both_is_that_of_the_error(log, one, two):
    here, there, without = (predict(replay(log, machine))["torque"] for machine in (one, two, nominal()))
    assert np.abs(here - there).max() < 1e-9 * np.abs(here - without).max()
