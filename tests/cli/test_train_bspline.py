"""`ffgym train bspline`: what it prints and writes, and that an interrupted training goes on."""

import json

import numpy as np
import pytest

from ffgym.agents.bspline import ExtendedBSN, StaticBSN
from ffgym.agents.law_files import load_law, unpack
from ffgym.agents.tensor_bspline import TensorBSN
from ffgym.agents.trials import thesis_motions
from ffgym.cli.main import main
from ffgym.robot import ModelOptions, RigidArm, compile_model, physics_fingerprint
from tests.cli.errors import read_error

FEW = ["--robot", "one_axis", "--iterations", "2"]


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    """Folder with what a short training wrote."""
    folder = tmp_path_factory.mktemp("lffc")
    options = ["--prior", "--out", str(folder / "mine.npz"), "--json", str(folder / "mine.json")]
    assert main(["train", "bspline", *FEW, *options]) == 0
    return folder


def test_the_law_is_named_after_its_file_and_nothing_else_is_left(trained, one_axis):
    assert {path.name for path in trained.iterdir()} == {"mine.npz", "mine.json"}
    law = load_law(trained / "mine.npz")
    assert isinstance(law, ExtendedBSN)
    assert law.name == "mine"
    assert law.torque(thesis_motions(RigidArm(one_axis))[0]).any()


def test_the_numbers_say_where_they_come_from(trained, one_axis):
    numbers = json.loads((trained / "mine.json").read_text())
    assert numbers["command"] == "ffgym train bspline"
    assert numbers["robot"] == "one_axis"
    assert numbers["seed"] is None
    assert numbers["learning"]["rate"] == 0.8
    assert numbers["motions"] == ["sine 1 Hz"]
    assert (numbers["trials"], numbers["robot_seconds"]) == (4, 40.0)
    assert np.shape(numbers["mean_square_error_rad2"]) == np.shape(numbers["mean_square_signal"]) == (3, 1, 1)
    assert numbers["best_trial"] == [2]
    assert numbers["physics_fingerprint"] == physics_fingerprint(compile_model(one_axis, ModelOptions(looks=False)))
    assert "mujoco" in numbers["versions"]
    header, _ = unpack(trained / "mine.npz")
    assert header["meta"] == numbers


def test_a_row_per_trial_is_printed(tmp_path, capsys):
    assert main(["train", "bspline", *FEW, "--network", "static", "--out", str(tmp_path / "a.npz")]) == 0
    text = capsys.readouterr().out
    error = text.split("mean square of the learning signal")[0].splitlines()
    assert error[:3] == ["mean square of the motor error, trial 0 is 1", "trial        j1", "    0   1.0000 "]
    values = [float(line.split()[1].strip("*")) for line in error[2:5]]
    assert values == sorted(values, reverse=True)
    assert "3 trials, 30 s of robot time" in text
    assert isinstance(load_law(tmp_path / "a.npz"), StaticBSN)


def test_a_tensor_network_learns_by_the_plain_gradient_where_both_are_asked_for(tmp_path):
    options = ["--network", "tensor", "--position-knots", "5", "--unnormalised", "--gamma", "0.004"]
    out = tmp_path / "mine.npz"
    assert main(["train", "bspline", *FEW, *options, "--out", str(out), "--json", str(tmp_path / "a.json")]) == 0
    law = load_law(out)
    assert isinstance(law, TensorBSN)
    assert not law.normalised
    assert law.coefficients.shape == (1, 5, 79)
    error = np.ravel(json.loads((tmp_path / "a.json").read_text())["mean_square_error_rad2"])
    assert error[-1] < 0.8 * error[0]


def test_an_interrupted_training_goes_on_with_resume_and_only_with_it(tmp_path, trained, capsys, monkeypatch):
    options = ["train", "bspline", *FEW, "--prior", "--out", str(tmp_path / "mine.npz")]

    def stop(*_, **__):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("ffgym.cli.train_bspline.save_law", stop)
        assert main(options) == 130
    assert [path.name for path in tmp_path.iterdir()] == ["mine.state.npz"]
    assert main(options) == 1
    assert "go on with it by --resume, or delete it" in capsys.readouterr().err
    assert main([*options, "--gamma", "0.5", "--resume"]) == 1
    assert "rate was 0.8, now 0.5" in capsys.readouterr().err
    assert main([*options, "--resume"]) == 0
    assert [path.name for path in tmp_path.iterdir()] == ["mine.npz"]
    np.testing.assert_array_equal(
        load_law(tmp_path / "mine.npz").coefficients, load_law(trained / "mine.npz").coefficients
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--out", "law.txt"], "must end in .npz"),
        (["--json", "law.npz"], "need two files"),
        (["--positions", "p9"], "Unknown position 'p9'"),
        (["--gamma", "0"], "learning rate gamma = 0.0 is out of range"),
        (["--order", "0"], "order = 0"),
        (["--order", "1000000000"], "order = 1000000000"),
        (["--gamma", "1e308"], "learning rate gamma = 1e+308 is out of range"),
        (["--unnormalised"], "--unnormalised needs --gamma"),
        (["--network", "tensor", "--position-knots", "1"], "position knots = 1"),
        (["--position-knots", "5"], "--position-knots has no effect on the extended network"),
    ],
)
def test_a_training_that_cannot_run_is_one_line_and_exit_code_1(arguments, message, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["train", "bspline", "--out", "law.npz", *arguments]) == 1
    assert message in read_error(capsys)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["train", "bspline", *FEW, "--positions", "p9"], "--positions has no effect: robot 'one_axis' runs sines"),
        (
            ["train", "bspline", "--frequencies-hz", "3"],
            "--frequencies-hz has no effect: robot 'irb4600_60_205' runs circles",
        ),
        (["train", "stability", "--robot", "one_axis", "--speeds-mm-s", "7"], "--speeds-mm-s has no effect"),
    ],
)
def test_an_option_without_effect_is_refused(arguments, message, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 1
    assert message in read_error(capsys)
    assert not list(tmp_path.iterdir())
