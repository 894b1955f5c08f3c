"""`ffgym log`: columns and convert, as a user runs them."""

import json

import numpy as np
import pytest

from ffgym.cli.main import main
from ffgym.recordings import read_recording
from tests.cli.errors import read_error

T = 0.004 * np.arange(50)
ROWS = np.column_stack([1000 * T, np.degrees(np.sin(T)), 2 * np.cos(T)])

MAP = """
[log]
robot = "one_axis"
position_side = "link"
torque_semantics = "motor_side"
hold = "sampled"
[columns.timestamp]
source = "time [ms]"
unit = "ms"
[columns."motor.position"]
source = "axis1"
unit = "deg"
[columns."motor.effort"]
source = "torque1"
unit = "N m"
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Folder with the log of another tool, in which commands run."""
    monkeypatch.chdir(tmp_path)
    rows = "".join(";".join(map(repr, row)).replace(".", ",") + "\n" for row in ROWS.tolist())
    (tmp_path / "trace.csv").write_text(f"time [ms];axis1;torque1\n{rows}", encoding="utf-8")
    (tmp_path / "map.toml").write_text(MAP + '[file]\ndecimal = ","\n', encoding="utf-8")
    return tmp_path


def refusal(capsys, *arguments):
    """The one line with which a command ends that cannot be run."""
    assert main(["log", *arguments]) == 1
    return read_error(capsys)


def test_from_an_unknown_file_to_a_recording(folder, capsys):
    assert main(["log", "columns", "trace.csv", "--decimal", ",", "--out", "draft.toml", "--json", "held.json"]) == 0
    said = capsys.readouterr().out
    assert "time [ms]  (50,) float64, 0 to 196, increases by 4" in said
    assert "next: fill in every '?', then ffgym log convert trace.csv --columns draft.toml" in said
    assert [entry["name"] for entry in json.loads((folder / "held.json").read_text())["arrays"]] == [
        "time [ms]", "axis1", "torque1"
    ]  # fmt: skip
    assert "log.robot = '?' is still to be filled in" in refusal(
        capsys, "convert", "trace.csv", "--columns", "draft.toml", "--out", "run.npz"
    )
    draft = (folder / "draft.toml").read_text(encoding="utf-8")
    draft = draft[: draft.index('[columns."reference.position"]')]
    for answer in ("one_axis", "link", "motor_side", "sampled", "ms", "axis{number}", "deg", "torque{number}", "N m"):
        draft = draft.replace('= "?"', f'= "{answer}"', 1)
    (folder / "draft.toml").write_text(draft, encoding="utf-8")
    assert (
        main(["log", "convert", "trace.csv", "--columns", "draft.toml", "--out", "run.npz", "--json", "run.json"]) == 0
    )
    assert "run.npz: trace, robot one_axis, 50 rows, 0.196 s at 250 Hz" in capsys.readouterr().out
    recording = read_recording("run.npz")
    np.testing.assert_allclose(recording.t, T)
    np.testing.assert_allclose(recording.joint_array("motor.position")[:, 0], np.sin(T))
    np.testing.assert_array_equal(recording.joint_array("motor.effort")[:, 0], ROWS[:, 2])
    numbers = json.loads((folder / "run.json").read_text())
    assert numbers["recordings"][0]["rows"] == 50
    assert numbers["versions"]["ffgym"]


def test_each_motion_has_a_file_of_its_own(folder, capsys):
    np.savez("stack.npz", t=T, q=np.sin(T) + np.arange(3)[:, None])
    motions = '[columns."motor.position"]\nsource = "q"\naxes = ["motion", "time"]\nunit = "rad"\n'
    head = MAP[: MAP.index("[columns.")]
    clock = '[columns.timestamp]\nsource = "t"\nunit = "s"\n'
    (folder / "stack.toml").write_text(head.replace('robot = "one_axis"\n', "") + clock + motions, encoding="utf-8")
    arguments = ["log", "convert", "stack.npz", "--columns", "stack.toml", "--robot", "one_axis", "--out", "m.npz"]
    assert main(arguments) == 0
    assert len(capsys.readouterr().out.splitlines()) == 3
    for i in range(3):
        assert read_recording(f"m_stack_{i}.npz").joint_array("motor.position")[0, 0] == i


def test_what_cannot_be_run_is_one_line_and_writes_nothing(folder, capsys):
    before = sorted(folder.iterdir())
    convert = ["convert", "trace.csv", "--columns"]
    assert "Unknown recording format '.xls'" in refusal(capsys, *convert, "map.toml", "--out", "run.xls")
    assert "would be lost" in refusal(capsys, *convert, "map.toml", "--out", "trace.csv")
    assert "Unknown column map 'mine'" in refusal(capsys, *convert, "mine", "--out", "run.npz")
    assert "does not exist" in refusal(capsys, *convert, "map.toml", "--out", "nowhere/run.npz")
    assert "is for robot 'one_axis', not for 'two_link'" in refusal(
        capsys, *convert, "map.toml", "--out", "run.npz", "--robot", "two_link"
    )
    assert "may hold your work" in refusal(capsys, "columns", "trace.csv", "--out", "map.toml")
    assert "must end in .toml" in refusal(capsys, "columns", "trace.csv", "--out", "map.txt")
    assert "no such file" in refusal(capsys, "columns", "absent.npz")
    assert "absent: no such file or folder" in refusal(capsys, "columns", "absent")
    assert "absent: no such file or folder" in refusal(
        capsys, "convert", "absent", "--columns", "map.toml", "--out", "x.npz"
    )
    assert sorted(folder.iterdir()) == before
