"""`ffgym diagnose` on the command line: what it refuses, what it writes, and what it names on logs of one axis."""

import errno
import html
import json
import os
import re
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ffgym.cli.diagnose import next_step
from ffgym.cli.log_options import Diagnose
from ffgym.cli.main import COMMANDS, main
from ffgym.diagnosis import Diagnosis
from ffgym.diagnosis.diagnosis_file import read_diagnosis
from ffgym.diagnosis.result import SeparatingMotion
from ffgym.effects import EFFECTS
from ffgym.recordings import Recording, read_recording, write_recording
from ffgym.report.diagnosis import simulation_note
from ffgym.robot import load_robot
from ffgym.simulation.plant import Machine, load_machine, save_machine
from tests.cli.errors import read_error

DATA = Path(__file__).parents[2] / "ffgym" / "robot" / "data"

SHORT = """
[[step]]
protocol = "excitation"
count = 2
base = 0.2
periods = 1
"""
"""Protocol file: two short motions, one of which can check the other."""


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    """Recordings of an axis whose motor cogs, at 4 ms."""
    folder = tmp_path_factory.mktemp("cogging")
    robot = load_robot("one_axis")
    hidden = EFFECTS["cogging"].on(robot, "j1", amplitude=0.05, cycles=6.0, phase=0.4)
    machine = save_machine(Machine(robot=robot, effects=(hidden,)), folder / "cell.toml", title="cell", source="a test")
    (folder / "short.toml").write_text(SHORT, encoding="utf-8")
    session = [str(machine), str(folder / "short.toml"), "--out", str(folder / "logs"), "--record-dt-ms", "4"]
    assert main(["record", *session, "--threads", "1"]) == 0
    return folder / "logs"


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["logs"], "--robot ROBOT"),
        (["--fit"], "--robot ROBOT"),
        (["nowhere", "--robot", "one_axis"], "nowhere: no such file or folder"),
        (["logs", "--robot", "nobody"], "Unknown robot 'nobody'"),
        (["logs", "--robot", "workcell:thesis"], "has no description"),
        (["--columns", "map.toml"], "--columns has no effect on the example logs"),
        (["--calibration", "2"], "--calibration = 2.0 is out of range"),
        (["--seed", "-1"], "--seed"),
        (["--accept", "cores"], "Unknown check 'cores'"),
        (["--most-causes", "9"], "--most-causes = 9"),
        (["--out", "file"], "cannot be made a folder"),
        (["--json", "numbers.txt"], "must end in .json"),
    ],
)
def test_what_cannot_be_diagnosed_is_refused_in_one_line(arguments, says, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("", encoding="utf-8")
    assert main(["diagnose", *arguments]) == 1
    assert says in read_error(capsys)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda r: r.slice(end=0.02), "rows; there are 5"),
        (lambda r: r.slice(end=0.2), "too short"),
        (lambda r: r.slice(end=1.5), "too short"),
        (lambda r: Recording(r.columns, replace(r.header, hold="unspecified")), "does not say when its torque acts"),
    ],
    ids=["five rows", "fifty rows", "a second", "when torque acts"],
)
def test_a_log_that_cannot_be_used_is_one_line_and_leaves_no_folder(logs, tmp_path, capsys, change, says):
    write_recording(change(read_recording(next(logs.glob("*.npz")))), tmp_path / "log.npz")
    arguments = ["diagnose", str(tmp_path / "log.npz"), "--robot", "one_axis", "--out", str(tmp_path / "new" / "out")]
    assert main(arguments) == 1
    assert says in read_error(capsys)
    assert [path.name for path in tmp_path.iterdir()] == ["log.npz"]


@pytest.mark.parametrize("raised", [KeyboardInterrupt(), OSError(errno.ENOSPC, "No space left on device")])
def test_whatever_stops_a_diagnosis_no_file_of_it_is_half_written(logs, tmp_path, monkeypatch, capsys, raised):
    log = sorted(logs.glob("*.npz"))[0]
    faulty = Recording(
        (recording := read_recording(log)).columns, replace(recording.header, torque_semantics="unspecified")
    )
    write_recording(faulty, tmp_path / "log.npz")

    def stop(descriptor):
        raise raised

    monkeypatch.setattr(os, "fsync", stop)
    out = tmp_path / "out"
    code = main(["diagnose", str(tmp_path / "log.npz"), "--robot", "one_axis", "--out", str(out)])
    told = capsys.readouterr()
    assert told.out == ""
    (line,) = told.err.splitlines()
    assert (code, "interrupted" in line) == (130, True) if isinstance(raised, KeyboardInterrupt) else (1, False)
    assert not out.exists()


def test_logs_to_validate_with_are_looked_at_before_long_work(logs, tmp_path, capsys):
    whole = read_recording(next(logs.glob("*.npz")))
    columns = {name: values for name, values in whole.columns.items() if not name.startswith("motor.effort")}
    write_recording(Recording(columns, whole.header), tmp_path / "other.npz")
    assert main(["diagnose", str(logs), "--robot", "one_axis", "--validate", str(tmp_path / "other.npz")]) == 1
    assert "motor.effort" in read_error(capsys)  # no preview before it


def test_the_model_that_is_read_is_not_written_over(logs, tmp_path, capsys):
    machine = save_machine(
        Machine(robot=load_robot("one_axis")), tmp_path / "extended.toml", title="as built", source="a test"
    )
    before = machine.read_bytes()
    assert main(["diagnose", str(logs), "--robot", str(machine), "--out", str(tmp_path)]) == 1
    assert "would be lost" in capsys.readouterr().err
    assert machine.read_bytes() == before


def test_a_hidden_cause_is_named_and_written_with_its_machine(logs, tmp_path, capsys):
    out, numbers = tmp_path / "found", tmp_path / "numbers.json"
    out.mkdir()
    (out / "next.toml").write_text("of an earlier diagnosis", encoding="utf-8")
    assert main(["diagnose", str(logs), "--robot", "one_axis", "--out", str(out), "--json", str(numbers)]) == 0
    told = capsys.readouterr()
    assert told.out.startswith("named: ")
    assert "cogging of j1" in told.out
    assert "not judgeable: joint stiffness" in told.out
    assert f"--robot {out / 'extended.toml'}" in told.out
    assert told.err.startswith("Preview")
    assert sorted(path.name for path in out.iterdir()) == ["diagnosis.json", "extended.toml", "report.html"]
    effects = {effect.name: effect for effect in load_machine(out / "extended.toml").effects}
    assert set(effects) <= {"cogging", "torque_offset"}  # a zero point is a number, fitted beside the cause
    assert effects["cogging"].amplitude[0] == pytest.approx(0.05, rel=0.1)
    assert numbers.read_bytes() == (out / "diagnosis.json").read_bytes()
    assert read_diagnosis(numbers).provenance["command"] == "ffgym diagnose"
    assert json.loads(numbers.read_text(encoding="utf-8"))["provenance"]["config"]["robot"] == "one_axis"


@pytest.mark.slow
def test_the_extended_model_explains_the_logs_and_the_same_input_gives_the_same_bytes(logs, tmp_path, capsys):
    texts = []
    for name in ("first", "second"):
        out = tmp_path / name
        assert main(["diagnose", str(logs), "--robot", "one_axis", "--out", str(out), "--validate", str(logs)]) == 0
        found = {path.name: path.read_text(encoding="utf-8") for path in sorted(out.iterdir())}
        # the page alone has the time at which it was written, and commands that name the folder
        found["report.html"] = re.sub(r"\d{4}-\d\d-\d\d \d\d:\d\d UTC", "", found["report.html"]).replace(str(out), "")
        texts.append(found)
    assert texts[0] == texts[1]
    assert "closed loop, RMS of" in capsys.readouterr().out
    assert main(["diagnose", str(logs), "--robot", str(tmp_path / "first" / "extended.toml")]) == 0
    assert capsys.readouterr().out.startswith("none: ")


def test_logs_of_another_robot_are_insufficient_and_no_error(logs, tmp_path, capsys):
    numbers = tmp_path / "numbers.json"
    assert main(["diagnose", str(logs), "--robot", "two_link", "--json", str(numbers)]) == 0
    assert capsys.readouterr().out.startswith("insufficient: ")
    assert read_diagnosis(numbers).causes == ()


def test_a_log_that_is_refused_is_left_out_and_told_and_uneven_rows_are_no_reason(logs, tmp_path):
    """Of three logs one is in degrees; the clock of another is uneven."""
    first, second, *_ = (read_recording(file) for file in sorted(logs.glob("*.npz")))
    degrees = first.with_columns({"motor.velocity.j1": np.degrees(first["motor.velocity.j1"])})
    uneven = second.with_columns({"timestamp": second.t + 2e-4 * np.sin(100 * second.t)})
    for name, recording in (("a", first), ("b", uneven), ("c", degrees.rename("degrees"))):
        write_recording(recording, tmp_path / f"{name}.npz")
    numbers = tmp_path / "numbers.json"
    files = [str(tmp_path / f"{name}.npz") for name in "abc"]
    assert main(["diagnose", *files, "--robot", "one_axis", "--json", str(numbers), "--most-causes", "1"]) == 0
    found = read_diagnosis(numbers)
    assert found.verdict != "insufficient"
    assert "degrees" not in found.motions
    assert len(found.motions) == 2
    assert found.quality[0].startswith("degrees was left out: motor.velocity.j1 is 57.2")
    assert any("even clock" in text or "even times" in text for text in found.quality)


def test_motions_of_the_same_name_are_told_apart_by_their_folders(logs):
    from ffgym.cli.diagnose_inputs import logs_from

    (first, *_) = sorted(logs.glob("*.npz"))
    names = [recording.header.segment for recording in logs_from((logs, first), None, load_robot("one_axis"))]
    assert len(set(names)) == 3
    assert names[0].startswith("logs/")
    assert names[2].startswith(f"{first.stem}/")


VERDICTS = ("none", "named", "partly", "ambiguous", "unknown", "wiring", "insufficient")


@pytest.mark.parametrize("verdict", VERDICTS)
@pytest.mark.parametrize("robot", [None, "one_axis", "my robots/axis.toml"])
@pytest.mark.parametrize("out", [None, Path("an out")])
def test_every_command_of_the_next_step_parses_as_it_is_printed(verdict, robot, out, monkeypatch):
    for command in COMMANDS.values():
        monkeypatch.setattr(f"ffgym.cli.{command.work.replace(':', '.')}", lambda config: None)
    logs = () if robot is None else (Path("my logs"),)
    config = Diagnose(logs=logs, robot=robot, out=out, accept=("coarse",) if logs else ())
    found = Diagnosis(verdict=verdict, sentence="", robot="one_axis", motions=(), gains=True)
    motion = SeparatingMotion(between=("a", "b"), protocol="holds", toml="", expected=1.0)
    steps = [next_step(config, found), next_step(config, replace(found, separating_motion=motion), period=0.004)]
    for step in steps:
        assert step.commands
        for command in step.commands:
            program, *arguments = shlex.split(command)
            assert program == "ffgym"
            assert main(arguments) == 0


@pytest.mark.parametrize("verdict", VERDICTS)
def test_a_next_step_that_records_warns_that_its_logs_are_simulated(verdict):
    """They must not be mixed with those of the machine; a step that lists protocols records nothing."""
    found = Diagnosis(verdict=verdict, sentence="", robot="one_axis", motions=(), gains=True)
    motion = SeparatingMotion(between=("a", "b"), protocol="holds", toml="", expected=1.0)
    for diagnosis in (found, replace(found, separating_motion=motion)):
        step = next_step(Diagnose(), diagnosis)
        records = any(command.startswith("ffgym record ") and "--list" not in command for command in step.commands)
        assert ("on the model that it is given, not on the machine" in " ".join(step.text.split())) == records
        assert bool(simulation_note(step.commands)) == records


@pytest.mark.parametrize("is_ambiguous", [True, False])
def test_two_diagnoses_in_one_folder_print_commands_that_write_to_folders_of_their_own(is_ambiguous):
    motion = SeparatingMotion(between=("a", "b"), protocol="holds", toml="", expected=1.0)
    found = Diagnosis(verdict="named", sentence="", robot="one_axis", motions=(), gains=True)
    found = replace(found, separating_motion=motion if is_ambiguous else None)
    written = [
        {words[words.index("--out") + 1] for command in step.commands if "--out" in (words := shlex.split(command))}
        for step in (next_step(Diagnose(robot="one_axis", out=Path(name)), found) for name in ("one", "a/two"))
    ]
    assert all(written)
    assert not written[0] & written[1]


def test_commands_that_are_printed_run_for_a_robot_that_is_a_file(logs, tmp_path, monkeypatch, capsys):
    """The description lies beside the logs; what tells rivals apart is a short protocol file in the output folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my axis.toml").write_text((DATA / "one_axis.toml").read_text(encoding="utf-8"), encoding="utf-8")
    (tmp_path / "found").mkdir()
    (tmp_path / "found" / "next.toml").write_text(SHORT, encoding="utf-8")
    config = Diagnose(logs=(logs,), robot="my axis.toml", out=Path("found"), calibration=0.01)
    motion = SeparatingMotion(between=("a", "b"), protocol="excitation", toml=SHORT, expected=1.0)
    ambiguous = Diagnosis(verdict="ambiguous", sentence="", robot="one_axis", motions=(), separating_motion=motion)
    for command in next_step(config, ambiguous, period=0.004).commands:
        assert main(shlex.split(command)[1:]) == 0, command
    assert (tmp_path / "found_again" / "report.html").exists()
    page = (tmp_path / "found_again" / "report.html").read_text(encoding="utf-8")
    for command in re.findall(r"^  (ffgym .*)$", capsys.readouterr().out, flags=re.MULTILINE):
        assert html.escape(command, quote=True).replace("&#x27;", "&#39;") in page
    assert len(re.findall(r"sha256:[0-9a-f]{64}", page)) == 7  # description, twice two logs with their index
