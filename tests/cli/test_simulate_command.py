"""`ffgym simulate`: any motion on any robot; what it writes, prints and refuses."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from ffgym.cli.main import main
from ffgym.cli.outputs import file_of_each
from ffgym.core.errors import FFGymError
from ffgym.recordings import read_recording
from ffgym.robot import ModelOptions, compile_model, load_robot, physics_fingerprint
from ffgym.simulation import Run, simulate
from tests.cli.errors import read_error

MOTION_OF_ONE_AXIS = "sine"
ROOT = Path(__file__).parents[2]
PROGRAM = """
MODULE shift
  CONST robtarget start := [[1300, -200, 600], [0, 0.7071067811865476, 0.7071067811865476, 0], [0, 0, 0, 0],
    [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  PROC main()
    MoveJ start, v100, fine, tool0;
    MoveL Offs(start, 5, 0, 0), v50, fine, tool0;
    MoveL Offs(start, 5, 5, 0), v50, fine, tool0;
  ENDPROC
ENDMODULE
"""


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*arguments):
    return main(["simulate", *arguments])


def test_a_program_on_the_built_in_robot_gives_recordings_numbers_page_and_tables(here, capsys):
    pytest.importorskip("ffgym.report")
    (here / "shift.mod").write_text(PROGRAM, encoding="utf-8")
    outputs = ["--record-dt-ms", "4", "--out", "cut.npz", "--json", "cut.json", "--report", "cut.html"]
    assert run("irb4600_60_205", "shift.mod", "--feedforward", "none", "elastic", *outputs) == 0
    names = {"shift.mod", "cut_none.npz", "cut_elastic.npz", "cut.json", "cut.html"}
    assert {path.name for path in here.iterdir()} == names
    printed = capsys.readouterr().out
    for name in names - {"shift.mod"}:
        assert name in printed
    assert "path error [mm]" in printed
    numbers = json.loads((here / "cut.json").read_text())
    assert [result["agent"] for result in numbers["results"]] == ["none", "elastic"]
    for result in numbers["results"]:
        recording = read_recording(numbers["recordings"][result["agent"]])
        assert recording.header.meta["feedforward_law"] == result["agent"]
        assert recording.t[-1] == pytest.approx(numbers["duration"], abs=1e-9)
        assert f"{result['path'][0]['rms_mm']:.3f}" in printed
        assert len(result["motor_rms_rad"]) == len(result["torque_use"]) == len(result["speed_use"]) == 6
    before, after = (result["path"][0]["rms_mm"] for result in numbers["results"])
    assert after < before / 2
    assert "data:image/svg+xml" in (here / "cut.html").read_text(encoding="utf-8")


def test_the_recording_is_that_of_simulate_and_the_numbers_say_where_they_come_from(here, arm, irb4600):
    from ffgym.paths.motions import load_motion

    assert run("irb4600_60_205", "circles", "--feedforward", "none", "--out", "c.csv", "--json", "c.json") == 0
    reference = load_motion(arm, "circles").reference
    (expected,) = simulate([Run(reference=reference)], arm=arm)
    assert read_recording("c.csv").equals(expected)
    numbers = json.loads((here / "c.json").read_text())
    assert numbers["command"] == "ffgym simulate"
    assert numbers["config"]["path"] == "circles"
    assert (numbers["robot"], numbers["motion"]) == (irb4600.name, reference.name)
    assert numbers["seed"] is None
    assert numbers["physics_fingerprint"] == physics_fingerprint(compile_model(irb4600, ModelOptions(looks=False)))
    assert numbers["versions"].keys() == {"ffgym", "mujoco", "numpy", "scipy", "gymnasium", "python"}


def test_sensors_are_seeded_and_leave_out_what_no_machine_knows(here):
    for name, seed in (("a", "1"), ("b", "1"), ("c", "2")):
        arguments = [
            "--feedforward",
            "none",
            "--sensors",
            "--seed",
            seed,
            "--out",
            f"{name}.npz",
            "--json",
            f"{name}.json",
        ]
        assert run("irb4600_60_205", "circles", *arguments) == 0
    a, b, c = (read_recording(f"{name}.npz") for name in "abc")
    assert a.equals(b)
    assert not np.array_equal(a["tcp.position.x"], c["tcp.position.x"], equal_nan=True)
    assert not a.has("friction.effort")
    assert json.loads((here / "c.json").read_text())["seed"] == 2


def test_parameters_change_the_laws_and_not_the_machine(here, one_axis):
    half = here / "half.toml"
    table = "[friction.{}]\nvalue = {}\nunit = 'N m'\nside = 'motor'\norigin = 'chosen'\nsource = 'test'\n"
    values = [v / 2 for v in one_axis.friction.coulomb.tolist()]
    half.write_text(table.format("coulomb", values) + table.format("static", values), encoding="utf-8")
    results = {}
    for name, more in {"own": [], "half": ["--parameters", "half.toml"]}.items():
        arguments = ["--feedforward", "none", "lugre_static", "--json", f"{name}.json", *more]
        assert run("one_axis", MOTION_OF_ONE_AXIS, *arguments) == 0
        results[name] = {r["agent"]: r for r in json.loads((here / f"{name}.json").read_text())["results"]}
    assert results["own"]["none"] == results["half"]["none"]
    assert results["own"]["lugre_static"]["motor_rms_rad"] < results["half"]["lugre_static"]["motor_rms_rad"]


@pytest.mark.parametrize("robot", ["one_axis", "ball_screw"])
def test_robots_without_a_tool_have_joints_and_no_path(here, capsys, robot):
    assert run(robot, MOTION_OF_ONE_AXIS, "--json", "s.json") == 0
    printed = capsys.readouterr().out
    assert "motor error [mrad]" in printed
    assert "path error" not in printed
    assert all(result["path"] == [] for result in json.loads((here / "s.json").read_text())["results"])


def test_parts_of_the_machine_can_be_left_out(here):
    for name, more in {"whole": [], "stiff": ["--no-flexible"], "smooth": ["--no-friction"]}.items():
        arguments = ["--feedforward", "none", "--json", f"{name}.json", *more]
        assert run("irb4600_60_205", "circles", *arguments) == 0
    whole, stiff, smooth = (json.loads((here / f"{name}.json").read_text()) for name in ("whole", "stiff", "smooth"))
    assert len({numbers["physics_fingerprint"] for numbers in (whole, stiff, smooth)}) == 3
    rms = [numbers["results"][0]["path"][0]["rms_mm"] for numbers in (whole, stiff, smooth)]
    assert rms[2] < rms[0]
    assert rms[1] != rms[0]


def test_a_trained_policy_runs_beside_a_law(here, capsys):
    (here / "shift.mod").write_text(PROGRAM)
    policy = ROOT / "ffgym" / "agents" / "trained" / "ppo_none" / "any" / "seed_0.npz"
    command = ("irb4600_60_205", "shift.mod", "--feedforward", "none", "ppo_elastic", str(policy))
    assert run(*command, "--out", "shift.npz", "--json", "shift.json") == 0
    results = json.loads((here / "shift.json").read_text())["results"]
    assert [result["agent"] for result in results] == ["none", "ppo_elastic", "seed_0"]
    none, elastic, nothing = (result["path"][0]["rms_mm"] for result in results)
    assert 4 * elastic < none
    assert nothing < none
    assert "ppo elastic" in capsys.readouterr().out
    one, other = (read_recording(here / f"shift_{name}.npz") for name in ("none", "ppo_elastic"))
    assert one.columns.keys() == other.columns.keys()
    assert len(one) == len(other)


def test_an_estimator_practises_a_lap_on_a_workcell_before_the_motion(here):
    assert run("workcell:drives-1", "rounded_square", "--feedforward", "elastic", "amortised", "--json", "a.json") == 0
    law, adapted = (result["path"][0]["rms_mm"] for result in json.loads((here / "a.json").read_text())["results"])
    assert 2 * adapted < law


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["one_axis", "sine", "--feedforward", "ppo_elastic"], "ppo_elastic cannot run on one_axis: A policy for 6"),
        (["one_axis", "sine", "--feedforward", "ppo_elastic", "--no-friction"], "--friction has no effect on ppo_ela"),
        (["nobody", "circles"], "Unknown robot 'nobody'"),
        (["irb4600_60_205", "nowhere"], "nowhere"),
        (["irb4600_60_205", "absent.mod"], "absent.mod"),
        (["one_axis", "circles"], "'one_axis'"),
        (["irb4600_60_205", "circles", "--feedforward"], "Name some, e.g. --feedforward none elastic"),
        (["irb4600_60_205", "circles", "--feedforward", "nobody"], "Unknown agent 'nobody'"),
        (["irb4600_60_205", "circles", "--feedforward", "absent.npz"], "absent.npz: no such file"),
        (["irb4600_60_205", "circles", "--parameters", "absent.toml"], "absent.toml"),
        (["irb4600_60_205", "circles", "--out", "c.txt"], "Unknown recording format '.txt'. Available: .csv, .npz"),
        (["irb4600_60_205", "circles", "--out", "no/c.csv"], "the folder"),
        (["irb4600_60_205", "circles", "--json", "a", "--report", "a"], "they need two files"),
        (
            ["one_axis", "table.csv", "--feedforward", "none", "--out", "table.csv"],
            "is read by this command and would be",
        ),
        (["one_axis", "table.csv", "--feedforward", "none", "--json", "table.csv"], "is read by this"),
        (["one_axis", "circles", "--report", "page.pdf"], "--report page.pdf: the name must end in .html"),
        (["irb4600_60_205", "circles", "--feedforward", "none", "--out", "a.csv", "--json", "a.csv"], "need two files"),
        (["irb4600_60_205", "circles", "--record-dt-ms", "3"], "record_dt = 0.003 s must be a multiple"),
        (["irb4600_60_205", "circles", "--sensors", "--seed", "-1"], "seed"),
        (["irb4600_60_205", "circles", "--seed", "1"], "--seed has no effect without --sensors"),
    ],
)
def test_what_cannot_run_is_one_line_and_writes_nothing(arguments, message, capsys, here):
    assert run(*arguments) == 1
    assert message in read_error(capsys)
    assert not list(here.iterdir())


def test_another_procedure_of_a_program_can_be_run(here, capsys):
    twice = PROGRAM.replace("ENDMODULE", "PROC short()\nMoveJ start, v100, fine, tool0;\n{}ENDPROC\nENDMODULE")
    (here / "two.mod").write_text(twice.format("MoveL Offs(start, 1, 0, 0), v50, fine, tool0;\n"), encoding="utf-8")
    for entry, label in (([], "Offs(start, 5, 5, 0)"), (["--entry", "short"], "Offs(start, 1, 0, 0)")):
        assert run("irb4600_60_205", "two.mod", *entry, "--feedforward", "none", "--json", "two.json") == 0
        assert json.loads((here / "two.json").read_text())["results"][0]["path"][-1]["label"] == label
    assert run("irb4600_60_205", "circles", "--entry", "short") == 1
    assert "entry = 'short' is for a program" in read_error(capsys)


def test_a_wrong_program_is_named_with_its_place(here, capsys):
    (here / "bad.mod").write_text("MODULE bad\n  PROC main()\n    MoveX p1;\n  ENDPROC\nENDMODULE\n", encoding="utf-8")
    assert run("irb4600_60_205", "bad.mod") == 1
    assert "bad.mod:3:" in read_error(capsys)


def test_a_missing_extra_is_named_only_where_a_page_is_wanted(here, monkeypatch, capsys):
    monkeypatch.setattr("ffgym.cli.outputs.is_installed", lambda name: name != "jinja2")
    assert run("irb4600_60_205", "circles", "--report", "r.html") == 1
    assert "The report needs jinja2" in read_error(capsys)


def test_recordings_of_laws_with_odd_names_get_plain_file_names():
    assert file_of_each(Path("a.csv"), ["none"]) == {"none": Path("a.csv")}
    both = file_of_each(Path("a.csv"), ["none", "my law/2"])
    assert both == {"none": Path("a_none.csv"), "my law/2": Path("a_my_law_2.csv")}
    with pytest.raises(FFGymError, match="would be written to the same file"):
        file_of_each(Path("a.csv"), ["my law", "my/law"])


def test_every_option_is_on_the_page_and_its_commands_parse():
    page = (ROOT / "docs" / "simulate.md").read_text(encoding="utf-8")
    for option in ("entry", "feedforward", "parameters", "sensors", "seed", "record-dt-ms", "out", "report", "json"):
        assert f"`--{option}" in page
    for part in ("flexible", "friction", "gravity", "springs"):
        assert f"`--no-{part}`" in page
    assert len(re.findall(r"^ffgym simulate ", page, flags=re.M)) == 2
    assert load_robot("irb4600_60_205").tool is not None
