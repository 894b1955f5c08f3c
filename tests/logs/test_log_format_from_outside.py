"""A package outside ffgym adds a log format with one file: the one of docs/extending.md."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.logs.log_samples import arrays

PAGE = (Path(__file__).parents[2] / "docs" / "extending.md").read_text(encoding="utf-8")

MAP = """
[log]
robot = "two_link"
[columns.timestamp]
source = "t"
unit = "s"
[columns."motor.position"]
source = "q{number}"
unit = "rad"
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Run Python where the package of the page is installed, in a folder with a trace and its column map."""
    section = PAGE.split("## A log format")[1].split("\n## ")[0]
    (module,) = re.findall(r"^```python\n(.*?)^```", section, flags=re.M | re.S)
    (entry,) = re.findall(r"^plc = \"(.*)\"$", section, flags=re.M)
    site, work = tmp_path_factory.mktemp("site"), tmp_path_factory.mktemp("work")
    (site / f"{entry}.py").write_text(module, encoding="utf-8")
    installed = site / "plc_trace-1.0.dist-info"
    installed.mkdir()
    (installed / "METADATA").write_text("Metadata-Version: 2.1\nName: plc-trace\nVersion: 1.0\n", encoding="utf-8")
    (installed / "entry_points.txt").write_text(f"[ffgym.log_formats]\nplc = {entry}\n", encoding="utf-8")
    log = arrays()
    rows = np.column_stack([log["t"], log["q"]]).astype("<f8")
    (work / "run.plc").write_bytes(b"t;q1;q2\n" + rows.tobytes())
    (work / "cut.plc").write_bytes(b"t;q1;q2\n" + rows.tobytes()[:-4])
    (work / "map.toml").write_text(MAP, encoding="utf-8")
    path = os.pathsep.join([str(site), str(Path(__file__).parents[2])])

    def python(*arguments):
        environment = {**os.environ, "PYTHONPATH": path}
        return subprocess.run(
            [sys.executable, *arguments], cwd=work, env=environment, capture_output=True, text=True, check=False
        )

    return python


def test_read_log_reads_a_format_of_another_package(run):
    code = "from ffgym.logs import read_log; print(read_log('run.plc', 'map.toml')['motor.position.elbow'].tolist())"
    done = run("-c", code)
    assert done.stdout.strip() == repr(arrays()["q"][:, 1].tolist()), done.stderr


def test_the_command_reads_a_format_of_another_package(run):
    assert "q2" in run("-m", "ffgym", "log", "columns", "run.plc").stdout
    done = run("-m", "ffgym", "log", "convert", "run.plc", "--columns", "map.toml", "--out", "run.npz")
    assert "7 rows" in done.stdout, done.stderr


def test_damage_of_a_format_of_another_package_is_one_error(run):
    done = run("-m", "ffgym", "log", "columns", "cut.plc")
    assert done.returncode != 0
    assert "cut.plc: Not a PLC trace, or damaged" in done.stderr
    assert "Traceback" not in done.stderr
