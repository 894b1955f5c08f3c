"""Origin of numbers: commands that run as they are written, and hashes of input files."""

import hashlib
import shlex

import pytest
import tyro

from ffgym.cli.log_options import Diagnose
from ffgym.cli.main import COMMANDS, load_object
from ffgym.cli.outputs import hash_inputs, provenance, write_command
from ffgym.report.page import provenance_lines


@pytest.mark.parametrize(
    ("name", "given"),
    [
        ("diagnose", ["a b", "logs", "--robot", "my robot.toml", "--fit", "--accept", "coarse", "lag"]),
        ("diagnose", []),
        ("identify", ["logs", "--robot", "one_axis", "--validate", "more", "--cutoff-hz", "5", "--json", "n.json"]),
        ("demo", ["--no-diagnosis", "--agents", "none", "--speeds-mm-s", "10", "40"]),
        ("log check", ["logs", "--needs", "friction", "torque", "--figures"]),
        ("record", ["one_axis", "warm_up", "--later-min", "3", "--out", "logs"]),
        ("record", ["--list"]),
        ("simulate", ["one_axis", "circles", "--no-friction"]),
    ],
)
def test_a_command_is_written_as_it_runs(name, given):
    options = load_object(COMMANDS[name].options)
    config = tyro.cli(options, args=given)
    line = write_command(f"ffgym {name}", config)
    assert line.startswith(f"ffgym {name}")
    again = shlex.split(line)[1 + len(name.split()) :]
    assert tyro.cli(options, args=again) == config
    assert len(again) <= len(given)


def test_options_that_only_say_where_results_go_are_left_out():
    config = tyro.cli(Diagnose, args=["logs", "--robot", "one_axis", "--out", "found"])
    origin = provenance("ffgym diagnose", config, "one_axis", None, 0, passing=("out",))
    assert origin["command_line"] == "ffgym diagnose logs --robot one_axis"


CONFIG = {"seed": 3, "columns": None, "joints": [], "fit": False}


def test_a_page_shows_the_line_that_runs_in_the_place_of_the_name_of_the_command():
    lines = provenance_lines({"command": "ffgym demo", "command_line": "ffgym demo --seed 3", "config": CONFIG})
    assert lines == {"command line": "ffgym demo --seed 3", "seed": "3"}
    assert provenance_lines({"command": "python -m scripts.thesis"}) == {"command": "python -m scripts.thesis"}


def test_files_of_the_package_are_hashed_under_names_that_hold_everywhere(tmp_path):
    (tmp_path / "a.csv").write_bytes(b"1")
    found = hash_inputs(["one_axis", "irb4600_60_205_commissioned", tmp_path, None, "workcell:thesis"])
    assert found[2:] == [f"{tmp_path / 'a.csv'} sha256:{hashlib.sha256(b'1').hexdigest()}"]
    assert [line.split()[0] for line in found[:2]] == [
        "ffgym/robot/data/one_axis.toml",
        "ffgym/robot/parameters/irb4600_60_205_commissioned.toml",
    ]
