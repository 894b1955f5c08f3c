"""`ffgym export code` writes a law as C99 that was compared, or one line that says why not."""

import json

import pytest

from ffgym.cli.main import main
from ffgym.deployment.code.compiler import find_compiler


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
def test_a_law_is_written_with_its_comparison(folder, capsys):
    options = ["--feedforward", "lugre_dynamic", "--name", "friction", "--out", "code", "--json", "code.json"]
    assert main(["export", "code", "one_axis", "sine", *options]) == 0
    assert {"friction.h", "friction.c"} < {path.name for path in (folder / "code").iterdir()}
    said = capsys.readouterr().out
    assert "largest difference from the simulation" in said
    assert "us at most" in said
    found = json.loads((folder / "code.json").read_text())
    assert found["feedforward_law"] == "lugre_dynamic"
    assert found["command"] == "ffgym export code"
    assert 0 <= found["check"]["largest_difference"] <= 1e-9 * found["check"]["largest_torque"]


def test_files_that_were_not_compared_are_told(folder, capsys, monkeypatch):
    monkeypatch.setenv("CC", "absent_compiler")
    assert main(["export", "code", "one_axis", "sine", "--unchecked", "--json", "code.json"]) == 0
    assert "note: Not compared with the simulation" in capsys.readouterr().out
    assert json.loads((folder / "code.json").read_text())["check"] is None


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["absent", "sine"], "robot"),
        (["one_axis", "absent"], "motion"),
        (["one_axis", "sine", "--feedforward", "absent"], "Unknown"),
        (["one_axis", "sine", "--feedforward", "none"], "does not run sample by sample"),
        (["one_axis", "sine", "--name", "A"], "lower-case letters"),
        (["one_axis", "sine", "--out", "full"], "full"),
    ],
)
def test_a_request_that_cannot_be_met_is_one_line_and_writes_nothing(arguments, reason, folder, capsys):
    (folder / "full").mkdir()
    (folder / "full" / "file").touch()
    assert main(["export", "code", *arguments]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("ffgym: error: ")
    assert reason in line
    assert [path.name for path in folder.iterdir()] == ["full"]
