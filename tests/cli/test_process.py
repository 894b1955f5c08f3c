"""The command as a process: a reader that leaves early, and Ctrl-C in the middle."""

import signal
import subprocess
import sys
import time
from pathlib import Path

from tests.processes import INTERRUPTIBLE

EXPORT = ["export", "one_axis", "--out", "model"]
COMMAND = [sys.executable, "-m", "ffgym"]


def wait_until_it_simulates(pid):
    """Return when a process has loaded all libraries, some of which swallow an interruption."""
    start, maps = time.monotonic(), Path(f"/proc/{pid}/maps")
    if not maps.parent.exists():  # elsewhere than on Linux nobody tells
        time.sleep(5.0)
        return
    for _ in range(600):
        if maps.exists() and "mujoco" in maps.read_text():
            time.sleep(max(4.0, 3.0 * (time.monotonic() - start)))  # what follows takes three times as long at most
            return
        time.sleep(0.1)
    raise AssertionError("the engine was not loaded within a minute")


def test_a_working_directory_that_is_gone_is_one_line(tmp_path):
    command = f"import os, sys; from ffgym.cli.main import main; os.rmdir(os.getcwd()); sys.exit(main({EXPORT}))"
    (tmp_path / "gone").mkdir()
    done = subprocess.run([sys.executable, "-c", command], cwd=tmp_path / "gone", capture_output=True, text=True)
    error = "The working directory is gone: it was removed or moved. Change to one that is there."
    assert (done.returncode, done.stderr) == (1, f"ffgym: error: {error}\n")
    assert not list(tmp_path.iterdir())


def test_a_reader_that_has_seen_enough_loses_nothing(tmp_path):
    demo = [*COMMAND, "demo", "--no-diagnosis", "--positions", "p1", "--speeds-mm-s", "100", "--json", "n.json"]
    with subprocess.Popen(demo, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        process.stdout.close()
        assert process.stderr is not None
        errors = process.stderr.read()
        assert (process.wait(timeout=60), errors) == (0, "")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["n.json", "report.html"]


def test_ctrl_c_in_the_middle_is_one_line_and_leaves_no_half_file(tmp_path):
    process = subprocess.Popen(
        [*COMMAND, "demo"],
        cwd=tmp_path,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=INTERRUPTIBLE,
    )
    wait_until_it_simulates(process.pid)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130
    assert errors == "ffgym: interrupted; files that were finished before stay, none is half-written\n"
    assert not list(tmp_path.iterdir())
