"""What the page about protocols says runs, and it leaves no protocol out."""

import re
import shlex
from pathlib import Path

from ffgym.cli.main import main
from ffgym.simulation.protocols import PROTOCOLS, load_protocols, plan_session
from tests.simulation.protocols.protocol_samples import arm_of

PAGE = (Path(__file__).parents[3] / "docs" / "protocols.md").read_text(encoding="utf-8")


def blocks(kind):
    return re.findall(rf"```{kind}\n(.*?)```", PAGE, flags=re.S)


def test_every_protocol_is_on_the_page():
    assert {*re.findall(r"^### (\w+)", PAGE, flags=re.M)} == {*PROTOCOLS, "motion"}


def test_commands_and_python_of_the_page_run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for line in blocks("sh")[0].splitlines():
        program, *arguments = shlex.split(line)
        assert program == "ffgym"
        assert main(arguments) == 0
    names: dict[str, object] = {}
    for block in blocks("python"):
        exec(compile(block, "protocols.md", "exec"), names)
    printed = capsys.readouterr().out
    assert "diagnosis.slow_triangle 0.0" in printed
    assert "speed_ladder.elbow" in printed


def test_the_file_of_steps_on_the_page_is_one(tmp_path):
    (tmp_path / "day.toml").write_text(blocks("toml")[0])
    motions = plan_session(arm_of("one_axis"), load_protocols(tmp_path / "day.toml"))
    assert [motion.protocol for motion in motions] == ["speed_ladder", *["warm_up"] * 3, *["motion"] * 2]
