"""A recording in an NPZ file that is read column by column: a long one need not fit into memory."""

import os
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any, Self, final

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.recordings.header import Header
from ffgym.recordings.io import read_recording
from ffgym.recordings.npz import HEADER_KEY
from ffgym.recordings.recording import Recording

SUFFIX = ".npz"
"""Suffix of files whose columns can be read one at a time."""


@final
class Stored:
    """A recording in a file. Only columns that are asked for are read, each time anew."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        """Open a file and read its header and the names of its columns.

        Raises:
            FFGymError: if it is no NPZ file with a header.
        """
        self._path, self._segment = Path(path), ""
        arrays = self._read((HEADER_KEY,))
        try:
            self._header = Header.from_json(str(arrays[HEADER_KEY]))
        except FFGymError as error:
            raise FFGymError(f"{self._path}: {error}") from error

    @property
    def header(self) -> Header:
        """What the columns mean."""
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
        """Samples of one column, shape (T,).

        Raises:
            FFGymError: if the file has no such column, it is no column of numbers, or it is damaged.
        """
        values = self._read((column,))[column]
        if values.ndim != 1 or values.dtype.kind not in "biuf":
            raise FFGymError(f"{self._path}: {column!r} must be real numbers, one for each row.")
        return np.asarray(values, dtype=np.float64)

    def renamed(self, segment: str) -> Self:
        """The same of a segment with another name."""
        other = type(self)(self._path)
        other._segment = segment
        return other

    def whole(self) -> Recording:
        """The recording with all its columns.

        Raises:
            FFGymError: if the file cannot be read, or is no valid recording.
        """
        recording = read_recording(self._path)
        return recording.renamed(self._segment) if self._segment else recording

    def _read(self, names: tuple[str, ...]) -> dict[str, Any]:
        try:
            with self._path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
                return {name: file[name] for name in names}
        except Exception as error:  # zipfile, zlib and numpy raise a dozen types for damaged bytes
            kind = type(error).__name__
            raise FFGymError(
                f"{self._path}: damaged, cut short, or without {', '.join(names)} ({kind}). Copy or make it again."
            ) from error
