"""Recordings as NPZ: one float64 array per column, and the header as JSON text under `header`."""

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.files import decode_arrays, encode_arrays
from ffgym.recordings.header import Header
from ffgym.recordings.recording import Recording

HEADER_KEY = "header"


def encode(recording: Recording) -> bytes:
    """Return the bytes of an NPZ file; equal recordings with columns in the same order give equal bytes."""
    return encode_arrays({HEADER_KEY: np.array(recording.header.to_json()), **recording.columns})


def decode(data: bytes, header: Header | None = None) -> Recording:
    """Return the recording in the bytes of an NPZ file; a `header` replaces its own, or makes up for its lack."""
    arrays = decode_arrays(data)
    stored = arrays.pop(HEADER_KEY, None)
    if header is None:
        if stored is None:
            raise FFGymError(Header.how_to_pass("This NPZ file has no 'header' entry"))
        if stored.ndim != 0 or stored.dtype.kind != "U":
            raise FFGymError(f"The 'header' entry must be JSON text, got {stored.dtype} of shape {stored.shape}.")
        header = Header.from_json(str(stored))
    return Recording(arrays, header)
