from dataclasses import replace

import numpy as np
import pytest

from ffgym.agents.amortised.estimator import Estimator
from ffgym.agents.artefacts import read_manifest
from ffgym.core.errors import FFGymError
from ffgym.leaderboard.adaptation.protocol import scored_motions
from ffgym.leaderboard.adaptation.results import read_results
from ffgym.robot import RigidArm, load_robot
from ffgym.simulation.plant import Machine
from scripts import adaptation, adaptation_bounds


def test_the_curve_is_run_once_and_goes_on_where_it_was_stopped(tmp_path, monkeypatch, capsys):
    def first_only(arm):
        return scored_motions(arm)[:1]

    monkeypatch.setattr("ffgym.leaderboard.adaptation.evaluation.scored_motions", first_only)
    monkeypatch.setattr(adaptation, "scored_motions", first_only)
    config = adaptation.Config(
        machines=(adaptation.NOMINAL, "workcell:drives-1"),
        adapters=("none", "elastic"),
        threads=1,
        out=tmp_path / "curve.json",
        picture=tmp_path / "curve.png",
    )
    adaptation.main(config)
    printed = capsys.readouterr().out
    assert "| elastic feed-forward | 0.0 s |" in printed
    assert "Nominal robot" in printed
    results = read_results(config.out)
    assert {run.machine for run in results.runs} == set(config.machines)
    assert (tmp_path / "curve.png").read_bytes()[:4] == b"\x89PNG"
    monkeypatch.setattr(adaptation, "evaluate", lambda entries, threads: iter([[]] if not entries else 1 / 0))
    adaptation.main(config)
    assert read_results(config.out) == results
    with pytest.raises(FFGymError, match="Unknown adapter 'unknown'"):
        adaptation.main(replace(config, adapters=("unknown",)))


def test_an_estimator_is_trained_and_laps_are_simulated_once(tmp_path, monkeypatch):
    pytest.importorskip("torch")
    from scripts import train_estimator

    monkeypatch.setattr(train_estimator, "SPEEDS", (0.1,))  # the teacher on one short motion
    config = train_estimator.Config(
        draws=12,
        chunk=12,
        variants=("motors", "recurrent"),
        seeds=(3,),
        hidden=(4,),
        cells=4,
        epochs=1,
        threads=1,
        work=tmp_path / "work",
        out=tmp_path / "out",
    )
    train_estimator.main(config)
    manifest = read_manifest("amortised_motors", tmp_path / "out")
    assert manifest.seeds == (3,)
    file = tmp_path / "out" / "amortised_motors" / manifest.artefacts[0].file
    first = Estimator.load(file)
    assert first.linear.weight.shape[0] == 79
    assert manifest.artefacts[0].robot_seconds == 0.0
    recurrent = tmp_path / "out" / "amortised_recurrent" / manifest.artefacts[0].file
    assert Estimator.load(recurrent).lstm.cells == 4
    monkeypatch.setattr(train_estimator, "simulate", None)  # laps are there
    train_estimator.main(replace(config, variants=("motors",)))
    again = Estimator.load(file)
    np.testing.assert_array_equal(again.linear.weight, first.linear.weight)


def draw_laps(rng, count):
    """Signals of three rows, of which the linear part sees one, and numbers: a sum with the last row, and this row."""
    signals = 4.0 * rng.standard_normal((count, 3, 2))
    signals[:, 0, 0] *= 6.0
    last = signals[:, 2]
    return signals, np.stack([last[:, 1] + signals[:, 0, 0] / 6.0, last[:, 1], last[:, 0]], axis=1) / 4.0


def train_recurrent(monkeypatch, metric, cells):
    """Shares of the variance that a recurrent estimator and its linear part leave on other laps, by number."""
    from scripts import train_estimator

    rng = np.random.default_rng(0)
    monkeypatch.setattr(train_estimator, "_explained", lambda *_: {})
    config = train_estimator.Config(noise=0.1, cells=cells, components=1)
    estimator, _ = train_estimator.train(config, *draw_laps(rng, 640), "recurrent", 0, np.diag(metric))
    signals, numbers = draw_laps(rng, 200)
    seen = np.pad(signals, ((0, 0), (0, 0), (0, 3)))  # the tool, which it does not see
    found = [estimator.estimate(each).mean for each in seen], [estimator.linear(estimator.features(e)) for e in seen]
    return [np.var(each - numbers, axis=0) / np.var(numbers, axis=0) for each in found]


def test_a_recurrent_estimator_reads_what_the_linear_part_does_not_see(monkeypatch):
    pytest.importorskip("torch")
    left, linear = train_recurrent(monkeypatch, [1.0, 0.0, 0.0], cells=16)
    assert left[0] < 0.1 < 0.3 < linear[0]


def test_a_recurrent_estimator_learns_the_numbers_that_move_the_tool(monkeypatch):
    pytest.importorskip("torch")
    (second, _), (third, _) = (train_recurrent(monkeypatch, metric, cells=4) for metric in ([0, 1, 0], [0, 0, 1]))
    assert second[1] < 0.8 * third[1]
    assert third[2] < second[2]


def test_the_teacher_weighs_numbers_by_how_far_they_move_the_tool(monkeypatch):
    pytest.importorskip("torch")
    from scripts import train_estimator

    monkeypatch.setattr(train_estimator, "SPEEDS", (0.1,))
    arm = RigidArm(load_robot("irb4600_60_205_commissioned_arm_drives"))
    spread = np.zeros(79)
    spread[:6] = 0.3  # Coulomb friction of each motor
    spread[78] = 5.0  # payload [kg]
    metric = train_estimator.teacher_metric(arm, spread)
    np.testing.assert_allclose(metric, metric.T, atol=1e-15)
    assert np.trace(metric) == pytest.approx(1.0)
    assert np.linalg.eigvalsh(metric).min() > -1e-12
    weights = np.diag(metric)
    assert np.all(weights[6:78] == 0.0)
    assert weights[:6].sum() > weights[78] > 0.0


def test_with_all_true_numbers_of_a_drawn_robot_little_error_is_left(monkeypatch):
    monkeypatch.setattr(adaptation_bounds, "scored_motions", lambda arm: scored_motions(arm)[:1])
    arm = RigidArm(load_robot("irb4600_60_205_commissioned_arm_drives"))
    (robot,) = adaptation_bounds.draw_robots(arm, (1,))
    left = adaptation_bounds.errors_left(arm, [Machine(robot=robot)], adaptation_bounds.Config(threads=1))
    assert left["all true numbers"].max() < 0.04 < 0.1 < left["nominal numbers"].min()
    table = adaptation_bounds.format_bounds("drawn", left)
    assert f"| all true numbers | {left['all true numbers'].item():.1%} |" in table
