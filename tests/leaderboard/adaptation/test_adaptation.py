from dataclasses import replace

import numpy as np
import pytest

from ffgym.control import NoCompensation
from ffgym.core.errors import FFGymError
from ffgym.leaderboard.adaptation import evaluation
from ffgym.leaderboard.adaptation.curve import curve
from ffgym.leaderboard.adaptation.evaluation import Subject, evaluate, list_entries
from ffgym.leaderboard.adaptation.protocol import Adapter, BudgetedTrial, lap, practice_set, scored_motions
from ffgym.leaderboard.adaptation.results import AdaptationResults, AdaptationRun, read_results, write_results
from ffgym.robot import RigidArm, load_robot
from ffgym.simulation import Run, SimulatedRig
from ffgym.simulation.plant import PlantDistribution


@pytest.fixture(scope="module")
def arm():
    return RigidArm(load_robot("irb4600_60_205"))


def trial_of(arm, laps, seen):
    def run(runs, number):
        seen.extend(run.reference.name for run in runs)
        return [None] * len(runs)

    return BudgetedTrial(trial=run, budget=laps * lap(arm).duration, scored=scored_motions(arm))


def test_every_second_of_motion_counts_and_the_budget_is_never_exceeded(arm):
    seen, one = [], Run(reference=lap(arm), law=NoCompensation())
    trial = trial_of(arm, 3, seen)
    trial([one, one], 0)
    assert trial.robot_seconds == 2 * lap(arm).duration
    with pytest.raises(FFGymError, match=r"1\.672 s of the budget of 5\.016 s are left"):
        trial([one, one], 1)
    assert trial.robot_seconds == 2 * lap(arm).duration
    trial([one], 2)
    assert trial.left == pytest.approx(0.0)
    assert len(seen) == 3


def test_scored_motions_cannot_be_practised_and_others_at_the_position_of_practice_can(arm):
    trial = trial_of(arm, 30, [])
    for motion in scored_motions(arm):
        copy = replace(motion, name="of another name")
        with pytest.raises(FFGymError, match="'of another name' is scored"):
            trial([Run(reference=copy, law=NoCompensation())], 0)
    assert trial.robot_seconds == 0
    trial([Run(reference=motion, law=NoCompensation()) for motion in practice_set(arm)], 0)


def test_the_scored_square_begins_at_a_sharp_corner_and_its_others_are_rounded_from_half_of_half_a_side(arm):
    away = arm.tcp_position(scored_motions(arm)[-1].q)[:, :2] - arm.robot.work_area.positions["p4"][:2]
    np.testing.assert_allclose(away[[0, -1]], -0.004, atol=1e-7)
    assert np.abs(away).max() < 0.004 + 1e-7
    on_side = np.abs(away).max(axis=1) > 0.004 - 1e-7
    before = np.abs(away[(away[:, 1] < 0) & (away[:, 0] > 0) & on_side]).min(axis=1).max()
    assert before == pytest.approx(0.002, rel=0.05)


def test_adapters_of_all_machines_run_side_by_side_as_each_would_alone(arm, monkeypatch):
    monkeypatch.setattr(evaluation, "scored_motions", lambda arm: scored_motions(arm)[:1])

    seeds = []

    def practise(setting):
        seeds.append(setting.seed)
        for number in range(2):
            setting.trial([Run(reference=lap(arm), law=NoCompensation())], number)
        return NoCompensation()

    adapters = [
        Adapter(name="none", title="", about="", adapt=lambda setting: NoCompensation()),
        Adapter(name="practises", title="", about="", adapt=practise, laps=(2,), seeds=(0, 7)),
    ]
    drawn = PlantDistribution().draw(arm.robot, np.random.default_rng(1))
    subjects = [
        Subject(name="nominal", rig=SimulatedRig(arm=arm)),
        Subject(name="drawn", rig=SimulatedRig(arm=arm, machine=drawn)),
    ]
    runs = {run.key: run for group in evaluate(list_entries(adapters, subjects), 1) for run in group}
    assert runs["practises", "drawn", 2, 0].robot_seconds == runs["practises", "drawn", 2, 0].budget_s == 3.344
    assert sorted(seeds) == [0, 0, 7, 7]
    assert runs["none", "drawn", 0, 0].robot_seconds == 0
    alone = {run.key: run for group in evaluate(list_entries(adapters[:1], subjects[1:]), 1) for run in group}
    assert alone["none", "drawn", 0, 0] == runs["none", "drawn", 0, 0]
    assert runs["none", "drawn", 0, 0].rms_um != runs["none", "nominal", 0, 0].rms_um
    assert runs["practises", "drawn", 2, 0].rms_um == runs["none", "drawn", 0, 0].rms_um


def run_of(adapter, machine, rms, laps=0, seed=0):
    return AdaptationRun(
        adapter=adapter,
        machine=machine,
        laps=laps,
        budget_s=laps * 1.672,
        robot_seconds=0.0,
        seed=seed,
        fingerprint="f",
        versions="v",
        artefact=None,
        rms_um=rms,
    )


def test_the_curve_is_the_geometric_mean_of_shares_of_the_error_without_compensation():
    runs = [run_of("none", "a", (100.0, 10.0)), run_of("none", "b", (50.0, 20.0))]
    runs += [run_of("law", "a", (10.0, 4.0), 1), run_of("law", "b", (5.0, 2.0), 1)]
    (point,) = curve(runs, "law", ["a", "b"])
    assert point.left == pytest.approx((0.1 * 0.4 * 0.1 * 0.1) ** 0.25)
    np.testing.assert_allclose(point.by_machine, [0.2, 0.1])
    assert point.worst == pytest.approx(0.4)
    assert point.spread.low <= point.left <= point.spread.high
    assert point.budget_s == 1.672
    with pytest.raises(FFGymError, match="'b' has no result without compensation"):
        curve([run for run in runs if run.adapter != "none" or run.machine == "a"], "law", ["a", "b"])


def test_results_come_back_from_a_file_and_damaged_files_are_refused(tmp_path):
    results = AdaptationResults(motions=("m",), lap="lap", runs=(run_of("law", "a", (1.0, None)),))
    write_results(tmp_path / "r.json", results)
    assert read_results(tmp_path / "r.json") == results
    (tmp_path / "cut.json").write_text((tmp_path / "r.json").read_text()[:-20])
    with pytest.raises(FFGymError, match="is not valid JSON"):
        read_results(tmp_path / "cut.json")
    (tmp_path / "old.json").write_text('{"format": 0}')
    with pytest.raises(FFGymError, match="has format 0"):
        read_results(tmp_path / "old.json")
