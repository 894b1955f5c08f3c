"""`python -m scripts.thesis` writes page, pictures and numbers, and refuses before it simulates."""

import json

import pytest

from ffgym.core.version import __version__
from scripts.thesis.__main__ import Reproduce, main
from tests.cli.errors import read_error


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """What the command wrote for one figure."""
    folder = tmp_path_factory.mktemp("reproduction")
    arguments = ["--out", "page.html", "--json", "numbers.json", "--figures-dir", "pictures"]
    arguments = [a if a.startswith("-") else str(folder / a) for a in arguments]
    assert main(["--only", "figure-4.4", *arguments]) == 0
    return folder


def test_the_command_writes_what_it_is_asked_for(folder):
    assert {p.name for p in folder.iterdir()} == {"page.html", "numbers.json", "pictures"}
    assert {p.name for p in (folder / "pictures").iterdir()} == {"figure-4.4.svg", "figure-4.4.png"}
    assert "Figure 4.4" in (folder / "page.html").read_text(encoding="utf-8")


def test_the_numbers_say_where_they_come_from(folder):
    numbers = json.loads((folder / "numbers.json").read_text())
    assert numbers["command"] == "python -m scripts.thesis"
    assert numbers["seed"] == 0
    assert numbers["versions"]["ffgym"] == __version__
    assert numbers["physics_fingerprints"].keys() == {"irb4600_60_205", "one_axis", "workcell:thesis"}
    assert [item["name"] for item in numbers["items"]] == ["figure-4.4"]


def test_the_command_prints_a_line_per_claim(tmp_path, capsys):
    assert main(["--only", "figure-4.4", "--out", str(tmp_path / "page.html")]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert sum(line.startswith("Figure 4.4") for line in lines) == 3
    assert any(line.startswith("claims: ") for line in lines)
    assert all(len(line) <= 120 for line in lines)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--only", "figure-9.9"], "Unknown item 'figure-9.9'"),
        (["--out", "absent/page.html"], "does not exist"),
        (["--json", "absent/numbers.json"], "does not exist"),
        (["--out", "same", "--json", "same"], "they need two files"),
        (["--figures-dir", "file"], "cannot be made a folder"),
    ],
)
def test_what_cannot_be_done_is_one_line_and_nothing_is_simulated(arguments, message, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").touch()
    monkeypatch.setattr("scripts.thesis.reproduce", lambda *_: pytest.fail("simulated in vain"))
    assert main([*arguments]) == 1
    assert message in read_error(capsys)
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_a_missing_extra_of_the_reproduction_is_named(monkeypatch, capsys):
    monkeypatch.setattr("ffgym.cli.outputs.is_installed", lambda name: name != "matplotlib")
    assert main([]) == 1
    assert "needs matplotlib; pip install 'ffgym[cli,report]'" in capsys.readouterr().err


def test_everything_is_reproduced_by_default():
    assert Reproduce().only == ()
