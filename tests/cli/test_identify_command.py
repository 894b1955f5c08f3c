"""`ffgym identify`: from logs to a parameter file that every agent and plant accepts."""

import json
import re

import numpy as np
import pytest

from ffgym.cli.main import main
from ffgym.recordings import read_recording, write_recording
from ffgym.robot import RigidArm, load_robot, with_parameters
from ffgym.simulation import Resolver, SimulatedRig
from ffgym.simulation.protocols import plan_session, record
from ffgym.simulation.protocols.one_by_one import SpeedLadder, Table61


@pytest.fixture(scope="module")
def logs(one_axis, tmp_path_factory):
    """A short ladder and four sines of one axis, as files by the name of their motion."""
    arm, folder = RigidArm(one_axis), tmp_path_factory.mktemp("logs")
    speeds = (0.03, 0.08, 0.15, 0.25, 0.6, 3.0, 9.0)
    plan = plan_session(arm, [SpeedLadder(speeds=speeds, longest=2.0), Table61(records=(2, 4, 9, 13), least=2.0)])
    rig = SimulatedRig(arm=arm, sensors=(Resolver(bits=16),))
    return {
        recording.header.segment.rsplit(".", 1)[-1]: write(folder, recording)
        for recording in record(plan, rig, record_dt=1e-3)
    }


def write(folder, recording):
    path = folder / f"{recording.header.segment}.npz"
    write_recording(recording, path)
    return str(path)


@pytest.fixture(scope="module")
def results(logs, tmp_path_factory):
    """Paths of the parameter file, the numbers and the page."""
    folder = tmp_path_factory.mktemp("results")
    paths = {name: folder / name for name in ("parameters.toml", "numbers.json", "page.html")}
    used = ["identify", *logs.values(), "--robot", "one_axis", "--validate", logs["record_13"], "--resamples", "40"]
    written = [
        argument
        for option, name in (("--out", "parameters.toml"), ("--json", "numbers.json"), ("--report", "page.html"))
        for argument in (option, str(paths[name]))
    ]
    assert main([*used, *written]) == 0
    return paths


def test_the_parameter_file_is_the_robot_with_its_friction(results, one_axis):
    robot = load_robot(results["parameters.toml"])
    for name, tolerance in (("coulomb", 0.02), ("static", 0.02), ("viscous", 0.02), ("bristle_stiffness", 0.1)):
        np.testing.assert_allclose(getattr(robot.friction, name), getattr(one_axis.friction, name), rtol=tolerance)
    quantity = with_parameters(one_axis, results["parameters.toml"]).quantities["friction.coulomb"]
    assert quantity.origin == ("fitted",)
    assert quantity.source.startswith("ffgym identify from speed_ladder.j1, ")
    np.testing.assert_array_equal(quantity.prior, one_axis.friction.coulomb)
    assert quantity.interval[0, 0] < robot.friction.coulomb[0] < quantity.interval[0, 1]


def test_numbers_say_what_they_rest_on(results):
    numbers = json.loads(results["numbers.json"].read_text())
    assert numbers["command"] == "ffgym identify"
    assert numbers["seed"] == 0
    assert numbers["validated_on"] == ["table_6_1.j1.record_13"]
    assert "table_6_1.j1.record_13" not in numbers["logs"]
    assert [entry["status"] for entry in numbers["joints"][0]["parameters"]] == ["identified"] * 6
    (validation,) = numbers["validation"]
    assert validation["share_after"] > 0.99


def test_the_page_has_the_pictures(results):
    page = results["page.html"].read_text()
    for words in ("Friction at constant speed", "Records that were used", "Records that were not used", "identified"):
        assert words in page
    assert page.count("data:image/svg+xml") == 3


def test_what_is_printed_has_old_and_new_values_and_what_logs_do_not_tell(logs, capsys):
    assert main(["identify", logs["record_04"], "--robot", "one_axis", "--resamples", "20"]) == 0
    text = capsys.readouterr().out
    assert "f_c, f_s, f_v, v_s: too few constant speeds" in text
    assert max(map(len, text.splitlines())) <= 120
    line = next(line for line in text.splitlines() if "f_c" in line)
    assert "0.5367" in line
    assert line.rstrip().endswith("not excited")


MAP = """
[log]
robot = "one_axis"
position_side = "motor"
torque_semantics = "motor_side"
hold = "linear"
filters = []
[file]
decimal = ","
[columns.timestamp]
source = "Zeit"
unit = "s"
[columns."motor.position"]
source = ["Winkel"]
unit = "rad"
[columns."motor.effort"]
source = ["Moment"]
unit = "N m"
"""


@pytest.fixture
def foreign(logs, tmp_path, monkeypatch):
    """The ladder as the text file of another tool, beside its column map."""
    monkeypatch.chdir(tmp_path)
    ladder = read_recording(logs["j1"])
    rows = np.column_stack([ladder.t, ladder["motor.position.j1"], ladder["motor.effort.j1"]]).tolist()
    lines = ["Zeit;Winkel;Moment", *(";".join(map(repr, row)).replace(".", ",") for row in rows)]
    (tmp_path / "ladder.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    (tmp_path / "map.toml").write_text(MAP, encoding="utf-8")
    return tmp_path


def friction_in(path):
    return vars(load_robot(path).friction)


def test_logs_of_other_tools_need_a_column_map_and_no_other_step(logs, foreign, capsys):
    quick = ["--robot", "one_axis", "--resamples", "2"]
    assert main(["identify", "ladder.csv", "--columns", "map.toml", *quick, "--out", "theirs.toml"]) == 0
    assert main(["identify", logs["j1"], *quick, "--out", "ours.toml"]) == 0
    theirs, ours = friction_in("theirs.toml"), friction_in("ours.toml")
    assert all(np.array_equal(theirs[name], ours[name]) for name in ours)
    capsys.readouterr()
    for arguments, message in [
        (
            ["ladder.csv", "--columns", "emps", "--out", "x.toml"],
            "emps.toml is for robot 'ball_screw', not for 'one_axis'",
        ),
        (["ladder.csv", "--columns", "map.toml", "--out", "map.toml"], "--out map.toml: is read by this command"),
        (["ladder.csv", "--out", "x.toml"], "column map"),
    ]:
        assert main(["identify", *arguments, *quick]) == 1
        (line,) = capsys.readouterr().err.splitlines()
        assert message in line


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["{ladder}", "--robot", "irb4600_60_205"], "insufficient"),
        (["{ladder}", "--robot", "one_axis", "--validate", "{ladder}"], "none is left to identify from"),
        (["{ladder}", "--robot", "one_axis", "--out", "parameters.json"], r"must end in \.toml"),
        (["absent.npz", "--robot", "one_axis"], "absent.npz"),
        (["{ladder}", "--robot", "one_axis", "--joints", "j9"], "Unknown joint 'j9'"),
        (["{ladder}", "--robot", "one_axis", "--cutoff-hz", "600"], "must lie below 500 Hz"),
        (["{ladder}", "--robot", "one_axis", "--resamples", "1"], "resamples"),
    ],
)
def test_what_cannot_be_done_is_one_line(logs, capsys, arguments, message):
    code = main(["identify", *(argument.format(ladder=logs["j1"]) for argument in arguments)])
    error = capsys.readouterr().err
    assert code == 1
    assert len(error.splitlines()) == 1

    assert re.search(message, error), error


def test_nothing_is_written_where_logs_tell_nothing(logs, tmp_path, capsys):
    out = tmp_path / "parameters.toml"
    calm = tmp_path / "calm.npz"

    write_recording(read_recording(logs["record_04"]).slice(0.0, 1.0), calm)
    arguments = ["identify", str(calm), "--robot", "one_axis", "--out", str(out), "--unchecked", "--resamples", "20"]
    assert main(arguments) == 1
    assert "no parameter can be identified from these logs" in capsys.readouterr().err
    assert not out.exists()
