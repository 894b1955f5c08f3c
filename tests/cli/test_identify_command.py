"""`ffgym identify`: from logs to a parameter file that every agent and plant accepts."""

import json
import re

import numpy as np
import pytest

from ffgym.cli.main import main
from ffgym.recordings import Recording, read_recording, write_recording
from ffgym.robot import RigidArm, load_robot, with_parameters
from ffgym.simulation import Machine, Resolver, SimulatedRig
from ffgym.simulation.protocols import plan_session, record
from ffgym.simulation.protocols.one_by_one import SpeedLadder, Table61
from ffgym.simulation.sensors import sensors_of
from tests.cli.errors import read_error


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
        assert message in read_error(capsys)


def test_a_log_that_is_given_twice_counts_once_and_is_told(logs, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    quick = ["--robot", "one_axis", "--resamples", "2"]
    assert main(["identify", logs["j1"], *quick, "--out", "once.toml"]) == 0
    assert "counts once" not in capsys.readouterr().out
    assert main(["identify", logs["j1"], logs["j1"], *quick, "--out", "twice.toml"]) == 0
    assert "is given twice; it counts once." in capsys.readouterr().out
    once, twice = friction_in("once.toml"), friction_in("twice.toml")
    assert all(np.array_equal(once[name], twice[name]) for name in once)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["{ladder}", "--robot", "irb4600_60_205"], "insufficient"),
        (["{ladder}", "--robot", "one_axis", "--validate", "{ladder}"], "none is left to identify from"),
        (["{ladder}", "--robot", "one_axis", "--out", "parameters.json"], r"must end in \.toml"),
        (["absent.npz", "--robot", "one_axis"], "absent.npz"),
        (["absent", "--robot", "one_axis"], "absent: no such file or folder"),
        (["{ladder}", "--robot", "one_axis", "--joints", "j9"], "Unknown joint 'j9'"),
        (["{ladder}", "--robot", "one_axis", "--cutoff-hz", "600"], "must lie below 500 Hz"),
        (["{ladder}", "--robot", "one_axis", "--resamples", "1"], "resamples"),
        (["{ladder}", "--robot", "one_axis", "--resamples", "1000000000"], r"must be in \[2, 100000\]"),
        (["{ladder}", "--robot", "one_axis", "--cutoff-hz", "1e-308"], "--cutoff-hz = 1e-308 Hz is out of range"),
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


@pytest.fixture(scope="module")
def elastic_log(tmp_path_factory):
    """A ladder of an elastic joint with a tracker, half of whose friction is on the arm, as a file."""
    arm = RigidArm(load_robot("two_link"))
    machine = Machine(robot=arm.robot.with_arm_share([0.5, 0.0]))
    ladder = SpeedLadder(joints=["shoulder"], speeds=(0.2, 1.0, 4.0), longest=2.0)
    rig = SimulatedRig(arm=arm, machine=machine, sensors=sensors_of(arm.robot))
    (recording,) = record(plan_session(arm, [ladder]), rig, record_dt=2e-3)
    return recording


def test_the_share_of_friction_on_the_arm_is_printed_written_and_in_the_numbers(elastic_log, tmp_path, capsys):
    log, out, numbers = write(tmp_path, elastic_log), tmp_path / "parameters.toml", tmp_path / "numbers.json"
    options = ["--joints", "shoulder", "--stiffness-spread", "0.05", "--resamples", "40"]
    command = ["identify", log, "--robot", "two_link", *options, "--out", str(out), "--json", str(numbers)]
    assert main(command) == 0
    line = next(line for line in capsys.readouterr().out.splitlines() if re.match(r"shoulder +s +\|", line))
    assert line.rstrip().endswith("identified")
    shoulder, elbow = (joint["arm_share"] for joint in json.loads(numbers.read_text())["joints"])
    assert elbow is None
    assert shoulder["fit"]["sensor"] == "tracker"
    assert shoulder["interval"][0] <= 0.5 <= shoulder["interval"][1]
    np.testing.assert_array_equal(load_robot(out).arm_share, [shoulder["value"], 0.0])


def test_a_log_without_tracker_says_that_the_share_cannot_be_told(elastic_log, tmp_path, capsys):
    columns = {name: values for name, values in elastic_log.columns.items() if not name.startswith("tcp.")}
    log = write(tmp_path, Recording(columns=columns, header=elastic_log.header))
    assert main(["identify", log, "--robot", "two_link", "--joints", "shoulder", "--resamples", "10"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert "note: shoulder: share of friction on the arm: cannot be told without a tracker (tcp.position)" in text
    assert "Record slow_triangles or speed_ladder with one" in text
