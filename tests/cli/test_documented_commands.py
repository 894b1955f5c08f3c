"""Commands that README and pages show have the names and options that the command line has."""

import re
import shlex
from pathlib import Path

import pytest

from ffgym.cli.main import COMMANDS, main

ROOT = Path(__file__).parent.parent.parent


def documented():
    """Page and arguments of each line of a code block that begins with the command."""
    for page in [ROOT / "README.md", *sorted(ROOT.glob("docs/**/*.md"))]:
        for block in re.findall(r"```\w*\n(.*?)```", page.read_text(encoding="utf-8"), flags=re.DOTALL):
            for line in re.findall(r"^ffgym .*$", block, flags=re.MULTILINE):
                yield page.relative_to(ROOT).as_posix(), line


@pytest.fixture
def idle(monkeypatch):
    """Commands are parsed and do nothing."""
    for command in COMMANDS.values():
        monkeypatch.setattr(f"ffgym.cli.{command.work.replace(':', '.')}", lambda config: None)


def test_every_documented_command_parses(idle):
    lines = [*documented()]
    assert len(lines) > 50
    for page, line in lines:
        try:
            code = main(shlex.split(line, comments=True)[1:])
        except SystemExit as end:
            code = end.code
        assert code == 0, f"{page}: {line}"


def test_a_documented_command_that_has_no_such_option_is_noticed(idle, capsys):
    with pytest.raises(SystemExit):
        main(["simulate", "--robot", "workcell:thesis"])
