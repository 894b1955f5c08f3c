"""The file that keeps learning between program runs: resumed, it goes on to the same bits as if never stopped."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ffgym.agents.common.law_files import FORMAT, pack, unpack
from ffgym.agents.common.network import Network
from ffgym.agents.learning.progress import Learning
from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.files import check_writable, write_bytes
from ffgym.core.provenance import versions
from ffgym.core.types import Array

KIND = "learning"
"""Kind of the file, beside those of laws."""
_ROWS = ("error", "signal", "best_trial", "stale", "locked")
_NETWORKS = ("network", "best")


@dataclass(frozen=True, kw_only=True)
class LearningFile:
    """Learning on disk, written whole or not at all."""

    path: Path
    settings: Mapping[str, Any]
    """What must be the same for learning to go on; JSON can hold it."""

    def __post_init__(self) -> None:
        check_writable(self.path)

    def write(self, learning: Learning) -> None:
        """Replace the file.

        Raises:
            FFGymError: if it cannot be written.
        """
        header = {"format": FORMAT, "kind": KIND, "settings": dict(self.settings), "versions": versions()}
        arrays = {name: getattr(learning, name) for name in _ROWS}
        for role in _NETWORKS:
            arrays |= {f"{role}.{name}": weights for name, weights in getattr(learning, role).weights.items()}
        write_bytes(self.path, pack(header, arrays))

    def read(self, first: Network, n_motions: int) -> Learning:
        """Learning in the file, or its beginning with the network `first` where there is no file yet.

        Raises:
            FFGymError: if the file is damaged or incomplete, or of learning with other settings; the message says
                which.
        """
        if not self.path.exists():
            return Learning.begin(first, n_motions)
        header, arrays = unpack(self.path)
        if header.get("kind") != KIND:
            raise FFGymError(f"{self.path}: is a file of kind {header.get('kind')!r}, not of learning to go on with.")
        settings = header.get("settings")
        self._check(settings if isinstance(settings, dict) else {})
        try:
            return _learning(first, n_motions, arrays)
        except (KeyError, FFGymError) as error:
            reason = str(error).rstrip(".")
            raise FFGymError(
                f"{self.path}: holds no complete learning: {reason}. Begin anew with another file."
            ) from error

    def _check(self, stored: Mapping[str, Any]) -> None:
        wanted = json.loads(json.dumps(dict(self.settings)))  # as a file gives them back
        differing = [name for name in sorted(stored.keys() | wanted.keys()) if stored.get(name) != wanted.get(name)]
        if differing:
            found = ", ".join(f"{name} {stored.get(name)!r}, now {wanted.get(name)!r}" for name in differing)
            raise FFGymError(
                f"{self.path}: learning cannot go on with other settings than it began with: {found}. "
                f"Go on with the same, or begin anew with another file."
            )


def _learning(first: Network, n_motions: int, arrays: Mapping[str, Array]) -> Learning:
    n = first.n_joints
    network, best = (
        first.with_weights({name: arrays[f"{role}.{name}"] for name in first.weights}) for role in _NETWORKS
    )
    error = check_shape("error", arrays["error"], (None, n_motions, n))
    signal = check_shape("signal", arrays["signal"], error.shape)
    best_trial, stale, locked = (check_shape(name, arrays[name], (n,)) for name in ("best_trial", "stale", "locked"))
    return Learning(
        network=network,
        best=best,
        error=error,
        signal=signal,
        best_trial=best_trial.astype(np.intp),
        stale=stale.astype(np.intp),
        locked=locked.astype(np.bool_),
    )
