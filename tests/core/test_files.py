"""A file is written whole or not at all, whatever goes wrong."""

import errno
import json
import os

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.core.files import (
    check_vacant,
    check_writable,
    csv_rows,
    made_folder,
    new_folder,
    write_bytes,
    write_json,
    write_text,
)


def full(*_):
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def interrupted(*_):
    raise KeyboardInterrupt


@pytest.fixture
def old(tmp_path):
    path = tmp_path / "result.json"
    path.write_text("old")
    return path


def test_bytes_text_and_json_arrive_as_given(tmp_path):
    write_bytes(tmp_path / "b", b"\x00\xff\r\n")
    write_text(tmp_path / "t", "Ångström\n")
    write_json(tmp_path / "j", {"a": [1, 2.5, None], "b": "é"})
    assert (tmp_path / "b").read_bytes() == b"\x00\xff\r\n"
    assert (tmp_path / "t").read_bytes() == "Ångström\n".encode()
    assert json.loads((tmp_path / "j").read_text()) == {"a": [1, 2.5, None], "b": "é"}
    assert len(list(tmp_path.iterdir())) == 3


def test_a_file_is_replaced(old):
    write_text(old, "new")
    assert old.read_text() == "new"
    assert list(old.parent.iterdir()) == [old]


def test_a_file_that_is_replaced_keeps_its_permissions(old):
    old.chmod(0o640)
    write_text(old, "new")
    assert old.stat().st_mode & 0o777 == 0o640


def test_a_file_that_is_protected_is_refused(monkeypatch, old):
    """Whoever runs the tests may be allowed everything."""
    monkeypatch.setattr(os, "access", lambda path, _: path != old)
    with pytest.raises(FFGymError, match=r"result\.json is not writable"):
        check_writable(old)
    check_writable(old.with_name("other.json"))


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_pipe_or_device_is_no_place_to_write_and_stays(tmp_path):
    pipe, link = tmp_path / "pipe", tmp_path / "link"
    os.mkfifo(pipe)
    link.symlink_to(pipe)
    for place in (pipe, link):
        for write in (check_writable, lambda path: write_text(path, "new")):
            with pytest.raises(FFGymError, match="is a pipe or a device, must be a file; choose another name"):
                write(place)
    assert pipe.is_fifo()
    assert sorted(tmp_path.iterdir()) == [link, pipe]


def test_a_link_that_leads_to_itself_is_no_place_to_write(tmp_path):
    loop, free = tmp_path / "loop", tmp_path / "free"
    loop.symlink_to(loop)
    free.symlink_to(tmp_path / "new.json")
    with pytest.raises(FFGymError, match="loop: cannot be written: Too many levels of symbolic links"):
        check_writable(loop)
    check_writable(free)


@pytest.mark.parametrize("step", ["replace", "fsync"])
def test_a_full_disk_is_one_clear_error_and_leaves_the_old_file(monkeypatch, old, step):
    monkeypatch.setattr(os, step, full)
    with pytest.raises(FFGymError, match=r"result\.json: cannot be written: No space left on device"):
        write_json(old, {"a": 1})
    assert old.read_text() == "old"
    assert list(old.parent.iterdir()) == [old]


@pytest.mark.parametrize("step", ["replace", "fsync"])
def test_an_interrupt_leaves_the_old_file_and_nothing_else(monkeypatch, old, step):
    monkeypatch.setattr(os, step, interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_text(old, "new")
    assert old.read_text() == "old"
    assert list(old.parent.iterdir()) == [old]


def test_a_folder_that_does_not_exist_is_named(tmp_path):
    with pytest.raises(FFGymError, match=r"absent.*cannot be written: No such file or directory"):
        write_text(tmp_path / "absent" / "file", "text")


def test_a_folder_is_not_overwritten(tmp_path):
    (tmp_path / "folder").mkdir()
    with pytest.raises(FFGymError, match="folder: cannot be written"):
        write_text(tmp_path / "folder", "text")
    assert [p.name for p in tmp_path.iterdir()] == ["folder"]


def test_a_link_is_written_through(tmp_path):
    (tmp_path / "target").write_text("old")
    (tmp_path / "link").symlink_to(tmp_path / "target")
    write_text(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "target").read_text() == "new"


@pytest.mark.parametrize("value", [float("nan"), {"deep": [1, float("inf")]}, {"object": object()}, {(1, 2): 3}])
def test_what_has_no_json_form_is_refused_before_anything_is_written(old, value):
    with pytest.raises(FFGymError, match="no JSON form"):
        write_json(old, value)
    assert old.read_text() == "old"


def test_a_name_that_is_too_long_is_refused(tmp_path):
    with pytest.raises(FFGymError, match="cannot be written"):
        write_text(tmp_path / ("x" * 300), "text")


@pytest.mark.parametrize("exists", [False, True])
def test_a_new_folder_appears_with_all_its_files(tmp_path, exists):
    target = tmp_path / "new"
    if exists:
        target.mkdir()
    with new_folder(target) as folder:
        (folder / "a").write_text("1")
        (folder / "b").write_text("2")
        assert not (target / "a").exists()
    assert sorted(path.name for path in target.iterdir()) == ["a", "b"]
    assert list(tmp_path.iterdir()) == [target]


@pytest.mark.parametrize("raised", [KeyboardInterrupt, ValueError])
def test_a_folder_whose_writing_stops_leaves_nothing(tmp_path, raised):
    def write():
        with new_folder(tmp_path / "new") as folder:
            (folder / "a").write_text("1")
            raise raised

    with pytest.raises(raised):
        write()
    assert list(tmp_path.iterdir()) == []


def test_a_full_disk_is_one_clear_error_and_leaves_no_folder(tmp_path):
    with pytest.raises(FFGymError, match="new: cannot be written: No space left"), new_folder(tmp_path / "new"):
        full()
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_fails_in_a_new_folder_is_named_as_it_would_have_been(tmp_path):
    with (
        pytest.raises(FFGymError, match=f"^{tmp_path}/new/absent/row.csv: cannot be written: No such file"),
        new_folder(tmp_path / "new") as folder,
    ):
        write_text(folder / "absent" / "row.csv", "1")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_was_made_for_nothing_goes_again(tmp_path):
    with pytest.raises(KeyboardInterrupt), made_folder(tmp_path / "a" / "b"):
        raise KeyboardInterrupt
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_has_a_file_or_was_there_before_stays(tmp_path):
    (tmp_path / "there").mkdir()
    with made_folder(tmp_path / "a" / "b") as folder:
        write_text(folder / "kept", "1")
    for path in (tmp_path / "a" / "b", tmp_path / "there"):
        with pytest.raises(KeyboardInterrupt), made_folder(path):
            raise KeyboardInterrupt
        assert path.is_dir()
    with pytest.raises(FFGymError, match="kept: cannot be made a folder"), made_folder(tmp_path / "a" / "b" / "kept"):
        pass


def test_a_folder_that_holds_something_stays_as_it_is(tmp_path):
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "mine").write_text("mine")
    (tmp_path / "file").write_text("mine")
    for name, message in (
        ("taken", "exists already, and nothing is overwritten"),
        ("file", "exists already, and nothing is overwritten"),
        ("absent/new", "absent does not exist; create it"),
    ):
        for make in (check_vacant, lambda path: new_folder(path).__enter__()):
            with pytest.raises(FFGymError, match=message):
                make(tmp_path / name)
    assert (tmp_path / "taken" / "mine").read_text() == "mine"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "taken"]


def test_rows_of_csv_read_back_exactly():
    values = np.array([[0.1, -0.0, 1e-300], [1 / 3, np.inf, 2.0]])
    lines = csv_rows(values).splitlines()
    assert lines[0] == "0.1,-0.0,1e-300"
    np.testing.assert_array_equal([[float(cell) for cell in line.split(",")] for line in lines], values)
