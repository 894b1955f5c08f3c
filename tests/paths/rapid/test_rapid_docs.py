"""The page about RAPID says what the code does."""

import re
from pathlib import Path

import pytest
from rapid_samples import moves, program

from ffgym.core.errors import FFGymError
from ffgym.paths.rapid.functions import FUNCTIONS
from ffgym.paths.rapid.geometry import GEOMETRY
from ffgym.paths.rapid.instructions import IGNORED, INSTRUCTIONS, TOLD
from ffgym.paths.rapid.moving import MOVES
from ffgym.paths.rapid.records import TYPES
from ffgym.paths.rapid.triggers import TRIGGERS

PAGE = (Path(__file__).parents[3] / "docs" / "rapid.md").read_text(encoding="utf-8")


def row(name):
    """What the table says is supported."""
    (found,) = (line for line in PAGE.splitlines() if line.startswith(f"| {name} |"))
    return set(re.findall(r"`([^`]*)`", found))


def test_its_examples_run_as_printed(capsys):
    names: dict[str, object] = {}
    for block in re.findall(r"```python\n(.*?)```", PAGE, flags=re.S):
        exec(compile(block, "rapid.md", "exec"), names)
    printed = capsys.readouterr().out.splitlines()
    assert len(printed) == 3
    assert printed[0] in PAGE


def test_its_table_lists_all_types_functions_and_instructions():
    assert set(TYPES) <= row("data")
    assert row("functions") == {*FUNCTIONS, *GEOMETRY, "Present"}
    assert set(TOLD) <= row("told")
    assert set(IGNORED) <= row("without effect")
    assert set(TRIGGERS) <= row("triggers")
    families = {f"{name}{kind}" for name in ("MoveJ", "MoveL", "MoveC") for kind in ("AO", "GO", "Sync")}
    assert set(MOVES) <= row("moves") | families
    said = set.union(*(row(name) for name in ("moves", "settings", "triggers", "signals and waits")))
    said |= row("other instructions") | row("told") | row("without effect") | families
    assert set(INSTRUCTIONS) <= {name.lower() for name in said}


@pytest.mark.parametrize(
    ("statement", "message"),
    [
        ("FOR i FROM 1 DO ENDFOR", "unexpected 'DO'; expected TO."),
        ("SetDoo doJet, 1;", "SetDoo is not supported, and no procedure of this program. Comment it out with '!', "),
        ("MoveL p, z10, fine, tool0;", "speeddata is wanted here, this is zonedata."),
    ],
)
def test_its_errors_are_those_of_the_code(irb4600, statement, message):
    assert message in PAGE
    with pytest.raises(FFGymError, match=re.escape(message)):
        moves(irb4600, program(statement))
