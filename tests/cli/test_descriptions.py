"""Commands that need a description say so of what has none."""

import pytest

from ffgym.cli.main import main
from tests.cli.errors import read_error

MACHINE = '[machine]\ntitle = "a machine"\nrobot = "one_axis"\n'


WORKCELL = ("workcell:thesis", "workcell:thesis has no description")
FILE = ("machine.toml", "machine.toml: it is a machine file, and a description is needed here")


@pytest.mark.parametrize(
    ("command", "robot", "message"),
    [
        (["export"], *WORKCELL),
        *(
            (command, *given)
            for command in (["train", "stability", "--robot"], ["log", "check", "log.csv", "--robot"])
            for given in (WORKCELL, FILE)
        ),
    ],
)
def test_a_machine_in_place_of_a_description_is_refused(command, robot, message, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "machine.toml").write_text(MACHINE)
    (tmp_path / "log.csv").write_text("")
    assert main([*command, robot]) == 1
    assert message in read_error(capsys)
    assert {path.name for path in tmp_path.iterdir()} == {"machine.toml", "log.csv"}
