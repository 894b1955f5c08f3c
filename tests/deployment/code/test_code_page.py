"""Commands of the page about code run as they are printed."""

import re
import shlex
import subprocess
from pathlib import Path

import pytest

from ffgym.cli.main import main
from ffgym.deployment.code.compiler import find_compiler

PAGE = (Path(__file__).parents[3] / "docs" / "deployment" / "code.md").read_text(encoding="utf-8")


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
@pytest.mark.slow
def test_every_command_of_the_page_runs(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    pytest.importorskip("onnxruntime")
    commands = [line for block in re.findall(r"```sh\n(.*?)```", PAGE, flags=re.S) for line in block.splitlines()]
    for command in commands:
        program, *arguments = shlex.split(command)
        if program == "ffgym":
            assert main(arguments) == 0, capfd.readouterr().err
        else:
            done = subprocess.run([program, *arguments], capture_output=True, text=True, check=False)
            assert done.returncode == 0, done.stderr
    assert commands
