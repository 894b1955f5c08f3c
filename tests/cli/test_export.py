"""`ffgym export` writes folders that plain MuJoCo loads and runs."""

import json
import subprocess
import sys
from importlib import resources

import mujoco
import numpy as np
import pytest

from ffgym.cli.main import main
from ffgym.robot import ModelOptions, builtin_robots, compile_model, load_robot, physics_fingerprint

WITH_MODEL = ["README.txt", "model.xml"]
WITH_MOTION = sorted([*WITH_MODEL, "controls.csv", "play.py", "recording.csv", "reference.csv"])


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path, monkeypatch):
    """MuJoCo writes MUJOCO_LOG.TXT into the working directory when something is wrong."""
    monkeypatch.chdir(tmp_path)


def only_line_of_error(capsys):
    out = capsys.readouterr()
    (line,) = out.err.splitlines()
    assert line.startswith("ffgym: error: ")
    assert out.out == ""
    return line


def names(folder):
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize("robot", builtin_robots())
def test_a_robot_alone_is_one_model_without_stray_files(robot, tmp_path, capsys):
    assert main(["export", robot, "--binary"]) == 0
    assert names(tmp_path) == ["export"]
    assert names(tmp_path / "export") == sorted([*WITH_MODEL, "model.mjb"])
    own = compile_model(load_robot(robot))
    models = [mujoco.MjModel.from_xml_path("export/model.xml"), mujoco.MjModel.from_binary_path("export/model.mjb")]
    assert {(model.nv, model.nu, model.na, model.ngeom) for model in models} == {(own.nv, own.nu, own.na, own.ngeom)}
    assert len({physics_fingerprint(model) for model in models}) == 1
    assert capsys.readouterr().out == (
        f"{own.nv} degrees of freedom, {own.nu} controls (position, velocity, torque of each motor)\nfolder: export\n"
    )


def test_a_motion_comes_with_all_that_repeats_it(tmp_path, capsys):
    options = ["--feedforward", "lugre_dynamic", "--out", "circles", "--json", "origin.json", "--angles", "deg"]
    assert main(["export", "irb4600_60_205", "circles", *options]) == 0
    assert names(tmp_path / "circles") == WITH_MOTION
    out = capsys.readouterr().out
    assert "circles with lugre_dynamic: " in out
    assert out.endswith("folder: circles\nnumbers: origin.json\n")
    played = subprocess.run([sys.executable, "circles/play.py"], capture_output=True, text=True, check=False)
    assert played.returncode == 0, played.stdout + played.stderr
    origin = json.loads((tmp_path / "origin.json").read_text())
    own = physics_fingerprint(compile_model(load_robot("irb4600_60_205"), ModelOptions(looks=False)))
    assert origin["physics_fingerprint"] == own
    assert origin["command"] == "ffgym export"
    assert origin["config"]["angles"] == "deg"
    assert origin["feedforward_law"] == "lugre_dynamic"
    assert origin["seed"] is None
    assert origin["versions"]["mujoco"] == mujoco.__version__
    assert "motor.position.j1 [deg]" in (tmp_path / "circles" / "reference.csv").read_text().splitlines()[0]


SHORT = """MODULE short
  PERS tooldata tPen := [TRUE, [[20, 0, 250], [1, 0, 0, 0]], [1, [0, 0, 60], [1, 0, 0, 0], 0.01, 0.01, 0.01]];
  CONST robtarget pHere := [[1300, -200, 600], [0, 0, 1, 0], [-1, 0, -1, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  PROC main()
    MoveJ pHere, v100, fine, tPen;
    MoveL Offs(pHere, 0, 5, 0), v100, fine, tPen;
  ENDPROC
ENDMODULE
"""
"""A program with a tool of its own that moves 5 mm."""

PROGRAM = str(resources.files("ffgym.paths.rapid") / "examples" / "thesis_circles.mod")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("robot", "motion"),
    [
        *((robot, motion) for robot in builtin_robots() for motion in ("multisine", "triangle")),
        *((robot, motion) for robot in ("irb4600_60_205", "kuka_kr300_r2500") for motion in ("circles", "square")),
        ("irb4600_60_205", PROGRAM),
    ],
)
def test_shipped_motions_on_shipped_robots_are_repeated(robot, motion):
    assert main(["export", robot, motion, "--feedforward", "lugre_dynamic"]) == 0
    played = subprocess.run([sys.executable, "export/play.py"], capture_output=True, text=True, check=False)
    assert played.returncode == 0, played.stdout + played.stderr


def test_a_program_that_brings_its_tool_is_exported_with_it(tmp_path):
    source = tmp_path / "short.mod"
    source.write_text(SHORT)
    assert main(["export", "irb4600_60_205", str(source)]) == 0
    tcp = mujoco.MjModel.from_xml_path("export/model.xml").site("tcp").pos
    np.testing.assert_allclose(tcp, [0.02, 0.0, 0.25], atol=1e-12)
    played = subprocess.run([sys.executable, "export/play.py"], capture_output=True, text=True, check=False)
    assert played.returncode == 0, played.stdout + played.stderr


def test_parts_that_are_left_out_are_left_out_of_model_and_motion(tmp_path):
    left_out = ["--no-flexible", "--no-friction", "--no-gravity"]
    assert main(["export", "irb4600_60_205", "circles", *left_out, "--json", "origin.json"]) == 0
    model = mujoco.MjModel.from_xml_path("export/model.xml")
    assert (model.nv, model.nactuator) == (6, 6)
    np.testing.assert_array_equal(model.opt.gravity, 0)
    options = ModelOptions(flexible=False, friction=False, gravity=False, looks=False)
    own = physics_fingerprint(compile_model(load_robot("irb4600_60_205"), options))
    assert json.loads((tmp_path / "origin.json").read_text())["physics_fingerprint"] == own


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["irb"], "Unknown robot 'irb'. Available: "),
        (["absent.toml"], "absent.toml"),
        (["one_axis", "--out", "robot.xml"], "robot.xml: must be a folder; the model in it is model.xml"),
        (["one_axis", "--out", "absent/robot"], "absent does not exist; create it"),
        (["one_axis", "--json", "absent/origin.json"], "absent does not exist; create it"),
        (["one_axis", "--entry", "main"], "--entry has no effect without a motion"),
        (["one_axis", "--feedforward", "elastic", "--angles", "deg"], "--feedforward, --angles has no effect without"),
        (["irb4600_60_205", "absent.mod"], "absent.mod"),
        (["irb4600_60_205", "circles", "--feedforward", "magic"], "magic"),
        (["irb4600_60_205", "circles", "--record-dt-ms", "3"], "record_dt = 0.003 s must be"),
    ],
)
def test_a_request_that_cannot_be_met_is_one_line_and_leaves_nothing(arguments, message, capsys, tmp_path):
    assert main(["export", *arguments]) == 1
    assert message in only_line_of_error(capsys)
    assert names(tmp_path) == []


def test_a_bad_description_is_one_line_too(tmp_path, capsys):
    path = tmp_path / "broken.toml"
    path.write_text("[robot]\nname = [\n")
    assert main(["export", str(path)]) == 1
    assert "broken.toml is not valid TOML" in only_line_of_error(capsys)


def test_a_folder_with_something_in_it_is_not_replaced(tmp_path, capsys):
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "mine").write_text("mine")
    assert main(["export", "one_axis", "--out", "taken"]) == 1
    assert "taken: exists already" in only_line_of_error(capsys)
    assert names(tmp_path / "taken") == ["mine"]
