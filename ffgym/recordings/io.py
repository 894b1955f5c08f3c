"""Recording files: the suffix chooses the format, a file is replaced whole or not at all."""

import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any, Self, final

import numpy as np

from ffgym.core.errors import FFGymError, check_class, errors_at
from ffgym.core.files import is_file, read_arrays, read_bytes, read_text, write_bytes
from ffgym.core.typed_json import parse_json
from ffgym.core.types import Array
from ffgym.recordings import csv, npz
from ffgym.recordings.header import Header
from ffgym.recordings.npz import HEADER_KEY
from ffgym.recordings.recording import Recording

SUFFIX = ".npz"
"""Suffix of files whose columns can be read one at a time."""

INDEX = "protocol.json"
"""Name of the index that `ffgym record` writes beside its recordings."""


FORMATS: Mapping[str, tuple[Callable[[Recording], bytes], Callable[[bytes, Header | None], Recording]]]
FORMATS = MappingProxyType({".csv": (csv.encode, csv.decode), ".npz": (npz.encode, npz.decode)})
"""Functions from a recording to the bytes of a file, and back, by suffix."""


def write_recording(recording: Recording, path: str | os.PathLike[str]) -> None:
    """Write `recording` to `path`, which ends in .npz or .csv; both keep every bit.

    The file appears complete under its name, or an old file of that name stays as it was.

    Raises:
        FFGymError: if the suffix is unknown or the file cannot be written.
    """
    check_class("recording", recording, Recording, "read_recording makes one")
    encode, _ = FORMATS[_suffix_of(path)]
    write_bytes(path, encode(recording))


def read_recording(path: str | os.PathLike[str], header: Header | None = None) -> Recording:
    """Read the recording in `path`, which ends in .npz or .csv.

    Args:
        path: the file.
        header: used in place of the header of the file; needed for a file from another tool.

    Raises:
        FFGymError: if the file cannot be read, or is not a valid recording; the message begins with the path.
    """
    _, decode = FORMATS[_suffix_of(path)]
    data = read_bytes(path)
    try:
        return decode(data, header)
    except FFGymError as error:
        raise FFGymError(f"{os.fspath(path)}: {error}") from error


def _suffix_of(path: str | os.PathLike[str]) -> str:
    suffix = Path(path).suffix.lower()
    if suffix not in FORMATS:
        raise FFGymError(f"{os.fspath(path)}: suffix {suffix!r} is unknown, must be one of {', '.join(FORMATS)}.")
    return suffix


@final
class Stored:
    """Recording in a file, which reads columns one by one, each time anew."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        """Open an NPZ file and read its header."""
        self._path, self._segment = Path(path), ""
        arrays = self._read((HEADER_KEY,))
        try:
            self._header = Header.from_json(str(arrays[HEADER_KEY]))
        except FFGymError as error:
            raise FFGymError(f"{self._path}: {error}") from error

    @property
    def header(self) -> Header:
        """Meaning of the columns."""
        return replace(self._header, segment=self._segment) if self._segment else self._header

    @cached_property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns."""
        with self._path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
            return tuple(name for name in file.files if name != HEADER_KEY)

    @cached_property
    def t(self) -> Array:
        """Controller clock [s], shape (T,)."""
        return self["timestamp"]

    def __getitem__(self, column: str) -> Array:
        """Samples of one column, shape (T,)."""
        values = self._read((column,))[column]
        if values.ndim != 1 or values.dtype.kind not in "biuf":
            raise FFGymError(f"{self._path}: {column!r} must be real numbers, one for each row.")
        return np.asarray(values, dtype=np.float64)

    def rename(self, segment: str) -> Self:
        """Return the recording with another name of its segment."""
        other = type(self)(self._path)
        other._segment = segment
        return other

    def whole(self) -> Recording:
        """Read the recording with all its columns."""
        recording = read_recording(self._path)
        return recording.rename(self._segment) if self._segment else recording

    def _read(self, names: tuple[str, ...]) -> dict[str, Any]:
        with errors_at(str(self._path)):
            return read_arrays(self._path, names)


def read_folder(folder: str | os.PathLike[str]) -> list[Recording]:
    """Read the recordings in a folder, as `recording_files` finds them."""
    return [read_recording(file) for file in recording_files(folder)]


def recording_files(folder: str | os.PathLike[str]) -> list[Path]:
    """Find the files of recordings in a folder: in the order of its index; without an index all, by name.

    Raises:
        FFGymError: if the folder does not exist or is empty, or a recording of the index is missing.
    """
    place = Path(folder)
    if not place.is_dir():
        raise FFGymError(f"{place}: no such folder. Check the path; it is relative to {Path.cwd()}.")
    # without an index all recordings of the folder, else those that it lists
    index = read_index(place)
    if index is None:
        files = sorted(file for file in place.iterdir() if file.suffix.lower() in FORMATS)
    else:
        motions = index.get("motions")
        entries = motions if isinstance(motions, list) else []
        names = [entry.get("file") if isinstance(entry, dict) else None for entry in entries]
        files = [place / name for name in names if isinstance(name, str) and Path(name).name == name]
        if not files or len(files) < len(names):
            raise FFGymError(
                f"{place / INDEX} must list motions, each with the name of a file beside it. Remove it to read all "
                f"recordings that are there."
            )
        # an interrupted session lacks some
        missing = [file.name for file in files if not is_file(file)]
        if missing:
            raise FFGymError(
                f"{place}: {len(missing)} of {len(files)} recordings are missing, first {missing[0]}. Run the same "
                f"ffgym record again, which makes those that are missing, or take them out of {INDEX}."
            )
    if not files:
        raise FFGymError(f"{place}: holds no recordings ({', '.join(FORMATS)}).")
    return files


def read_index(folder: Path) -> dict[str, Any] | None:
    """Read the index of a folder; None if it has none, an error if it cannot be read."""
    path = folder / INDEX
    if not path.exists():
        return None
    index = parse_json(read_text(path), str(path), "Remove it to read all recordings beside it.")
    if not isinstance(index, dict):
        raise FFGymError(f"{path} must be a JSON object. Remove it to read all recordings beside it.")
    return index
