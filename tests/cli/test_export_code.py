"""`ffgym export code`, `table`, `policy` and `fmu` write what was compared, or one line that says why not."""

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
    assert found["check"]["agrees"]
    assert 0 <= found["check"]["largest_difference"] <= 1e-9


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


def test_a_table_of_a_law_is_written(folder, capsys):
    assert main(["export", "table", "one_axis", "sine", "--feedforward", "lugre_static", "--json", "table.json"]) == 0
    assert {path.name for path in (folder / "table").iterdir()} == {"table.csv", "table.bin", "table.h"}
    assert "samples of position [rad or m], torque [N m], correction [rad or m]" in capsys.readouterr().out
    found = json.loads((folder / "table.json").read_text())
    assert (found["motion"], found["feedforward_law"]) == ("sine", "lugre_static")


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["table"], "needs a robot and a motion"),
        (["table", "one_axis"], "needs a robot and a motion"),
        (["table", "--plan", "absent.npz"], "absent.npz"),
        (["table", "one_axis", "sine", "--plan", "absent.npz"], "no effect with --plan"),
        (["fmu", "one_axis", "absent"], "motion"),
        (["fmu", "one_axis", "sine", "--fmi"], "Name a version of the standard or both: --fmi 2.0 3.0."),
        (["fmu", "one_axis", "sine", "--feedforward", "none"], "does not run sample by sample"),
        (["policy", "absent"], "trained policy"),
        (["policy", "ppo_elastic", "--robot", "one_axis", "--motion", "sine"], "6 motors"),
        (["policy", "ppo_elastic", "--out", "policy.txt"], ".onnx"),
    ],
)
def test_a_table_or_policy_that_cannot_be_written_is_one_line(arguments, reason, folder, capsys):
    assert main(["export", *arguments]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert reason in line
    assert not [*folder.iterdir()]
