"""Plans of trials: pairs in random order, from one seed, in files that cannot be changed unnoticed."""

import csv
import json
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ffgym.core.errors import FFGymError
from ffgym.deployment.trial import plan_trial, read_trial_plan, write_trial_plan
from ffgym.recordings import write_recording
from tests.deployment.trial.trial_samples import make_plan, make_program

ONE, TWO, THREE = (make_program(name, speed=speed) for name, speed in (("a", 1.0), ("b", 2.0), ("c at 3", 3.0)))


@given(st.integers(1, 12), st.integers(1, 3), st.integers(0, 2**40), st.integers(0, 4))
def test_each_round_has_one_pair_of_each_program_whose_runs_follow_each_other(pairs, count, seed, warm_up):
    plan = make_plan(*(ONE, TWO, THREE)[:count], pairs=pairs, seed=seed, warm_up=warm_up)
    assert [run.number for run in plan.runs] == list(range(1, warm_up + 2 * pairs * count + 1))
    assert not any(run.corrected for run in plan.runs[:warm_up])
    scored = plan.runs[warm_up:]
    for first, second in zip(scored[::2], scored[1::2], strict=True):
        assert (first.program, first.pair) == (second.program, second.pair)
        assert first.corrected != second.corrected
    for k in range(pairs):
        own = scored[2 * k * count : 2 * (k + 1) * count]
        assert {run.pair for run in own} == {k + 1}
        assert set(Counter(run.program for run in own).values()) == {2}


def test_the_order_within_pairs_is_even_chance_and_follows_from_the_seed():
    plan = make_plan(pairs=400, warm_up=0)
    first = [run.corrected for run in plan.runs[::2]]
    assert abs(np.mean(first) - 0.5) < 0.08
    assert make_plan(pairs=400, warm_up=0).runs == plan.runs
    assert make_plan(pairs=400, warm_up=0, seed=2).runs != plan.runs


def test_logs_have_names_that_sort_in_the_order_of_the_runs_and_hold_nothing_strange():
    plan = make_plan(ONE, THREE, pairs=5)
    names = [run.log for run in plan.runs]
    assert sorted(names) == names
    assert names[0] == "01_a_warm_up"
    assert {name.split("_", 1)[1] for name in names[1:]} == {"a_on", "a_off", "c_at_3_on", "c_at_3_off"}


def test_a_plan_comes_back_from_its_folder(tmp_path: Path):
    plan = make_plan(ONE, TWO, pairs=3, warm_up=2, laps=2, seed=9)
    write_trial_plan(plan, tmp_path / "trial", "<p>page</p>", {"why": "test"})
    back = read_trial_plan(tmp_path / "trial")
    assert (back.runs, back.digest, back.robot, back.laps) == (plan.runs, plan.digest, "two_joints", 2)
    rows = list(csv.DictReader((tmp_path / "trial" / "plan.csv").read_text().splitlines()))
    assert [(row["log"], row["correction"] == "on") for row in rows] == [(run.log, run.corrected) for run in plan.runs]
    assert json.loads((tmp_path / "trial" / "plan.json").read_text())["origin"] == {"why": "test"}


@pytest.mark.parametrize("change", ["order", "seed", "program", "set-points"])
def test_a_plan_that_was_changed_after_it_was_drawn_is_refused(change, tmp_path: Path):
    plan = make_plan(ONE, TWO, pairs=3)
    write_trial_plan(plan, tmp_path / "trial", "", {})
    file = tmp_path / "trial" / "plan.json"
    values = json.loads(file.read_text())
    if change == "order":
        values["runs"][-1]["corrected"] = not values["runs"][-1]["corrected"]
    elif change == "seed":
        values["seed"] += 1
    elif change == "set-points":
        other = make_program(TWO.name, middle=0.4, speed=2.0)
        write_recording(other.recording, tmp_path / "trial" / "programs" / "02.npz")
    else:
        first, second = (tmp_path / "trial" / "programs" / name for name in ("01.npz", "02.npz"))
        second.write_bytes(first.read_bytes())
    file.write_text(json.dumps(values))
    with pytest.raises(FFGymError, match=r"changed after it was drawn|different names"):
        read_trial_plan(tmp_path / "trial")


def test_nothing_is_written_over_and_a_folder_without_a_plan_is_named(tmp_path: Path):
    write_trial_plan(make_plan(), tmp_path / "trial", "", {})
    with pytest.raises(FFGymError, match="exists already"):
        write_trial_plan(make_plan(), tmp_path / "trial", "", {})
    with pytest.raises(FFGymError, match=r"holds no plan\.json"):
        read_trial_plan(tmp_path)
    (tmp_path / "plan.json").write_text('{"format": "other"}')
    with pytest.raises(FFGymError, match="no plan of this version"):
        read_trial_plan(tmp_path)


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        ({"pairs": 0}, "pairs of runs = 0"),
        ({"pairs": 8, "seed": -1}, "seed = -1"),
        ({"pairs": 8, "laps": 0}, "laps = 0"),
        ({"pairs": 9999}, "more than 10000 runs"),
    ],
)
def test_plans_that_cannot_be_carried_out_are_refused(numbers, message):
    with pytest.raises(FFGymError, match=message):
        make_plan(**numbers)


def test_programs_need_different_names_a_motion_and_for_laps_an_end_where_they_begin():
    with pytest.raises(FFGymError, match="different names"):
        make_plan(ONE, make_program("A"))
    half = replace(ONE, recording=ONE.recording.slice(end=0.9))
    assert make_plan(half).laps == 1
    with pytest.raises(FFGymError, match="does not end where it begins"):
        make_plan(half, laps=2)
    rest = replace(ONE, recording=ONE.recording.slice(end=0.2))
    with pytest.raises(FFGymError, match="all standstill"):
        plan_trial("two_joints", [rest], pairs=2, seed=0)
