"""`ffgym export program` writes corrected programs, and refuses what cannot be one."""

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest

from ffgym.cli.main import main
from ffgym.control import SetpointResponse
from ffgym.deployment import write_plan

PAGE = (Path(__file__).parents[3] / "docs" / "deployment" / "programs.md").read_text(encoding="utf-8")


@pytest.fixture
def place(plan, tmp_path, monkeypatch):
    """Folder with a plan, in which commands run."""
    monkeypatch.chdir(tmp_path)
    write_plan(plan, "plan.npz")
    return tmp_path


def test_the_command_of_the_page_writes_program_report_and_numbers(place, capsys):
    (command,) = re.findall(r"^ffgym (export program .*)$", PAGE, flags=re.M)
    main([*command.split(), "--json", "numbers.json"])
    told = capsys.readouterr().out
    assert "The correction moves the tool by" in told
    assert {path.name for path in (place / "corrected").iterdir()} == {"short.mod", "changes.html", "changes.json"}
    numbers = json.loads((place / "numbers.json").read_text())
    assert numbers["read_back"]["distance"] < numbers["tolerance"] == 1e-5
    assert numbers["versions"]["ffgym"]
    assert numbers["largest_at_tool"]["size"] > 1e-5


def test_the_robot_is_that_of_the_plan_unless_another_is_named(place, capsys):
    main(["export", "program", "plan.npz", "--format", "csv", "--out", "table"])
    assert (place / "table" / "short.csv").exists()
    assert main(["export", "program", "plan.npz", "--robot", "two_link", "--out", "no"]) == 1
    assert "is for joints" in capsys.readouterr().err
    assert not (place / "no").exists()


def test_a_plan_that_undoes_a_filter_is_told_to_be_for_streams(plan, place, capsys):
    assert main(["export", "program", "plan.npz", "--format", "csv", "--out", "plain"]) == 0
    assert "undoes a controller" not in capsys.readouterr().out
    response = SetpointResponse.low_pass(20.0, delay=0.0093)
    write_plan(replace(plan, meta={"response": response.describe()}), "undoing.npz")
    assert main(["export", "program", "undoing.npz", "--format", "csv", "--out", "undoing"]) == 0
    assert "undoes a controller with delay 9.30 ms, first-order filter at 20.0 Hz" in capsys.readouterr().out
    assert "without --controller" in (place / "undoing" / "changes.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--gain", "500"], "--gain has no effect with --format rapid"),
        (["--format", "urscript", "--period-ms", "8"], "--period-ms has no effect with --format urscript"),
        (["--tolerance-mm", "0"], "tolerance = 0.0 m is out of range"),
        (["--period-ms", "200", "--tolerance-mm", "0.002"], "Allow more, or a shorter period"),
    ],
)
def test_bad_options_are_one_line(place, capsys, options, message):
    assert main(["export", "program", "plan.npz", "--out", "no", *options]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert message in line
    assert not (place / "no").exists()


@pytest.mark.slow
def test_the_example_of_the_page_prints_what_the_page_says(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (block,) = re.findall(r"```python\n(.*?)```", PAGE, flags=re.S)
    exec(compile(block, "programs.md", "exec"), {})
    assert capsys.readouterr().out.strip() in PAGE
