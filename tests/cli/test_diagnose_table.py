"""`ffgym diagnose --table` from a file to a verdict."""

import json

import pytest

from ffgym.cli.main import main

ROWS = """use,position,speed_mm_s,radius_mm,law,statistic,value_mm
fitted,p1,100,3,none,rms,0.20
fitted,p2,100,3,none,rms,0.25
held_out,p3,100,3,none,rms,0.25
"""


@pytest.fixture
def table(tmp_path):
    (tmp_path / "rows.csv").write_text(ROWS)
    (tmp_path / "mine.toml").write_text('title = "mine"\nrobot = "irb4600_60_205"\nrows = "rows.csv"\n')
    return tmp_path / "mine.toml"


def test_a_table_gets_a_verdict_and_files(table, tmp_path, capsys):
    out = tmp_path / "found"
    command = ["diagnose", "--table", str(table), "--structures", "description", "numbers", "--no-pairs"]
    assert main([*command, "--steps", "1", "--jobs", "1", "--out", str(out)]) == 0
    document = json.loads((out / "table_diagnosis.json").read_text())
    assert {one["name"] for one in document["structures"]} == {"description", "numbers"}
    assert document["provenance"]["inputs"]
    assert document["physics_fingerprint"]
    printed = capsys.readouterr().out
    assert printed.startswith(document["verdict"])
    assert "sign" not in printed  # no question was asked
    assert (out / "structures" / "numbers.json").exists()
    assert (out / "table.csv").exists()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--table", "{table}", "--robot", "one_axis"], "--table takes no --robot"),
        (["--table", "{table}", "--structures", "magic"], "Unknown structure 'magic'"),
        (["--table", "none.toml"], "none.toml"),
        (["--structures", "numbers"], "--structures has no effect on logs"),
    ],
)
def test_what_does_not_fit_a_table_is_one_error(table, options, words, capsys):
    assert main(["diagnose", *(option.format(table=table) for option in options)]) != 0
    assert words in capsys.readouterr().err


def test_a_law_that_does_not_exist_is_one_error(table, tmp_path, capsys):
    (tmp_path / "rows.csv").write_text(ROWS + "held_out,p4,100,3,magic,rms,0.25\n")
    assert main(["diagnose", "--table", str(table), "--structures", "description"]) != 0
    assert "mine: Unknown agent 'magic'" in capsys.readouterr().err
