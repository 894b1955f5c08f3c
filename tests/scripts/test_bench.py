"""The benchmark measures simulation and environments against the bare engine, in turns."""

import json
from dataclasses import replace

import gymnasium as gym
import numpy as np
import pytest

from ffgym.agents.catalogue import CATALOGUE
from ffgym.core.errors import FFGymError
from ffgym.robot import RigidArm
from ffgym.simulation import Run
from ffgym.studies import circle_references, thesis_laws
from scripts.bench import Config, main
from scripts.bench.cases import (
    CIRCLES,
    Bare,
    Stepped,
    bare_rate,
    cell_ratios,
    decision_ratios,
    effect_ratios,
    measure,
    python_of_a_step,
    training_ratios,
)
from scripts.bench.history import Entry, append, losses, read_history
from scripts.bench.processes import collection_ratio, command_ratios, import_time, memory_of
from scripts.bench.turns import Amount, Ratio, take_turns
from scripts.tables.speed import speed


def test_a_measurement_of_a_few_runs_has_three_rates(irb4600):
    arm = RigidArm(irb4600)
    reference = circle_references(arm, ["p1"], [0.1], [0.001])["p1", 0.1]
    runs = [Run(reference=reference, law=law) for law in thesis_laws(irb4600)]
    bare, stepping, whole = measure(arm, runs, threads=1)
    assert 0 < whole <= stepping
    assert 0 < bare < 1e9


def test_the_bare_engine_runs_simulations_of_different_lengths(one_axis):
    assert bare_rate(one_axis, np.array([10, 30, 20, 30]), threads=1) > 0


def test_turns_alternate_and_warm_up_once():
    calls = []

    def rate(name, value):
        return lambda: calls.append(name) or value

    ratio = take_turns("a / b", rate("a", 6.0), rate("b", 3.0), 2, unit="steps/s", wanted=1.5)
    assert "".join(calls) == "ababab"
    assert ratio.quartiles() == (2.0, 2.0, 2.0)
    assert "2.00 (2.00 to 2.00)   wanted 1.5 or more" in str(ratio)
    assert not ratio.is_wide


def test_a_wide_spread_is_said():
    ratio = Ratio("a / b", (1.0, 2.0, 3.0), (1.0, 1.0, 1.0), "steps/s")
    assert ratio.is_wide
    assert "WIDE" in str(ratio)


def test_the_bare_engine_moves_robots_on_from_where_the_environment_has_them():
    stepped = Stepped(CIRCLES, 2, n_threads=1)
    bare = Bare(stepped.env)
    assert stepped.rate() > 0
    assert bare.rate() > 0
    state, own = bare._engine.qvel, stepped.env.unwrapped.core.plant.batch.qvel
    assert np.isfinite(state).all()
    assert np.abs(own).max() > 1e-6  # random torques move them
    assert np.abs(state).max() > 0


def test_effects_cost_something_but_not_everything():
    ratios = effect_ratios("irb4600_60_205", 1, threads=1)
    assert [ratio.title.split(" / ")[0] for ratio in ratios][-1] == "36 machines with 8 effects"
    assert all(0 < ratio.quartiles()[1] < 1.2 for ratio in ratios)


@pytest.mark.slow
def test_workcells_and_real_drives_are_measured_against_the_nominal_robot_and_against_time():
    ratios = list(cell_ratios(1, threads=1))
    assert [ratio.wanted for ratio in ratios] == [*[0.6] * 3, *[None] * 3, 0.6, None, 10.0]
    assert "one / real time" in ratios[-1].title
    assert all(0.1 < ratio.quartiles()[1] < 100 for ratio in ratios)


def test_the_engine_is_left_out_of_the_python_of_a_step():
    whole = 64e6 / Stepped(CIRCLES, 64, n_threads=1).rate()  # most of it is the engine
    assert 10 < python_of_a_step(64, steps=20, threads=1).value < 0.5 * whole


def test_the_bare_engine_steps_as_often_as_the_environment():
    env = gym.make_vec(CIRCLES, num_envs=2)
    env.reset(seed=0)
    bare = Bare(env)
    bare.rate()
    plant = env.unwrapped.core.plant
    np.testing.assert_allclose(bare._engine.time, bare._steps * plant.n_substeps * plant.physics_dt)


def test_memory_and_import_are_measured_in_fresh_processes():
    assert 0 < memory_of("ffgym/OneAxis-v0", 2).value < 200
    assert 0 < import_time(1).value < 10


@pytest.mark.slow  # imports torch
def test_the_training_rate_is_measured_where_the_learner_is_installed():
    pytest.importorskip("stable_baselines3")
    (ratio,) = training_ratios(1)
    assert ratio.rates[0] > 0


def test_training_is_left_out_where_the_learner_is_missing(monkeypatch, capsys):
    monkeypatch.setattr("scripts.bench.cases.is_installed", lambda package: False)
    assert main(Config(parts=("training",))) == []
    assert "training: left out" in capsys.readouterr().out


@pytest.mark.slow  # trains every family
def test_every_agent_that_one_axis_has_a_use_for_is_timed():
    titles = [ratio.title for ratio in decision_ratios((1,), 1)]
    wanted = [name for name, entry in CATALOGUE.items() if name != "none" and not entry.needs_arm]
    assert titles == [f"{name} / environment, 1 robot" for name in wanted]


@pytest.mark.slow
def test_the_benchmark_prints_all_and_writes_it(tmp_path, capsys):
    parts = ("simulation", "environments", "memory")
    results = main(Config(repeats=1, long_repeats=1, parts=parts, json=tmp_path / "bench.json"))
    out = capsys.readouterr().out
    assert f"{CIRCLES}, 64 / bare engine" in out
    assert "wanted 300 or less" in out
    written = json.loads((tmp_path / "bench.json").read_text())
    assert [result["title"] for result in written["results"]] == [result.title for result in results]
    assert written["versions"]["mujoco"]
    assert len(written["physics_fingerprint"]["irb4600_60_205"]) == 16
    assert written["machine"]["cores"] >= 1


def entry(processor="a", commit="c1", **ratios):
    spread = {title: value if isinstance(value, tuple) else (value, value, value) for title, value in ratios.items()}
    return Entry(ratios=spread, amounts={}, processor=processor, commit=commit)


def test_a_ratio_that_lost_more_than_a_tenth_of_recent_runs_is_told():
    history = [
        entry(x=9.0, commit="old"),
        *(entry(x=value, commit=f"c{value}") for value in (1.0, 1.02, 0.98, 1.0, 5.0)),
    ]
    assert losses(entry(x=0.91), history) == []
    (change,) = losses(entry(x=0.89, y=0.1), history)
    assert (change.title, change.before, change.sure) == ("x", 1.0, True)
    assert str(change) == "LOST 11%: x: 0.89, was 1 in 5 runs since c1.0"


def test_a_busy_machine_makes_a_loss_doubtful():
    for now in ((0.7, 0.8, 0.95), (0.6, 0.8, 0.85)):  # reaches what was, or is wide
        (change,) = losses(entry(x=now), [entry(x=1.0)])
        assert not change.sure
        assert str(change).startswith("lost 20%, measure again: x")


def test_runs_on_the_same_processor_are_compared_before_those_on_others():
    history = [entry("mine", x=0.5), *[entry("other", x=1.0)] * 3]
    assert losses(entry("mine", x=0.5), history) == []
    (change,) = losses(entry("third", x=0.5), history)
    assert change.elsewhere
    assert "on other processors" in str(change)


def test_a_run_is_added_to_its_history_and_a_loss_ends_in_an_error(tmp_path, monkeypatch, capsys):
    speed = [4.0]
    cases = {"training": [lambda: [Ratio("a / b", (speed[0],) * 3, (2.0,) * 3, "1/s"), Amount("size", 3.0, "MiB")]]}
    monkeypatch.setattr("scripts.bench.parts", lambda *arguments: cases)
    config = Config(parts=("training",), history=tmp_path / "history.jsonl")
    main(config)
    speed[0] = 3.0
    with pytest.raises(FFGymError, match=r"lost more than 10 %"):
        main(config)
    assert "LOST 25%: a / b: 1.5, was 2 in 1 run since" in capsys.readouterr().out
    first, second = read_history(config.history)
    assert (first.ratios["a / b"], second.ratios["a / b"]) == ([2.0] * 3, [1.5] * 3)
    assert first.amounts == {"size": [3.0, "MiB"]}


def test_a_file_that_is_no_history_is_refused(tmp_path):
    (tmp_path / "history.jsonl").write_text('{"ratios": 3}\n')
    with pytest.raises(FFGymError, match=r"is no history of the benchmark"):
        main(Config(parts=(), history=tmp_path / "history.jsonl"))


@pytest.mark.slow
def test_what_a_user_waits_for_is_measured():
    ratios = [*command_ratios(1), *collection_ratio(1)]
    assert all(0 < ratio.quartiles()[1] < 10 for ratio in ratios)


def test_the_page_tells_the_last_run_and_says_where_there_is_none(tmp_path):
    history = tmp_path / "history.jsonl"
    assert speed(history).parts["last run"].startswith("Not measured yet")
    append(history, entry(commit="old", x=9.0))
    append(history, replace(entry(commit="new", x=0.87654, y=(0.7, 0.8, 0.9)), amounts={"memory": (82.34, "MiB")}))
    told = speed(history).parts["last run"]
    assert "at commit new on a" in told
    assert "| x | 0.877 (0.877 to 0.877) |  |" in told
    assert "| y | 0.8 (0.7 to 0.9) | WIDE |" in told
    assert "| memory | 82.3 MiB |" in told
    assert "9.0" not in told
