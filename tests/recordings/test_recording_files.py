import errno
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from recording_samples import header, recording, recordings, refused

from ffgym.recordings import Recording, read_recording, write_recording
from ffgym.recordings.io import FORMATS

SUFFIXES = tuple(FORMATS)
EXTREMES = [5e-324, -5e-324, 2.2250738585072014e-308, -0.0, 0.0, 1.7976931348623157e308, 0.1, 1 / 3, 1e22, -1e-7]
shared_folder = settings(suppress_health_check=[HealthCheck.function_scoped_fixture])


@pytest.mark.parametrize("suffix", SUFFIXES)
@given(rec=recordings())
def test_encoding_round_trip_keeps_every_bit(suffix: str, rec: Recording) -> None:
    encode, decode = FORMATS[suffix]
    data = encode(rec)
    read = decode(data, None)
    assert read.equals(rec)
    assert list(read.columns) == list(rec.columns)
    assert encode(read) == data


@pytest.mark.parametrize("suffix", [*SUFFIXES, ".CSV"])
def test_file_round_trip_keeps_extreme_numbers_and_missing_samples(suffix: str, tmp_path: Path) -> None:
    odd_nan = np.array([0xFFF8000000000123], dtype=np.uint64).view(np.float64)[0]
    table = {"timestamp": range(11), "user.x": [*EXTREMES, 1.0], "tcp.timestamp": [*EXTREMES, odd_nan]}
    rec = Recording(table, header(units={"user.x": "1"}))
    path = tmp_path / f"motion{suffix}"
    write_recording(rec, path)
    assert read_recording(str(path)).equals(rec)
    assert os.listdir(tmp_path) == [path.name]


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_given_header_replaces_the_one_in_the_file(suffix: str, tmp_path: Path) -> None:
    write_recording(recording(), tmp_path / f"motion{suffix}")
    assert read_recording(tmp_path / f"motion{suffix}", header=header(robot="mine")).header.robot == "mine"


@pytest.mark.parametrize("name", ["motion", "motion.parquet", "motion.csv.gz"])
def test_unknown_suffix_is_refused(name: str, tmp_path: Path) -> None:
    for act in (lambda: write_recording(recording(), tmp_path / name), lambda: read_recording(tmp_path / name)):
        with refused("is unknown, must be one of .csv, .npz"):
            act()


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_unreadable_path_is_refused(suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / f"motion{suffix}"
    with refused(f"{path}: no such file"):
        read_recording(path)
    path.touch()
    with refused(f"{path}: the file is empty"):
        read_recording(path)
    folder = tmp_path / f"folder{suffix}"
    folder.mkdir()
    with refused(f"{folder}: is a folder"):
        read_recording(folder)
    with refused(f"{path / path.name}: cannot be read: Not a directory"):
        read_recording(path / path.name)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_damaged_file_is_named(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"motion{suffix}"
    path.write_bytes(b"\x00\xff damage")
    with refused(f"{path}: "):
        read_recording(path)


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("call", ["fsync", "replace"])
@pytest.mark.parametrize("failure", [OSError(errno.ENOSPC, "No space left on device"), KeyboardInterrupt()])
def test_interrupted_write_leaves_the_old_file_and_nothing_else(
    suffix: str, call: str, failure: BaseException, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / f"motion{suffix}"
    write_recording(recording(), path)
    old = path.read_bytes()

    def fail(*_: Any) -> None:
        raise failure

    monkeypatch.setattr(os, call, fail)
    expected = refused(f"{path}: cannot be written: No space left on device") if isinstance(failure, OSError) else None
    with expected or pytest.raises(KeyboardInterrupt):
        write_recording(recording(9), path)
    assert path.read_bytes() == old
    assert os.listdir(tmp_path) == [path.name]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs the device that is always full")
def test_full_disk_is_reported_while_writing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "motion.csv"
    real_open = open
    monkeypatch.setattr(
        "builtins.open", lambda name, mode="r", **kw: real_open("/dev/full" if mode == "wb" else name, mode, **kw)
    )
    with refused("cannot be written: No space left on device"):
        write_recording(recording(), path)
    assert os.listdir(tmp_path) == []


def test_missing_folder_is_reported(tmp_path: Path) -> None:
    with refused("cannot be written: No such file or directory. The folder must exist"):
        write_recording(recording(), tmp_path / "absent" / "motion.npz")


def test_folder_in_the_way_is_reported(tmp_path: Path) -> None:
    (tmp_path / "motion.npz").mkdir()
    with refused("cannot be written: Is a directory"):
        write_recording(recording(), tmp_path / "motion.npz")
    assert os.listdir(tmp_path) == ["motion.npz"]


def test_write_goes_through_a_link_and_gives_ordinary_permissions(tmp_path: Path) -> None:
    target, link, plain = tmp_path / "target.npz", tmp_path / "link.npz", tmp_path / "plain"
    link.symlink_to(target)
    plain.touch()
    write_recording(recording(), link)
    assert link.is_symlink()
    assert read_recording(target).equals(recording())
    assert target.stat().st_mode == plain.stat().st_mode
