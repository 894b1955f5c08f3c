"""Friction that changes from day to day is told, and nothing is where it does not."""

from datetime import date, timedelta

import numpy as np
import pytest

from ffgym.diagnosis.drift import find_drifts, read_days
from ffgym.diagnosis.log import assemble_log
from ffgym.diagnosis.replay import predict, replay
from ffgym.diagnosis.resampling import cut_blocks
from ffgym.diagnosis.residual_rows import compute_residuals, find_valid_rows
from ffgym.effects import EFFECTS
from ffgym.paths import joint_reference, multisine
from ffgym.robot import load_robot
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Machine

DAYS = (0, 10, 20, 30, 40, 50)


def sessions(change, effect="viscous_level"):
    """A one-axis machine on six days, with motions of their own; `change` is of the last day."""
    robot, rng = load_robot("one_axis"), np.random.default_rng(5)
    found = []
    for day in DAYS:
        low, high = robot.kinematics.range[0]
        centre = np.array([0.5 * (low + high)])
        sines = multisine(centre, rng.uniform(0.1, 0.3, (2, 1)), [0.3, 0.8], rng.uniform(0, 6, (2, 1)), 14.0, ramp=1.0)
        hidden = EFFECTS[effect].on(robot, change=change * day / DAYS[-1])
        machine = Machine(robot=robot, effects=(hidden,))
        recording = simulate([Run(reference=joint_reference(robot, sines))], machine=machine, n_threads=1)[0]
        noise = rng.normal(scale=0.02, size=len(recording))
        noisy = recording.with_columns({"motor.effort.j1": recording["motor.effort.j1"] + noise})
        found.append(noisy.rename(f"run-{date(2024, 1, 5) + timedelta(days=day)}"))
    return robot, found


def told(robot, recordings):
    log = assemble_log(robot, recordings)
    run = replay(log, Machine(robot=robot))
    rest = compute_residuals(log, predict(run))
    return find_drifts(log, run, rest, cut_blocks(find_valid_rows(log), log.sampling.row_dt))


@pytest.mark.parametrize("effect", ["viscous_level", "coulomb_level"])
def test_friction_that_falls_over_the_days_is_told_with_its_rate_and_its_kind(effect):
    (drift,) = told(*sessions(-0.2, effect))
    assert (drift.effect, drift.joint) == (effect, "j1")
    assert drift.per_day * DAYS[-1] == pytest.approx(-0.2, abs=0.04)
    assert "falls over 50 days" in drift.message


def test_one_odd_day_is_no_change_with_the_days():
    robot, recordings = sessions(0.0)
    _, odd = sessions(0.4)
    assert told(robot, [*recordings[:-1], odd[-1]]) == ()


def test_friction_that_stays_is_not_told():
    assert told(*sessions(0.0)) == ()


def test_without_dates_nothing_changes_with_the_days():
    robot, recordings = sessions(-0.2)
    assert told(robot, [recording.rename(f"motion {i}") for i, recording in enumerate(recordings)]) == ()


def test_days_are_read_from_names_of_several_styles():
    _, recordings = sessions(0.0)
    names = ("ur-20_02_05-20sec", "2020-02-07 b", "x20200210", "20.02.06.csv", "run 20_02_05", "20_03_05")
    named = [recording.rename(name) for recording, name in zip(recordings, names, strict=True)]
    assert read_days(named).tolist() == [0, 2, 5, 1, 0, 29]
