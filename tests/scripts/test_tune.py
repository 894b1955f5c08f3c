"""The search for hyper-parameters goes on where it was stopped, and gives what it would have given."""

import json

import pytest

from ffgym.errors import FFGymError
from scripts import tune
from scripts.tune import SPACES, Tune, main
from tests.agents.residual.residual_samples import SMALL

TINY = {"base": "none", "steps": 16, "set": SMALL["ppo"], "plants": 1}


class Killed(BaseException):
    """What Optuna does not catch, so that it writes nothing, as where a process is killed."""


def quick(monkeypatch, calls, stop=None):
    """In place of trainings: a value of the parameters alone."""

    def objective(trial, config):
        values = {name: trial.suggest_float(name, *limits[:2]) for name, limits in SPACES["ppo"].items()}
        calls.append(values)
        if stop is not None and len(calls) == stop:
            raise Killed
        return (values["gamma"] - 0.9) ** 2

    monkeypatch.setattr(tune, "objective", objective)


def test_a_search_that_was_stopped_ends_as_if_it_had_not_been(tmp_path, monkeypatch):
    calls, whole = [], []
    quick(monkeypatch, whole)
    best = main(Tune(trials=14, out=tmp_path / "whole"))
    quick(monkeypatch, calls, stop=3)
    with pytest.raises(Killed):
        main(Tune(trials=14, out=tmp_path / "stopped"))
    assert main(Tune(trials=14, out=tmp_path / "stopped")) == best
    assert calls[:2] + calls[3:] == whole
    assert calls[2] == calls[3]
    written = json.loads((tmp_path / "stopped" / "tuned.json").read_text())
    assert written["best"] == best
    assert best["value"] == min(trial["value"] for trial in written["trials"])
    assert len(written["trials"]) == 14


def test_another_search_in_the_same_folder_is_refused_but_more_trials_are_not(tmp_path, monkeypatch):
    calls = []
    quick(monkeypatch, calls)
    main(Tune(trials=1, out=tmp_path))
    main(Tune(trials=2, out=tmp_path))
    assert len(calls) == 2
    with pytest.raises(FFGymError, match="another search: base was 'elastic', now 'none'"):
        main(Tune(trials=2, out=tmp_path, base="none"))
    with pytest.raises(FFGymError, match="--out FOLDER"):
        main(Tune())


@pytest.mark.slow
def test_a_trial_trains_and_is_judged_beside_its_base(tmp_path):
    best = main(Tune(trials=1, out=tmp_path, **TINY))
    assert abs(best["value"]) < 1
    assert best["parameters"].keys() == {*SPACES["ppo"], "bound"}
