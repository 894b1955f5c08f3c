"""Models that are fitted on the machine: what one lap tells of it is worth something on other motions."""

from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.agents import fitted
from ffgym.agents.adapters import ADAPTERS
from ffgym.agents.model import model_law
from ffgym.core.errors import FFGymError
from ffgym.leaderboard.adaptation.protocol import lap, practice_motion
from ffgym.robot import RigidArm, load_robot
from ffgym.simulation import Machine, load_protocols, plan_session

ADAPTER = next(adapter for adapter in ADAPTERS if adapter.name == fitted.NAME)


@pytest.fixture(scope="module")
def arm():
    return RigidArm(load_robot("irb4600_60_205_arm_drives"))


@pytest.fixture
def recorded(monkeypatch):
    """Names of the recordings of a fit that leaves the model as it is."""
    names = []

    def tune(machine, recordings):
        names.extend(recordings)
        return machine

    monkeypatch.setattr(fitted, "tune", tune)
    return names


def run_nothing(runs, number):
    """Stand for a machine: recordings that become their name."""
    return [
        SimpleNamespace(header=SimpleNamespace(segment=run.reference.name), rename=lambda name: name) for run in runs
    ]


def test_recordings_of_repeated_laps_have_names_of_their_own(arm, recorded):
    law, trial = ADAPTER.practise(arm, run_nothing, laps=3)
    assert len(set(recorded)) == 3
    assert all(name.startswith(lap(arm).name) for name in recorded)
    assert trial.left == pytest.approx(0.0)
    kept = model_law(Machine.of(arm.robot), arm)
    np.testing.assert_array_equal(law.torque(lap(arm)), kept.torque(lap(arm)))


def test_circles_of_three_speeds_follow_one_and_then_the_motions_of_a_diagnosis(arm, recorded):
    ADAPTER.practise(arm, run_nothing, laps=10)
    speeds = [practice_motion(arm, 0.003, speed).name for speed in (0.01, 0.04, 0.1)]
    assert recorded == [f"{name}, trial {number}" for number in range(2) for name in speeds]
    recorded.clear()
    _, trial = ADAPTER.practise(arm, run_nothing, laps=ADAPTER.laps[-1])
    motions = plan_session(arm, load_protocols("diagnosis"))
    assert recorded == [f"{each.reference.name}, trial 0" for each in motions]
    assert trial.budget - lap(arm).duration < trial.robot_seconds <= trial.budget


def test_without_a_trial_there_is_nothing_to_fit(arm):
    with pytest.raises(FFGymError, match="trials = 0"):
        fitted.fit_model(arm, [lap(arm)], run_nothing, trials=0)
