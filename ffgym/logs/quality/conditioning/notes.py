"""Notes of what conditioning did, in the header; and masks, in the columns."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.recordings import Header, Recording
from ffgym.recordings.schema import VALID

KEY = "conditioning"
"""Key of `meta` in the header: a list of sentences."""


def notes_of(recording: Recording) -> tuple[str, ...]:
    """Sentences on what conditioning did to a recording, empty if it did nothing."""
    notes = recording.header.meta.get(KEY, [])
    return tuple(map(str, notes)) if isinstance(notes, list) else (str(notes),)


def noted(header: Header, *notes: str) -> Header:
    """The header with more notes."""
    before = header.meta.get(KEY, [])
    return replace(header, meta={**header.meta, KEY: [*(before if isinstance(before, list) else [before]), *notes]})


def amended(recording: Recording, columns: Mapping[str, Array], masked: BoolArray, *notes: str) -> Recording:
    """The recording with some columns replaced, and rows `masked` (T, N) left out, too."""
    found = {**recording.columns, **columns}
    if masked.any():
        found |= mask_columns(recording.header, recording.valid & ~masked)
    return Recording(found, noted(recording.header, *notes))


def mask_columns(header: Header, valid: BoolArray) -> dict[str, Array]:
    """Columns of the mask `valid` (T, N), by name."""
    return {f"{VALID}.{joint}": rows.astype(np.float64) for joint, rows in zip(header.joints, valid.T, strict=True)}


def count(number: int, one: str) -> str:
    """A number with its noun: 1 row, 2 rows."""
    return f"{number} {one}" if number == 1 else f"{number} {one}s"
