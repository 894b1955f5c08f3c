"""A folder is filled by one process at a time, and what killed ones left half-written goes."""

import os
import signal
import subprocess
import sys

import pytest

from ffgym.core.claims import claimed
from ffgym.core.errors import FFGymError
from ffgym.core.files import write_text

HOLDER = """
import sys, time
from ffgym.core.claims import claimed
with claimed(sys.argv[1]):
    print("held", flush=True)
    time.sleep(600)
"""


@pytest.fixture
def holder(tmp_path):
    """A process that holds a folder."""
    process = subprocess.Popen([sys.executable, "-c", HOLDER, str(tmp_path)], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "held\n"
    yield process
    process.kill()
    process.wait()
    process.stdout.close()


def test_a_folder_that_another_process_holds_is_refused_and_left_alone(tmp_path, holder):
    remains = tmp_path / ".ffgym-0123.tmp"
    remains.write_text("half")
    with pytest.raises(FFGymError, match=r"another process is filling this folder.*choose another"), claimed(tmp_path):
        pass
    assert remains.exists()


def test_a_claim_ends_with_its_process_however_that_ends(tmp_path, holder):
    os.kill(holder.pid, signal.SIGKILL)
    holder.wait()
    with claimed(tmp_path) as folder:
        assert folder == tmp_path


def test_a_claim_ends_with_its_block(tmp_path):
    for _ in range(2):
        with claimed(tmp_path):
            write_text(tmp_path / "file", "whole")
    with pytest.raises(FFGymError, match="another process"), claimed(tmp_path), claimed(tmp_path):
        pass
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file"]


def test_what_was_half_written_goes_and_nothing_else(tmp_path):
    (tmp_path / ".ffgym-0123.tmp").write_text("half")
    (tmp_path / ".ffgym-4567.tmp").mkdir()
    (tmp_path / ".ffgym-4567.tmp" / "file").write_text("half")
    kept = [tmp_path / "row.json", tmp_path / ".hidden.tmp", tmp_path / "notes.tmp"]
    for path in kept:
        path.write_text("whole")
    with claimed(tmp_path):
        assert set(tmp_path.iterdir()) == set(kept)


@pytest.mark.parametrize(
    ("right", "words"), [("W_OK", "is not writable"), ("R_OK", "cannot be read: Permission denied")]
)
def test_a_folder_without_rights_is_refused(tmp_path, monkeypatch, right, words):
    def refused(*_):
        raise PermissionError(13, "Permission denied")

    if right == "W_OK":
        monkeypatch.setattr("ffgym.core.claims.os.access", lambda place, mode: mode != os.W_OK)
    else:
        monkeypatch.setattr("ffgym.core.claims.os.open", refused)
    with pytest.raises(FFGymError, match=words), claimed(tmp_path):
        pass


def test_a_drive_without_locks_is_used_as_it_is(tmp_path, monkeypatch):
    def refused(*_):
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr("ffgym.core.claims.fcntl.flock", refused)
    (tmp_path / ".ffgym-0123.tmp").write_text("perhaps of another process")
    with claimed(tmp_path), claimed(tmp_path):
        assert len(list(tmp_path.iterdir())) == 1
