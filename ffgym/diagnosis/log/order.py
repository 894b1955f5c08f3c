"""The order of recordings: by what is in them, so that a diagnosis does not depend on the order in which they came."""

import hashlib
from collections.abc import Sequence

import numpy as np

from ffgym.recordings import Recording


def by_content(recordings: Sequence[Recording]) -> tuple[Recording, ...]:
    """Recordings by the names of their motions, then by their numbers."""
    return tuple(sorted(recordings, key=lambda recording: (recording.header.segment, _digest(recording))))


def _digest(recording: Recording) -> bytes:
    digest = hashlib.sha256()
    for name in sorted(recording.columns):
        digest.update(name.encode() + b"\0" + np.ascontiguousarray(recording[name]).tobytes())
    return digest.digest()
