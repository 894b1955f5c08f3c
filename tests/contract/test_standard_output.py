"""Standard output that is closed, full or ASCII, and folders without rights, cost no file and no traceback."""

import pytest

from ffgym.cli.main import COMMANDS
from tests.contract.runs import CHEAP, begin, run, skip_without, written
from tests.contract.writing_commands import EXAMPLES

FULL = "Standard output cannot be written: No space left on device. Files that were asked for are written."
OUTPUTS = {"closed": (0, ""), "left": (0, ""), "/dev/full": (1, f"ffgym: error: {FULL}\n")}
"""What standard output is, with the code and the errors that a command ends with then."""
WAYS = [*({"out": out} for out in OUTPUTS), {"encoding": "ascii"}]


def check_output(killing, name, how):
    """Run a command, and once more with another standard output; files must be the same."""
    begin(killing, name)
    assert run(killing, name)["code"] == 0
    wanted = written(killing, name)
    begin(killing, name)
    found = run(killing, name, **how)
    assert (found["code"], found["err"]) == OUTPUTS.get(how.get("out"), (0, ""))
    assert written(killing, name) == wanted


def check_rights(killing, name, mode):
    """Run a command in a folder that it may not write, or neither write nor read."""
    begin(killing, name)
    try:
        before = written(killing, name)
        found = run(killing, name, mode=mode)
    finally:
        killing.folder.chmod(0o755)
    assert found["code"] == 1, found
    (line,) = found["err"].splitlines()
    assert line.startswith("ffgym: error: ")
    assert written(killing, name) == before


@pytest.mark.parametrize("how", WAYS, ids=str)
@pytest.mark.parametrize("name", CHEAP)
def test_no_standard_output_costs_a_file(few, name, how):
    check_output(few, name, how)


@pytest.mark.parametrize("mode", [0o555, 0o000], ids=oct)
@pytest.mark.parametrize("name", CHEAP)
def test_a_folder_without_rights_is_one_line_and_stays_as_it_is(few, name, mode):
    check_rights(few, name, mode)


@pytest.mark.parametrize("name", [*COMMANDS][::4])
def test_help_that_cannot_be_printed_is_one_line(few, name):
    for out, (code, errors) in OUTPUTS.items():
        found = few.run(*name.split(), "--help", out=out)
        assert (found["code"], found["err"]) == (code, errors)
    found = few.run(*name.split(), "--help", encoding="ascii")
    assert (found["code"], found["err"]) == (0, "")
    assert found["out"].isascii()
    assert "usage: ffgym" in found["out"]


@pytest.mark.slow
@pytest.mark.parametrize("name", EXAMPLES)
def test_no_command_loses_a_file_or_breaks_without_output_or_rights(every, name):
    skip_without(name)
    for how in WAYS:
        check_output(every, name, how)
    for mode in (0o555, 0o000):
        check_rights(every, name, mode)
