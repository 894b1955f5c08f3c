"""The page about code runs as it is printed."""

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
def test_every_block_of_the_page_runs_in_its_order(tmp_path, monkeypatch, capfd):
    pytest.importorskip("onnxruntime")
    pytest.importorskip("fmpy")
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```(sh|python)\n(.*?)```", PAGE, flags=re.S)
    assert {kind for kind, _ in blocks} == {"sh", "python"}
    for kind, block in blocks:
        if kind == "python":
            exec(compile(block, "code.md", "exec"), {})
            continue
        for command in block.splitlines():
            program, *arguments = shlex.split(command)
            if program == "ffgym":
                assert main(arguments) == 0, capfd.readouterr().err
            else:
                done = subprocess.run([program, *arguments], capture_output=True, text=True, check=False)
                assert done.returncode == 0, done.stderr
