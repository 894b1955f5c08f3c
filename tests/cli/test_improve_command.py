"""`ffgym improve` on the command line: what it refuses, and the whole circle with a real diagnosis."""

import json

import pytest

from ffgym.cli.main import main
from ffgym.effects import EFFECTS
from ffgym.simulation.plant import Machine, load_machine, save_machine
from tests.cli.errors import read_error


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ([], "--out FOLDER"),
        (["--out", "cell.toml"], "is a file, must be a folder"),
        (["--out", "folder", "--rounds", "0"], "rounds"),
        (["--out", "folder", "--most-causes", "0"], "--most-causes = 0"),
        (["--out", "folder", "--protocols", "magic"], "Unknown protocol 'magic'"),
        (["--out", "folder", "--rig", "workcell:nowhere"], "Unknown workcell"),
        (["--out", "folder", "--rig", "one_axis"], "no work area with two positions"),
        (["--out", "folder", "--json", "numbers.txt"], "must end in .json"),
        (["--out", "folder", "--positions", "p9"], "Unknown position 'p9'"),
        (["--out", "folder", "--speeds-mm-s", "0"], "speed = 0.0 m/s is out of range"),
        (["--out", "folder", "--speeds-mm-s"], "must be at least one, and all different"),
        (["--out", "folder", "--radii-mm", "-1"], "radius"),
    ],
)
def test_what_cannot_be_run_is_refused_before_anything_is_recorded(arguments, says, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "cell.toml").write_text("", encoding="utf-8")
    assert main(["improve", *arguments]) == 1
    assert says in read_error(capsys)
    assert [path.name for path in tmp_path.iterdir()] == ["cell.toml"]


@pytest.mark.slow
def test_a_hidden_effect_is_found_and_compensated(irb4600, tmp_path, capsys):
    hidden = EFFECTS["coulomb_level"].on(irb4600, "j1", change=0.3)
    rig = save_machine(Machine(robot=irb4600, effects=(hidden,)), tmp_path / "cell.toml", title="cell", source="a test")
    folder = tmp_path / "improved"
    circles = ["--positions", "p2", "--speeds-mm-s", "10", "--radii-mm", "1"]
    assert main(["improve", "--rig", str(rig), "--out", str(folder), "--rounds", "2", *circles]) == 0
    assert "ended: the last recordings do not falsify the model" in capsys.readouterr().out
    document = json.loads((folder / "improvement.json").read_text(encoding="utf-8"))
    effects = {effect.name: effect for effect in load_machine(document["rounds"][-1]["model"]).effects}
    assert effects["coulomb_level"].change == pytest.approx(hidden.change, abs=0.02)
    # zero points of the torque sensors and of the tracker are numbers, fitted beside the cause
    assert effects.keys() <= {"coulomb_level", "torque_offset", "tool_frame"}
    error = {score["law"]: score["rms_um"] for score in document["scores"]}
    assert error["model"] < 0.3 * error["elastic"]
