"""Recordings as NPZ: one float64 array per column, and the header as JSON text under `header`."""

import io
from typing import Any

import numpy as np

from ffgym.errors import FFGymError
from ffgym.recordings.header import Header
from ffgym.recordings.recording import Recording

HEADER_KEY = "header"


def encode(recording: Recording) -> bytes:
    """Return the bytes of an NPZ file; equal recordings with columns in the same order give equal bytes."""
    buffer = io.BytesIO()
    arrays: dict[str, Any] = {HEADER_KEY: np.array(recording.header.to_json()), **recording.columns}
    np.savez(buffer, allow_pickle=False, **arrays)
    return buffer.getvalue()


def decode(data: bytes, header: Header | None = None) -> Recording:
    """Return the recording in the bytes of an NPZ file.

    Args:
        data: the whole file.
        header: replaces the header of the file, or makes up for its lack.

    Raises:
        FFGymError: if the file is damaged, has no header, or is not a valid recording.
    """
    arrays = _arrays(data)
    stored = arrays.pop(HEADER_KEY, None)
    if header is None:
        if stored is None:
            raise FFGymError(Header.how_to_pass("This NPZ file has no 'header' entry"))
        if stored.ndim != 0 or stored.dtype.kind != "U":
            raise FFGymError(f"The 'header' entry must be JSON text, got {stored.dtype} of shape {stored.shape}.")
        header = Header.from_json(str(stored))
    return Recording(arrays, header)


def _arrays(data: bytes) -> dict[str, Any]:
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as file:
            names = list(file.files)
            arrays = {name: file[name] for name in names}
    except Exception as error:  # zipfile, zlib and numpy raise a dozen types for damaged bytes
        reason = (str(error).splitlines() or [""])[0]
        raise FFGymError(
            f"Damaged, cut short or not NPZ ({type(error).__name__}: {reason}). Copy or record it again."
        ) from error
    if len(arrays) < len(names):
        twice = sorted({name for name in names if names.count(name) > 1})
        raise FFGymError(f"The NPZ file holds {', '.join(twice)} more than once. Keep one entry of each name.")
    for name, array in arrays.items():
        if not isinstance(array, np.ndarray):
            raise FFGymError(f"The NPZ entry {name!r} is not an array. Remove it, or record the file again.")
    return arrays
