"""The search for hyper-parameters goes on where it was stopped, and gives what it would have given."""

import json
import os
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import pytest
import tyro

from ffgym.cli.learning_options import PolicyTraining
from ffgym.core.errors import FFGymError
from ffgym.core.files import write_bytes
from scripts import tune, tuning
from scripts.tune import main
from scripts.tuning import FAILED, SPACES, Tune, read_trials
from tests.agents.residual.residual_samples import SMALL
from tests.processes import held_elsewhere

TINY = {"base": "none", "steps": 16, "set": SMALL["ppo"], "plants": 1}


class Killed(BaseException):
    """What nobody catches, as where a process is killed."""


@pytest.fixture
def calls(monkeypatch):
    """In place of trainings: a value of the parameters alone; what was asked for."""
    calls = []

    def objective(config, trainings, folder, title):
        (training,) = trainings.values()
        calls.append(training)
        return (training.number("gamma") - 0.9) ** 2

    monkeypatch.setattr(tune, "objective", objective)
    monkeypatch.setattr(tune, "check_runs", lambda training, plants: None)
    return calls


def fails_at(monkeypatch, number, error=None, value=None):
    """Let one trial fail, by an error or by a value."""
    objective = tune.objective

    def failing(config, trainings, folder, title):
        if title.startswith(f"trial {number} "):
            if error is not None:
                raise error
            return value
        return objective(config, trainings, folder, title)

    monkeypatch.setattr(tune, "objective", failing)


def written(folder):
    return json.loads((folder / "tuned.json").read_text())


def test_a_search_that_was_stopped_ends_as_if_it_had_not_been(tmp_path, monkeypatch, calls):
    best = main(Tune(trials=14, out=tmp_path / "whole"))
    whole = calls.copy()
    calls.clear()
    with monkeypatch.context() as patch:
        fails_at(patch, 12, error=Killed())  # Optuna proposes by what is done from the eleventh on
        with pytest.raises(Killed):
            main(Tune(trials=14, out=tmp_path / "stopped"))
    assert len(calls) == 11
    assert main(Tune(trials=14, out=tmp_path / "stopped")) == best
    assert calls == whole
    assert written(tmp_path / "stopped") == written(tmp_path / "whole")
    trials = written(tmp_path / "stopped")["trials"]
    assert best["value"] == min(trial["value"] for trial in trials)
    assert len(trials) == 14


def test_another_search_in_the_same_folder_is_refused_but_more_trials_are_not(tmp_path, calls):
    main(Tune(trials=1, out=tmp_path))
    main(Tune(trials=2, out=tmp_path))
    assert len(calls) == 2
    with pytest.raises(FFGymError, match=r"another search: .*training.base was 'elastic', now 'none'"):
        main(Tune(trials=2, out=tmp_path, base="none"))
    with pytest.raises(FFGymError, match=r"another search: space.bound was \[0.3, 1.0, False\]"):
        main(Tune(trials=2, out=tmp_path, bounds=(0.3, 0.9)))


def test_other_versions_and_another_text_of_the_machine_file_are_another_search(tmp_path, calls):
    file = tmp_path / "machine.toml"
    file.write_text('[machine]\ntitle = "mine"\nrobot = "irb4600_60_205"\n')
    search = Tune(trials=1, out=tmp_path / "out", base=f"model:{file}")
    main(search)
    assert f"--base model:{file}" in written(tmp_path / "out")["best"]["options"]
    file.write_text(file.read_text().replace("mine", "other"))
    with pytest.raises(FFGymError, match=r"training.machine was .*mine.*, now .*other"):
        main(search)
    place = tmp_path / "out" / "tuned.json"
    file.write_text(file.read_text().replace("other", "mine"))
    tree = written(tmp_path / "out")
    tree["search"]["versions"]["optuna"] = "1.0"
    place.write_text(json.dumps(tree))
    with pytest.raises(FFGymError, match=r"versions.optuna was '1.0'"):
        main(search)


@pytest.mark.parametrize(
    ("failure", "reason"),
    [({"error": FFGymError("It diverged.")}, "It diverged."), ({"value": float("nan")}, "is nan")],
)
def test_a_trial_that_fails_counts_as_a_bad_one(failure, reason, tmp_path, monkeypatch, calls, capsys):
    fails_at(monkeypatch, 2, **failure)
    best = main(Tune(trials=3, out=tmp_path))
    bad = written(tmp_path)["trials"][1]
    assert bad["value"] == FAILED
    assert reason in bad["failure"]
    assert reason in capsys.readouterr().out.splitlines()[1]
    assert best["value"] < FAILED
    assert main(Tune(trials=3, out=tmp_path)) == best
    assert len(calls) == 2


def test_where_every_trial_fails_the_reason_is_told(tmp_path, monkeypatch, calls):
    fails_at(monkeypatch, 1, error=FFGymError("It diverged."))
    with pytest.raises(FFGymError, match=r"no trial gave a policy. The last failed: It diverged."):
        main(Tune(trials=1, out=tmp_path))
    assert main(Tune(trials=2, out=tmp_path))["value"] < FAILED


def test_a_full_disk_ends_the_search_and_it_goes_on_when_there_is_space(tmp_path, monkeypatch, calls):
    full = tmp_path / "missing" / "file"
    with monkeypatch.context() as patch:
        real = tune.objective
        patch.setattr(tune, "objective", lambda *args: write_bytes(full, b"") if len(calls) == 1 else real(*args))
        with pytest.raises(FFGymError, match="cannot be written"):
            main(Tune(trials=3, out=tmp_path / "out"))
    assert len(written(tmp_path / "out")["trials"]) == 1
    main(Tune(trials=3, out=tmp_path / "out"))
    assert [trial["failure"] for trial in written(tmp_path / "out")["trials"]] == [None] * 3


def test_a_search_in_a_folder_that_is_searched_in_is_refused(tmp_path, calls):
    with held_elsewhere(tmp_path), pytest.raises(FFGymError, match=r"process \d+ .* is writing there"):
        main(Tune(out=tmp_path))


@pytest.mark.parametrize(
    "damage", ["", "{", "[]", '{"search": 1, "trials": []}', '{"search": {}, "trials": [{"value": 1.0}]}']
)
def test_a_damaged_file_is_one_clear_error(damage, tmp_path, calls):
    (tmp_path / "tuned.json").write_text(damage)
    with pytest.raises(FFGymError, match=r"tuned.json: is damaged: .* Remove it and give the same command again"):
        main(Tune(out=tmp_path))


def test_damaged_numbers_of_a_trial_are_one_clear_error(tmp_path, calls):
    main(Tune(trials=1, out=tmp_path))
    whole = (tmp_path / "tuned.json").read_text()
    for change in (('"value": ', '"value": "much", "was": '), ('"gamma": 0.', '"gama": 0.')):
        (tmp_path / "tuned.json").write_text(change[1].join(whole.rsplit(change[0], 1)))
        with pytest.raises(FFGymError, match=r"tuned.json: is damaged"):
            main(Tune(trials=1, out=tmp_path))


@pytest.mark.parametrize("algorithm", ["ppo", "sac", "recurrent_ppo"])
def test_the_best_trial_has_options_that_train_it_again(algorithm, tmp_path, calls, capsys):
    config = Tune(algorithm=algorithm, trials=2, out=tmp_path, base="none", memory=3, set=("n_envs=8",))
    best = main(config)
    assert capsys.readouterr().out.splitlines()[-1] == f"ffgym train policy {best['options']} --out FOLDER"
    assert written(tmp_path)["best"] == best
    said = tyro.cli(PolicyTraining, args=shlex.split(best["options"]))
    wanted = min(calls, key=lambda training: (training.number("gamma") - 0.9) ** 2)
    assert said.with_seed(said.seed).document() == wanted.document()
    assert said.with_seed(said.seed).number("final_learning_rate") == 0.1 * best["parameters"]["learning_rate"]
    assert said.bound == best["parameters"]["bound"]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"out": None}, "--out FOLDER"),
        ({"trials": 0}, "trials = 0"),
        ({"steps": 0}, "steps = 0"),
        ({"plants": 0}, "plants = 0"),
        ({"seed": -1}, "seed = -1"),
        ({"seeds": ()}, "one or more different numbers"),
        ({"seeds": (3, 3)}, "one or more different numbers"),
        ({"seeds": (-3,)}, "seed = -3"),
        ({"bounds": (0.5, 0.5)}, "bounds = 0.5 0.5 must rise"),
        ({"bounds": (0.0, 0.5)}, "bounds = 0.0 is out of range"),
        ({"bounds": (0.1, float("nan"))}, "bounds must be finite"),
        ({"set": ("gamma=0.9",)}, "--set gamma=0.9: gamma is searched for"),
        ({"set": ("final_learning_rate=0.1",)}, "final_learning_rate is searched for"),
        ({"set": ("gama=0.9",)}, "Unknown hyper-parameter of ppo 'gama'"),
        ({"algorithm": "sac", "steps": 2000}, "must be more than learning_starts = 2000"),
        ({"robot": "one_axis"}, "Robot 'one_axis' has no position 'p1'"),
        ({"reward": "best"}, "Unknown reward 'best'"),
    ],
)
def test_what_cannot_be_searched_is_refused_and_nothing_is_written(changes, message, tmp_path):
    with pytest.raises(FFGymError, match=message):
        main(Tune(**{"out": tmp_path / "new", "base": "none"} | changes))
    assert not list(tmp_path.iterdir())


def test_the_bound_is_searched_for_and_no_option(capsys):
    assert tyro.cli(Tune, args=["--bounds", "0.2", "0.4"]).space["bound"] == (0.2, 0.4, False)
    with pytest.raises(SystemExit):
        tyro.cli(Tune, args=["--bound", "0.2"])


def test_what_is_missing_is_named_with_the_way_to_get_it(monkeypatch, tmp_path):
    monkeypatch.setattr(tuning, "is_installed", lambda name: name != "optuna")
    with pytest.raises(FFGymError, match=r"needs optuna; pip install 'ffgym\[tune\]'"):
        main(Tune(out=tmp_path / "new"))
    code = "import scripts.tune, sys; print([name for name in ('torch', 'optuna') if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.slow
def test_a_trial_trains_and_is_judged_beside_its_base(tmp_path):
    best = main(Tune(trials=1, out=tmp_path, **TINY))
    assert abs(best["value"]) < 1
    assert best["parameters"].keys() == {*SPACES["ppo"], "bound"}
    (folder,) = written(tmp_path)["trials"][0]["folders"]
    assert (tmp_path / folder / "policy.npz").exists()


@pytest.mark.slow
def test_a_search_that_was_killed_goes_on(tmp_path):
    code = (
        "import os, signal; from pathlib import Path\n"
        "from scripts import tune\n"
        "write = tune.write_trials\n"
        "def killing(file, search, trials, best):\n"
        "    write(file, search, trials, best)\n"
        "    if trials: os.kill(os.getpid(), signal.SIGKILL)\n"
        "tune.write_trials = killing\n"
        f"tune.main(tune.Tune(trials=2, out=Path({str(tmp_path / 'killed')!r}), **{TINY!r}))"
    )
    killed = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=os.environ)
    assert killed.returncode == -signal.SIGKILL, killed.stderr
    best = main(Tune(trials=2, out=tmp_path / "killed", **TINY))
    assert main(Tune(trials=2, out=tmp_path / "whole", **TINY)) == best
    assert written(tmp_path / "killed") == written(tmp_path / "whole")


@pytest.mark.parametrize("algorithm", ["ppo", "recurrent_ppo", "sac", "tqc"])
def test_a_committed_record_is_of_a_search_that_can_be_asked_for_and_its_page_shows_every_trial(algorithm):
    folder = Path(__file__).parents[2] / "docs" / "agents"
    file = folder / f"tuned_{algorithm}_drives.json"
    record = json.loads(file.read_text())
    trials = read_trials(file, record["search"])
    assert record["search"]["space"].keys() == {*SPACES[algorithm], "bound"}
    assert record["best"]["value"] == min(trial.value for trial in trials)
    page = (folder / "residual.md").read_text()
    assert all(f"| {t.value:+.3f} | {t.parameters['learning_rate']:.4f} |" in page for t in trials)
