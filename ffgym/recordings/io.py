"""Recording files: the suffix chooses the format, a file is replaced whole or not at all."""

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from ffgym.core.errors import FFGymError
from ffgym.core.files import read_bytes, write_bytes
from ffgym.recordings import csv, npz
from ffgym.recordings.header import Header
from ffgym.recordings.recording import Recording


class Format(NamedTuple):
    """A file format, as functions between a recording and the bytes of a file."""

    encode: Callable[[Recording], bytes]
    decode: Callable[[bytes, Header | None], Recording]


FORMATS: Mapping[str, Format] = MappingProxyType(
    {".csv": Format(csv.encode, csv.decode), ".npz": Format(npz.encode, npz.decode)}
)
"""Formats by suffix."""


def write_recording(recording: Recording, path: str | os.PathLike[str]) -> None:
    """Write `recording` to `path`, which ends in .npz or .csv; both keep every bit.

    The file appears complete under its name, or an old file of that name stays as it was.

    Raises:
        FFGymError: if the suffix is unknown or the file cannot be written.
    """
    write_bytes(path, _format_of(path).encode(recording))


def read_recording(path: str | os.PathLike[str], header: Header | None = None) -> Recording:
    """Read the recording in `path`, which ends in .npz or .csv.

    Args:
        path: the file.
        header: used in place of the header of the file; needed for a file from another tool.

    Raises:
        FFGymError: if the file cannot be read, or is not a valid recording; the message begins with the path.
    """
    decode = _format_of(path).decode
    data = read_bytes(path)
    try:
        return decode(data, header)
    except FFGymError as error:
        raise FFGymError(f"{os.fspath(path)}: {error}") from error


def _format_of(path: str | os.PathLike[str]) -> Format:
    suffix = Path(path).suffix.lower()
    if suffix not in FORMATS:
        raise FFGymError(f"{os.fspath(path)}: suffix {suffix!r} is unknown, must be one of {', '.join(FORMATS)}.")
    return FORMATS[suffix]
