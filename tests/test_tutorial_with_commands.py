"""A page that a newcomer follows with files and commands: each block does what the page says, in its order."""

import json
import re
import shlex
from pathlib import Path

import pytest

from ffgym.cli.main import main

TUTORIALS = Path(__file__).parent.parent / "docs" / "tutorials"
BLOCK = re.compile(r"([^\n]*)\n\n```(\w+)\n(.*?)```", flags=re.DOTALL)
"""The line before a block, its language, and what is in it."""
NUMBER = re.compile(r"-?\d+\.?\d*(?:e[+-]\d+)?")


def save(announced, text, folder):
    """Write or append to the file that the line before a block ends with, if it does."""
    found = re.search(r"`([\w.]+)`:$", announced)
    if found:
        path = folder / found[1]
        path.write_text((path.read_text() if announced.endswith(f"Add to `{found[1]}`:") else "") + text)


def run(commands):
    for command in commands.splitlines():
        program, *arguments = shlex.split(command)
        assert program == "ffgym"
        assert main(arguments) == 0, command


def check_printed(excerpt, printed):
    """Every line of an excerpt, up to '...', is among those printed, with numbers that differ by at most 5 %."""
    lines = printed.splitlines()
    for wanted in excerpt.splitlines():
        start = wanted.split("...")[0]
        assert any(same(start, line[: len(line) if "..." not in wanted else None]) for line in lines), wanted


def same(wanted, line):
    words, numbers = NUMBER.sub("#", wanted).split(), [float(x) for x in NUMBER.findall(wanted)]
    own_words, own = NUMBER.sub("#", line).split(), [float(x) for x in NUMBER.findall(line)]
    near = all(abs(a - b) <= 0.05 * abs(a) + 0.002 for a, b in zip(numbers, own, strict=False))
    return own_words[: len(words)] == words and len(own) >= len(numbers) and near


def follow(page, folder, capsys):
    """Do what a page says in a folder; returns the languages of its blocks."""
    names: dict[str, object] = {}
    printed = ""
    kinds = []
    for announced, language, text in BLOCK.findall((TUTORIALS / page).read_text(encoding="utf-8")):
        kinds.append(language)
        if language in ("xml", "toml", "rapid"):
            save(announced, text, folder)
        elif language == "bash":
            run(text)
            printed = capsys.readouterr().out
        elif language == "text":
            check_printed(text, printed)
        else:
            assert language == "python"
            exec(compile(text, page, "exec"), names)
    return kinds


def test_the_page_leads_from_an_arm_file_to_a_feed_forward_run(tmp_path, monkeypatch, capsys):
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    assert follow("your_robot.md", tmp_path, capsys).count("bash") == 4
    assert {"cutter.toml", "cutter.html", "cutter.json", "cut.html", "cut_elastic.csv"} <= {
        path.name for path in tmp_path.iterdir()
    }


@pytest.mark.slow
def test_the_page_leads_from_a_machine_to_feed_forward_with_its_friction(tmp_path, monkeypatch, capsys):
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    assert follow("identify.md", tmp_path, capsys).count("bash") == 3
    assert {"parameters.toml", "identified.html", "identified.json", "logs"} <= {
        path.name for path in tmp_path.iterdir()
    }


def test_the_page_leads_from_a_faulty_machine_to_its_extended_model(tmp_path, monkeypatch, capsys):
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    assert follow("diagnose.md", tmp_path, capsys).count("bash") == 4
    assert {path.name for path in (tmp_path / "found").iterdir()} == {
        "report.html",
        "diagnosis.json",
        "extended.toml",
    }


@pytest.mark.slow
def test_the_page_leads_from_the_files_of_a_controller_to_a_verdict(tmp_path, monkeypatch, capsys):
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    assert follow("real_machine.md", tmp_path, capsys).count("bash") == 5
    found = json.loads((tmp_path / "found" / "diagnosis.json").read_text())
    assert found["verdict"] != "insufficient"
    assert (tmp_path / "found" / "report.html").exists()


def test_the_page_leads_from_a_program_and_a_log_to_a_corrected_program_and_its_gain(tmp_path, monkeypatch, capsys):
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    assert follow("onto_the_machine.md", tmp_path, capsys).count("bash") == 6
    (gain,) = json.loads((tmp_path / "gain.json").read_text())["gains"]
    assert gain["claim"] == "gain"
    assert (tmp_path / "corrected" / "holes.mod").exists()


def test_an_excerpt_that_is_not_printed_is_noticed():
    check_printed("law | 0.30\nfound: a, ...", "x\nlaw  | 0.301 1.0\nfound: a, b")
    with pytest.raises(AssertionError):
        check_printed("law | 0.30", "law | 0.40")
    with pytest.raises(AssertionError):
        check_printed("law | 0.30", "rule | 0.30")
