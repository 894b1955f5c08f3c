"""The page about RAPID says what the code does."""

import re
from importlib import resources
from pathlib import Path

import pytest
from rapid_samples import moves, program

from ffgym.core.errors import FFGymError
from ffgym.paths.rapid.evaluate import FUNCTIONS
from ffgym.paths.rapid.interpreter import INSTRUCTIONS, MOVES, SWITCHES
from ffgym.paths.rapid.records import TYPES

PAGE = (Path(__file__).parents[3] / "docs" / "rapid.md").read_text(encoding="utf-8")


def row(name):
    """What the table says is supported."""
    (found,) = (line for line in PAGE.splitlines() if line.startswith(f"| {name} |"))
    return set(re.findall(r"`([^`]*)`", found))


def test_its_example_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    source = resources.files("ffgym.paths.rapid") / "examples" / "thesis_circles.mod"
    (tmp_path / "cut.mod").write_bytes(source.read_bytes())
    (block,) = re.findall(r"```python\n(.*?)```", PAGE, flags=re.S)
    names: dict[str, object] = {}
    exec(compile(block, "rapid.md", "exec"), names)
    assert names["motion"].reference.duration > 5


def test_its_table_lists_types_functions_and_instructions():
    assert set(TYPES) <= row("data")
    assert {name.lower() for name in row("functions")} >= set(FUNCTIONS)
    said = {word.lower() for name in ("moves", "other instructions") for cell in row(name) for word in cell.split()}
    assert {name.lower() for name in INSTRUCTIONS} <= said
    assert {name.lower() for name in INSTRUCTIONS} == {*MOVES, *SWITCHES, "waittime", "accset"}


@pytest.mark.parametrize(
    ("statement", "message"),
    [
        ("FOR i FROM 1 TO 5 DO", "FOR is not supported; a program is a list of moves, see docs/rapid.md."),
        ("SetDO doJet, 1;", "SetDO is not supported, and no procedure of this program. Available: MoveAbsJ, MoveC, "),
        (
            "MoveL [[1,2,3],[1,0,0],[0,0,0,0],[9E9]], v1, fine, tool0;",
            "orient has 4 components, [q1, q2, q3, q4], got 3.",
        ),
    ],
)
def test_its_errors_are_those_of_the_code(irb4600, statement, message):
    assert message in PAGE
    with pytest.raises(FFGymError, match=re.escape(message)):
        moves(irb4600, program(statement))
