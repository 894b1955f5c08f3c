"""`ffgym train policy`: options, what it writes and prints, and what it refuses."""

import json

import pytest

from ffgym.agents.residual.policy import load_policy
from ffgym.cli.learning_options import PolicyTraining
from ffgym.cli.main import main
from tests.cli.errors import read_error

FEW = ["--set", "n_envs=2", "n_steps=8", "batch_size=8", "segment_steps=16", "n_epochs=2"]


def test_a_policy_its_numbers_and_the_way_to_it_are_written(tmp_path, capsys):
    out, numbers = tmp_path / "trained", tmp_path / "numbers.json"
    options = ["--base", "lugre_dynamic", "--steps", "32", "--seed", "7", "--json", str(numbers), *FEW]
    assert main(["train", "policy", "--out", str(out), *options]) == 0
    printed = capsys.readouterr().out.splitlines()
    assert printed[0] == "ppo on lugre_dynamic, seed 7: 32 steps"
    assert printed[1].startswith("reward per step, with exploration: -")
    assert printed[2] == f"policy: {out / 'policy.npz'}"
    found = json.loads(numbers.read_text())
    assert (found["command"], found["seed"], found["env_steps"]) == ("ffgym train policy", 7, 32)
    assert found["sha256"] == json.loads((out / "training.json").read_text())["sha256"]
    assert found["physics_fingerprint"]
    assert found["training"]["base"] == "lugre_dynamic"
    policy = load_policy(out / "policy.npz")
    assert (policy.base, policy.meta["seed"], policy.actor.factored) == ("lugre_dynamic", 7, True)
    assert main(["train", "policy", "--out", str(out), *options]) == 0  # it is done
    assert main(["train", "policy", "--out", str(out), *options, "--seed", "8"]) == 1
    assert "training.seed was 7, now 8" in capsys.readouterr().err


def test_what_is_trained_must_be_said(capsys):
    assert main(["train", "--algorithm", "ppo"]) == 1
    assert "ffgym train policy, ffgym train bspline" in capsys.readouterr().err
    assert main(["train", "--help"]) == 0
    assert capsys.readouterr().out.splitlines()[3] == "  ffgym train policy --algorithm ppo --out mine"


def test_options_make_the_training():
    training = PolicyTraining(algorithm="recurrent_ppo", nominal=True, set=("lstm_cells=4",)).with_seed(3)
    assert training.seed == 3
    assert not training.factored
    assert not training.randomization
    assert training.hyperparameters["lstm_cells"] == 4
    assert PolicyTraining(robot="one_axis").with_seed(0).robot == "one_axis"
    assert PolicyTraining().with_seed(0).factored
    assert not PolicyTraining(joint=True).with_seed(0).factored


def test_a_machine_file_is_kept_with_the_training(tmp_path):
    file = tmp_path / "machine.toml"
    file.write_text('[machine]\ntitle = "mine"\nrobot = "irb4600_60_205"\n')
    training = PolicyTraining(base=f"model:{file}").with_seed(0)
    assert (training.base, training.machine) == ("model", file.read_text())


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ([], "--out FOLDER"),
        (["--out", "file"], "--out file: is a file"),
        (["--out", "new", "--base", "oracle"], "Unknown base 'oracle'"),
        (["--out", "new", "--set", "gama=1"], "Unknown hyper-parameter of ppo 'gama'"),
        (["--out", "new", "--json", "numbers.txt"], "must end in .json"),
        (["--out", "new", "--json", "new/training.json"], "--json new/training.json: lies in --out new"),
        (["--out", "new", "--reward", "best"], "Unknown reward 'best'"),
        (["--out", "new", "--robot", "one_axis"], "Robot 'one_axis' has no position 'p1'"),
    ],
)
def test_what_cannot_be_trained_is_refused_and_nothing_is_left(options, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("")
    assert main(["train", "policy", *options]) == 1
    assert message in read_error(capsys)
    assert {path.name for path in tmp_path.iterdir()} == {"file"}


def test_what_is_missing_is_named_with_the_way_to_get_it(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr("ffgym.cli.outputs.is_installed", lambda name: name != "sb3-contrib")
    assert main(["train", "policy", "--out", str(tmp_path / "new")]) == 1
    assert "needs sb3-contrib; pip install 'ffgym[rl]'" in capsys.readouterr().err
