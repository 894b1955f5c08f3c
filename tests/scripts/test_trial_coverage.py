"""Coverage of trials: the script, and the repetitions that the page on trials stands on."""

import json

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.deployment.trial.gains import OVERALL
from scripts import trial_coverage
from scripts.tables.trial import COVERAGE, coverage
from scripts.trial_coverage import Config, count_rows, count_trials, main, prepare_study

CIRCLE = (("p1", 0.1, 0.005),)


def test_intervals_cover_the_true_gain_and_nothing_is_claimed_where_nothing_is_gained():
    rows = json.loads(COVERAGE.read_text(encoding="utf-8"))["rows"]
    for row in rows:  # whose numbers are rounded to six digits
        low, high = row["low"] - row["truth"], row["high"] - row["truth"]
        assert min(abs(low), abs(high)) < 2e-6 or row["covered"] == (low <= 0 <= high)
    for machine in {row["machine"] for row in rows}:
        own = [row for row in rows if row["machine"] == machine]
        counts = count_rows(own)
        assert {"elastic", "nothing", "mirrored"} == {one["law"] for one in counts}
        for one in counts:
            assert one["repetitions"] == 100
            if one["law"] == "elastic":
                assert one["truth"] > 0.5
                assert 90 <= one["covered"] <= 98
                assert one["gain_claimed"] == 100
            else:
                assert abs(one["truth"]) < 0.02
                assert one["covered"] >= 90
                assert one["gain_claimed"] <= 5
        # gains that a trial claims of any program or of all, where there is none
        for law in ("nothing", "mirrored"):
            assert count_trials(own, law, "gain") <= 5


def test_what_is_gained_changes_while_the_machine_warms_up():
    rows = [row for row in json.loads(COVERAGE.read_text(encoding="utf-8"))["rows"] if row["law"] == "elastic"]
    for place in {(row["machine"], row["program"]) for row in rows}:
        assert np.ptp([row["truth"] for row in rows if (row["machine"], row["program"]) == place]) > 1e-3


def test_the_page_has_a_row_for_each_correction_and_program():
    table = coverage().parts["coverage"]
    kept = json.loads(COVERAGE.read_text(encoding="utf-8"))
    machines = {row["machine"] for row in kept["rows"]}
    assert table.count("\n| workcell") == len(machines) * len(count_rows(kept["rows"]))
    assert f"nothing: a gain in {count_trials(kept['rows'], 'nothing', 'gain')} of {100 * len(machines)}, " in table
    assert f"seed {kept['origin']['seed']}" in table


@pytest.fixture
def quick(monkeypatch):
    """A grid of the truth that costs little."""
    monkeypatch.setattr(trial_coverage, "_TIMES", 3)
    monkeypatch.setattr(trial_coverage, "_DRAWS", 2)


def test_a_repetition_is_a_trial_of_its_own_that_follows_from_its_number(quick):
    study = prepare_study("workcell:3", pairs=2, seed=1, laws=("elastic",), circles=CIRCLE)
    (first,), (again,), (other,) = (study.repeat("elastic", 2, k) for k in (0, 0, 1))
    assert first == again
    assert first["gain"] != other["gain"]
    for row in (first, other):
        assert row["program"] != OVERALL
        assert row["gain"] == pytest.approx(row["truth"], abs=0.02)


def test_the_script_goes_on_where_its_file_ends_and_refuses_one_of_other_settings(quick, tmp_path, monkeypatch, capsys):
    made = []

    class Study:
        def repeat(self, law, pairs, repetition):
            made.append(repetition)
            return [{"program": "a", "truth": 0.1, "low": 0.0, "high": 0.2, "covered": True, "claim": "none"}]

    monkeypatch.setattr(trial_coverage, "prepare_study", lambda *args, **options: Study())
    options = {"machines": ("workcell:12",), "laws": ("nothing",), "json": tmp_path / "kept.json"}
    main(Config(repetitions=2, **options))
    main(Config(repetitions=3, **options))
    assert made == [0, 1, 2]
    assert "covers it in 3 of 3" in capsys.readouterr().out
    with pytest.raises(FFGymError, match="other settings"):
        main(Config(repetitions=3, seed=5, **options))


def test_a_machine_that_does_not_warm_up_is_refused():
    with pytest.raises(FFGymError, match="no workcell that warms up"):
        prepare_study("irb4600_60_205", pairs=2, seed=1)


def test_a_workcell_whose_errors_do_not_depend_on_temperature_is_refused(quick):
    with pytest.raises(FFGymError, match=r"No error of seed-12 changes by 1%"):
        prepare_study("workcell:12", pairs=2, seed=1, laws=("elastic",), circles=CIRCLE)


@pytest.mark.slow
def test_a_hundred_trials_on_a_workcell_cover_its_true_gain_and_claim_none_where_there_is_none():
    study = prepare_study("workcell:3", pairs=6, seed=2, laws=("elastic", "nothing"), circles=CIRCLE)
    rows = {law: [study.repeat(law, 6, k)[0] for k in range(100)] for law in study.laws}
    assert 90 <= sum(row["covered"] for row in rows["elastic"]) <= 98
    assert all(row["claim"] == "gain" for row in rows["elastic"])
    assert sum(row["claim"] == "gain" for row in rows["nothing"]) <= 5
    assert sum(row["covered"] for row in rows["nothing"]) >= 90
    assert np.std([row["gain"] for row in rows["elastic"]]) > 1e-4
