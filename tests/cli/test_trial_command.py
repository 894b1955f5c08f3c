"""`ffgym trial`: plan, rehearse, read, and one line for whatever cannot be done."""

import contextlib
import io
import json
import re
from pathlib import Path

import numpy as np
import pytest

from ffgym.cli.main import main
from ffgym.core.errors import FFGymError
from ffgym.recordings import read_recording
from tests.cli.errors import read_error

PLAN = ["trial", "plan", "one_axis", "sine.toml", "--runs", "12", "--seed", "3", "--warm-up", "1", "--out", "trial"]
SINE = """
[[part]]
kind = "sine"
frequency = 2.0
amplitude = 0.002
duration = 1.0
"""

MAP = """
[log]
robot = "one_axis"
position_side = "link"

[columns]
timestamp = { source = "time_ms", unit = "ms" }
"motor.position" = { source = ["actual"], unit = "rad" }
"reference.position" = { source = ["target"], unit = "rad" }
"""


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """Folder with a plan of twelve runs of one axis, and their logs with dynamic LuGre compensation."""
    folder = tmp_path_factory.mktemp("trial")
    (folder / "sine.toml").write_text(SINE)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert main([*PLAN, "--json", "plan.json"]) == 0
        rehearse = ["trial", "rehearse", "trial", "--machine", "one_axis", "--feedforward", "lugre_dynamic"]
        assert main([*rehearse, "--seed", "5", "--json", "rehearsal.json"]) == 0
        (folder / "printed.txt").write_text(read_out("trial/logs", "--report", "gain.html", "--json", "gain.json"))
    return folder


def read_out(*arguments):
    """Output of `ffgym trial read` of the plan."""
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        assert main(["trial", "read", "trial", *arguments]) == 0
    return printed.getvalue()


@pytest.fixture
def inside(place, monkeypatch):
    """The same, as the present folder."""
    monkeypatch.chdir(place)
    return place


def test_a_plan_has_its_runs_as_json_as_csv_and_on_a_page(inside):
    plan = json.loads(Path("trial/plan.json").read_text())
    numbers = json.loads(Path("plan.json").read_text())
    assert plan["runs"] == numbers["runs"]
    assert len(plan["runs"]) == 13
    assert {"versions", "command_line", "inputs", "assumed"} <= set(numbers)
    assert numbers["assumed"]["pairs_needed"] == 6
    page = Path("trial/plan.html").read_text()
    for run in plan["runs"]:
        assert run["log"] in page
    assert plan["digest"][:12] in page
    assert "one log. The first lap" not in page


def test_a_rehearsed_trial_is_read_with_its_gain_page_and_numbers(inside):
    (line,) = [line for line in Path("printed.txt").read_text().splitlines() if line.startswith("sine gains")]
    numbers = json.loads(Path("gain.json").read_text())
    (gain,) = numbers["gains"]
    assert gain["claim"] == "gain"
    assert f"p = {gain['p']:.2g}" in line
    assert gain["low"] < gain["gain"] < gain["high"]
    assert (numbers["measure"], numbers["unit"]) == ("motors", "mrad")
    assert len(numbers["inputs"]) == 14  # logs and the plan
    assert numbers["plan"] == json.loads(Path("trial/plan.json").read_text())["digest"]
    page = Path("gain.html").read_text()
    assert page.count("<figure") == 2
    assert line.removeprefix("sine ") in re.sub(r"<[^>]+>", "", page)


def test_a_pilot_says_how_many_pairs_the_next_trial_needs(inside, capsys):
    pilot = json.loads(Path("gain.json").read_text())["gains"][0]["spread"]
    assert main([*PLAN[:-1], "next", "--pilot", "gain.json", "--gain-percent", "1"]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "gain.json leaves open" in printed
    assert "13 runs: 6 pairs of sine; 1 to warm up" in printed
    assert "with a probability of 90 %" in printed
    assert json.loads(Path("next/plan.json").read_text())["origin"]["assumed"]["spread"] > pilot


def test_a_log_that_cannot_be_read_and_one_that_is_missing_cost_their_pairs(inside, capsys, tmp_path):
    logs = tmp_path / "logs"
    logs.mkdir()
    files = sorted(Path("trial/logs").iterdir())
    for file in files[:-1]:
        (logs / file.name).write_bytes(file.read_bytes())
    broken = logs / files[3].name
    broken.write_bytes(b"no recording")
    assert main(["trial", "read", "trial", str(logs)]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert f"note: not read: {broken}" in printed
    assert "Run 4" in printed
    assert "Run 13" in printed
    assert "8 of 12 runs count" in printed or "10 of 12 runs count" in printed


def test_logs_of_another_tool_are_read_by_a_column_map(inside, tmp_path):
    logs = tmp_path / "traces"
    logs.mkdir()
    for file in sorted(Path("trial/logs").iterdir()):
        recording = read_recording(file)
        ratio = recording.header.gear_ratio[0]
        columns = [
            recording.t * 1e3,
            recording["motor.position.j1"] / ratio,
            recording["reference.position.j1"] / ratio,
        ]
        rows = "\n".join(",".join(f"{value:.9f}" for value in row) for row in np.stack(columns, axis=1))
        (logs / f"{file.stem}.txt").write_text(f"time_ms,actual,target\n{rows}\n")
    (tmp_path / "map.toml").write_text(MAP)
    by_map, own = read_out(str(logs), "--columns", str(tmp_path / "map.toml")), Path("printed.txt").read_text()
    assert by_map.split("(")[0] == own.split("(")[0]
    assert "no command in the logs differs" in " ".join(by_map.split())  # as torque is not among them


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["plan", "one_axis", "sine.toml", "--runs", "7", "--out", "new"], "--runs 7 must be even"),
        (["plan", "one_axis", "sine.toml"], "Say where the plan goes"),
        (["plan", "one_axis", "sine.toml", "--out", "trial"], "exists already"),
        (["plan", "one_axis", "sine.toml", "sine.toml", "--out", "new"], "different names"),
        (["plan", "one_axis", "nowhere.toml", "--out", "new"], "cannot be read"),
        (["plan", "one_axis", "sine.toml", "--out", "new", "--gain-percent", "0"], "--gain-percent = 0"),
        (
            ["plan", "one_axis", "sine.toml", "--out", "new", "--spread-percent", "1e-308"],
            "spread of the ratios of pairs",
        ),
        (["plan", "one_axis", "sine.toml", "--out", "new", "--pilot", "plan.json"], "no gains of a trial"),
        (
            ["plan", "one_axis", "sine.toml", "--out", "new", "--entry", "weld"],
            "--entry weld has no effect: sine.toml is",
        ),
        (
            ["plan", "one_axis", "sine.toml", "--out", "new", "--pilot", "x.json", "--spread-percent", "3"],
            "leave one of them out",
        ),
        (["rehearse", "trial/programs", "--machine", "one_axis"], "holds no plan.json"),
        (["rehearse", "trial", "--machine", "one_axis"], "exists already"),
        (["rehearse", "trial", "--machine", "two_link", "--out", "new"], "other joints than one_axis"),
        (["rehearse", "trial", "--machine", "one_axis", "--out", "new", "--json", "trial/plan.json"], "would be lost"),
        (["read", "trial"], "There are no logs to read"),
        (["read", "trial", "sine.toml"], "None of the logs can be read"),
        (["read", "trial", "trial/logs", "--without", "99"], "Run 99 to leave out is not in the plan"),
        (["read", "trial", "trial/logs", "--accept", "everything"], "Unknown check"),
    ],
)
def test_what_cannot_be_done_is_one_line_and_nothing_is_written(arguments, message, inside, capsys):
    before = sorted(inside.rglob("*"))
    assert main(["trial", *arguments]) == 1
    assert message in read_error(capsys)
    assert sorted(inside.rglob("*")) == before


def test_a_program_of_several_modules_is_planned_from_the_procedure_that_is_named(inside, monkeypatch):
    given = []

    def read(arm, source, *, entry):
        given.append((source, entry))
        raise FFGymError("seen")

    monkeypatch.setattr("ffgym.cli.trial.load_motion", read)
    assert main(["trial", "plan", "one_axis", "cell.pgf", "--out", "new", "--entry", "weld"]) == 1
    assert given == [("cell.pgf", "weld")]
