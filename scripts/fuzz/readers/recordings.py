"""Recordings: single files, files whose columns are read one by one, and folders of a session with its index."""

import json
from pathlib import Path

from ffgym.logs.quality import check_quality
from ffgym.recordings import Header, read_folder, read_recording, write_recording
from ffgym.recordings.csv import decode as decode_csv
from ffgym.recordings.csv import read_table
from ffgym.recordings.io import INDEX, Stored, read_index, recording_files
from ffgym.recordings.npz import decode as decode_npz
from ffgym.recordings.stretch import read_session_start
from scripts.fuzz.reader import Reader
from scripts.fuzz.readers.samples import small_recording, write_sample


def _npz(folder: Path) -> Path:
    return write_sample(folder / "log.npz")


def _csv(folder: Path) -> Path:
    return write_sample(folder / "log.csv")


def _session(folder: Path) -> Path:
    """Two recordings with the index that `ffgym record` writes."""
    names = [write_sample(folder / f"{k}.npz", f"motion {k}").name for k in range(2)]
    motions = [{"file": name, "motion": Path(name).stem} for name in names]
    (folder / INDEX).write_text(json.dumps({"robot": "press", "seed": 1, "motions": motions}), encoding="utf-8")
    return folder


def _stray(folder: Path) -> Path:
    """Recordings without an index."""
    write_recording(small_recording(), folder / "one.csv")
    return folder


def _read(path: Path) -> None:
    recording = read_recording(path)
    assert len(recording.t) == len(recording)
    read_session_start(recording.header)


def _read_stored(path: Path) -> None:
    stored = Stored(path)
    for name in stored.columns:
        stored[name]


READERS = (
    Reader(
        name="recording_npz",
        use=_read,
        makes=(_npz,),
        covers=(read_recording, decode_npz, Header.from_json, read_session_start),
        share=30,
    ),
    Reader(name="recording_csv", use=_read, makes=(_csv,), covers=(read_recording, decode_csv, read_table), share=20),
    Reader(name="recording_by_column", use=_read_stored, makes=(_npz,), covers=(Stored,), share=15),
    Reader(
        name="session",
        use=read_folder,
        makes=(_session, _stray),
        covers=(read_folder, recording_files, read_index),
        share=20,
    ),
    Reader(
        name="recording_checked",
        use=lambda path: check_quality(read_recording(path)),
        makes=(_npz, _csv),
        covers=(read_recording,),
        share=4,
    ),
)
