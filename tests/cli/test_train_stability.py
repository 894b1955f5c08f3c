"""`ffgym train stability`: what it prints is what the analysis says, and its figure is made on request only."""

import re

import numpy as np
import pytest

from ffgym.agents.bspline import StaticBSN
from ffgym.agents.changing_motions import ChangingMotions
from ffgym.agents.law_files import load_law
from ffgym.agents.stability import LearningStability
from ffgym.cli.main import main
from ffgym.robot import RigidArm
from ffgym.studies import sine_references


@pytest.fixture(scope="module")
def study(one_axis) -> LearningStability:
    """Of the sine of 1 Hz."""
    return LearningStability.of(StaticBSN.zero(1), RigidArm(one_axis), [sine_references(one_axis)[1.0]])


def numbers_after(words: str, text: str) -> list[float]:
    (line,) = re.findall(rf"^{re.escape(words)} +(.*)$", text, flags=re.M)
    return [float(value) for value in line.split()]


def test_it_prints_the_largest_rate_the_growth_and_what_is_left(study, capsys):
    arguments = ["--robot", "one_axis", "--network", "static", "--frequencies-hz", "1", "--gamma", "1.9"]
    assert main(["train", "stability", *arguments, "--iterations", "3"]) == 0
    text = capsys.readouterr().out
    left = np.sqrt(study.mean_squares(1.9, 3)[-1] / study.mean_squares(1.9, 3)[0])
    assert text.startswith("sine 1 Hz\n")
    assert numbers_after("largest stable learning rate", text) == pytest.approx(study.largest_rate, abs=5e-4)
    assert numbers_after("growth per iteration at 1.9", text) == pytest.approx(study.growth(1.9), abs=5e-4)
    assert numbers_after("friction left after 3 (RMS)", text) == pytest.approx(left, abs=5e-4)
    assert "Learning rate 1.9 is above the largest stable one (j1 1.7)" in text


def test_several_motions_are_shown_alone_and_together(capsys):
    assert main(["train", "stability", "--robot", "one_axis"]) == 0
    blocks = capsys.readouterr().out.strip().split("\n\n")
    assert [block.split("\n")[0] for block in blocks] == ["sine 1 Hz", "sine 3 Hz", "sine 1 Hz + sine 3 Hz"]
    assert all("growth per iteration at 0.8 " in block for block in blocks)  # the rate of the thesis
    assert all("friction left after 15" in block for block in blocks)
    assert blocks[0].endswith("0.8 is stable on every joint.")


def test_trials_of_changing_motions_are_shown_where_they_are_asked_for(one_axis, capsys):
    arguments = ["--robot", "one_axis", "--changing", "--gamma", "1.9", "--network", "static"]
    assert main(["train", "stability", *arguments]) == 0
    block = capsys.readouterr().out.strip().split("\n\n")[-1]
    changing = ChangingMotions.of(StaticBSN.zero(1), RigidArm(one_axis), list(sine_references(one_axis).values()))
    assert numbers_after("growth per trial at 1.9, at most", block) == pytest.approx(changing.bound(1.9), abs=5e-4)
    assert numbers_after("worst order found, repeated", block) == pytest.approx(changing.worst(1.9)[0], abs=5e-4)
    assert "grows on j1: sine" in block


def test_a_figure_of_the_joints_asked_for_is_simulated_and_drawn(tmp_path, capsys):
    target = tmp_path / "learning.svg"
    arguments = ["--speeds-mm-s", "100", "--iterations", "1", "--figure-rates", "0.5", "0.9", "--figure-joints", "j4"]
    assert main(["train", "stability", *arguments, "--figure", str(target)]) == 0
    assert "<svg" in target.read_text(encoding="utf-8")
    *_, caption, file, _ = capsys.readouterr().out.split("\n")
    assert file == f"figure: {target}"
    assert re.findall(r"(j\d), p1, 100 mm/s: ", caption) == ["j4"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--gamma", "0"], "gamma = 0.0"),
        (["--iterations", "-1"], "iterations = -1"),
        (["--record-dt-ms", "3"], "record_dt = 0.003 s must divide"),
        (["--figure", "picture.gif"], "figure format"),
        (["--figure-joints", "j2"], "joint 'j2'"),
        (["--figure", "a.png", "--figure-rates"], "figure rates = [] must be one or more"),
        (["--figure", "a.png", "--figure-rates", "2", "1"], "figure rates = [2.0, 1.0] must be one or more, ascending"),
        (["--figure", "a.png", "--figure-rates", "-1"], "figure rate = -1.0"),
        (["--figure", "a.png", "--figure-rates", "1e-308"], "figure rate = 1e-308"),
        (["--figure", "a.png", "--figure-rates", "1e308"], "figure rate = 1e+308"),
        (["--figure", "a.png", "--iterations", "100000"], "of motion would take about"),
        (["--gamma", "1e308"], "gamma = 1e+308"),
        (["--iterations", "1000000000"], "iterations = 1000000000.0 is out of range"),
        (["--record-dt-ms", "1e-9"], "into 16 parts at most"),
        (["--record-dt-ms", "1e-311"], "into 16 parts at most"),
        (["--frequencies-hz"], "no motion to learn on"),
        (["--frequencies-hz", "1e-308"], "nothing moves"),
    ],
)
def test_impossible_options_are_one_clear_line(arguments, message, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["train", "stability", "--robot", "one_axis", *arguments]) == 1
    output = capsys.readouterr()
    assert message in output.err
    assert output.out == ""


@pytest.mark.parametrize(("rate", "warned"), [("0.8", False), ("1.9", True)])
def test_training_warns_of_a_rate_above_the_limit_and_goes_on(study, rate, warned, tmp_path, capsys):
    law = tmp_path / "law.npz"
    arguments = ["--robot", "one_axis", "--network", "static", "--iterations", "1", "--gamma", rate]
    assert main(["train", "bspline", *arguments, "--out", str(law)]) == 0
    message = f"ffgym: warning: {study.warning(float(rate))}"
    assert (message in capsys.readouterr().err) == warned
    assert law.exists()


def test_training_learns_from_the_rows_that_are_asked_for(tmp_path):
    arguments = ["--robot", "one_axis", "--frequencies-hz", "3", "--network", "static", "--iterations", "1"]
    for folder, rows in (("every", "1"), ("samples", "4")):
        (tmp_path / folder).mkdir()
        options = ["--record-dt-ms", rows, "--out", str(tmp_path / folder / "law.npz")]
        assert main(["train", "bspline", *arguments, *options]) == 0
    every, samples = (load_law(tmp_path / folder / "law.npz").coefficients for folder in ("every", "samples"))
    assert np.count_nonzero(every) > np.count_nonzero(samples) > 0  # some splines are met between samples only
