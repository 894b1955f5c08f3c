"""A place is written by one process at a time, and what killed ones left half-written goes."""

import os
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

from ffgym.core.claims import claim, claimed, claimed_place, piece_of_work
from ffgym.core.errors import FFGymError
from ffgym.core.files import new_folder, write_text
from ffgym.core.temporaries import lock, scratch_folder, temporary_file, temporary_folder

HOLDER = """
import sys, time
from contextlib import ExitStack
from pathlib import Path
from ffgym.core.claims import claimed, claimed_place
from ffgym.core.temporaries import temporary_file, temporary_folder
folder = Path(sys.argv[1])
with ExitStack() as held:
    for context in (claimed, temporary_file, temporary_folder):
        held.enter_context(context(folder))
    held.enter_context(claimed_place(folder / "file"))
    print("held", flush=True)
    time.sleep(600)
"""


@pytest.fixture
def holder(tmp_path):
    """A process that holds a folder and a file in it, and writes temporary ones."""
    process = subprocess.Popen([sys.executable, "-c", HOLDER, str(tmp_path)], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "held\n"
    yield process
    process.kill()
    process.wait()
    process.stdout.close()


def test_a_folder_that_another_process_holds_is_refused_and_left_alone(tmp_path, holder):
    remains = tmp_path / ".ffgym-0123.tmp"
    remains.write_text("half")
    words = rf"{tmp_path}: process {holder.pid} \(-c .*\) is writing there.*choose another"
    with pytest.raises(FFGymError, match=words), claimed(tmp_path):
        pass
    assert remains.exists()


def test_a_file_that_another_process_writes_is_refused_and_its_neighbours_are_not(tmp_path, holder):
    words = rf"file: process {holder.pid} \(-c .*\) is writing there"
    for refused in (claimed_place, new_folder):
        with pytest.raises(FFGymError, match=words), refused(tmp_path / "file"):
            pass
    (tmp_path / "link").symlink_to("file")
    with pytest.raises(FFGymError, match=f"link: process {holder.pid}"), claimed_place(tmp_path / "link"):
        pass
    with claimed_place(tmp_path / "other"), new_folder(tmp_path / "folder"):
        pass
    assert (tmp_path / "folder").is_dir()


def test_what_living_processes_write_stays_and_goes_when_they_are_killed(tmp_path, holder):
    written = set(tmp_path.iterdir())
    with claimed_place(tmp_path / "other"):
        assert written < set(tmp_path.iterdir())
    os.kill(holder.pid, signal.SIGKILL)
    holder.wait()
    with claimed_place(tmp_path / "other"):
        assert not written & set(tmp_path.iterdir())
    assert not list(tmp_path.iterdir())


def test_a_claim_ends_with_its_process_however_that_ends(tmp_path, holder):
    os.kill(holder.pid, signal.SIGKILL)
    holder.wait()
    with claimed(tmp_path) as folder:
        assert folder == tmp_path


def test_a_claim_ends_with_its_block(tmp_path):
    for _ in range(2):
        with claimed(tmp_path), claimed_place(tmp_path / "file"):
            write_text(tmp_path / "file", "whole")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file"]


def test_what_was_half_written_goes_and_nothing_else(tmp_path):
    (tmp_path / ".ffgym-0123.tmp").write_text("half")
    (tmp_path / ".ffgym-4567.tmp").mkdir()
    (tmp_path / ".ffgym-4567.tmp" / "file").write_text("half")
    kept = [tmp_path / "row.json", tmp_path / ".hidden.tmp", tmp_path / "notes.tmp"]
    for path in kept:
        path.write_text("whole")
    with claimed(tmp_path):
        pass
    assert set(tmp_path.iterdir()) == set(kept)


@pytest.mark.parametrize(
    ("right", "words"), [("W_OK", "is not writable"), ("R_OK", "cannot be written: Permission denied")]
)
def test_a_folder_without_rights_is_refused(tmp_path, monkeypatch, right, words):
    def refused(*_):
        raise PermissionError(13, "Permission denied")

    if right == "W_OK":
        monkeypatch.setattr("ffgym.core.claims.os.access", lambda place, mode: mode != os.W_OK)
    else:
        monkeypatch.setattr("ffgym.core.temporaries.os.open", refused)
    with pytest.raises(FFGymError, match=words), claimed(tmp_path):
        pass


def test_a_drive_without_locks_is_used_as_it_is(tmp_path, monkeypatch):
    def refused(*_):
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr("ffgym.core.temporaries.fcntl.flock", refused)
    remains = tmp_path / ".ffgym-0123.tmp"
    remains.write_text("perhaps of another process")
    with claimed(tmp_path), claimed_place(tmp_path / "file"), temporary_file(tmp_path):
        pass
    assert list(tmp_path.iterdir()) == [remains]


def test_work_may_claim_again_what_it_has_and_keeps_it_until_its_first_claim_ends(tmp_path):
    with claimed(tmp_path):
        with claimed(tmp_path):
            pass
        assert list(tmp_path.iterdir())
    assert not list(tmp_path.iterdir())


def test_another_thread_is_other_work(tmp_path):
    def look():
        with claimed(tmp_path):
            pass

    with claimed(tmp_path), ThreadPoolExecutor(1) as pool:
        refused = pool.submit(look)
        with pytest.raises(FFGymError, match=f"process {os.getpid()} "):
            refused.result()


def test_claims_of_a_command_last_until_it_ends(tmp_path):
    claim(tmp_path / "file")  # outside of a command nothing is held
    assert not list(tmp_path.iterdir())
    with piece_of_work():
        claim(tmp_path / "file")
        claim(tmp_path / "file")
        assert len(list(tmp_path.iterdir())) == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("make", [temporary_file, temporary_folder])
def test_a_temporary_that_is_taken_for_remains_while_it_is_made_is_made_again(tmp_path, monkeypatch, make):
    taken = []

    def take_first(path):
        if not taken:  # as a process that looks for remains in this instant
            taken.append(path)
            held = lock(path)
            path.rmdir() if path.is_dir() else path.unlink()
            os.close(held)
        return lock(path)

    monkeypatch.setattr("ffgym.core.temporaries.lock", take_first)
    with make(tmp_path) as path:
        assert path.exists()
        assert taken[0] != path
    assert not list(tmp_path.iterdir())


def test_scratch_of_killed_processes_goes(tmp_path, monkeypatch):
    monkeypatch.setattr("ffgym.core.temporaries.gettempdir", lambda: str(tmp_path))
    (tmp_path / ".ffgym-0123.tmp").mkdir()
    with scratch_folder() as folder:
        assert list(tmp_path.iterdir()) == [folder]
    assert not list(tmp_path.iterdir())
