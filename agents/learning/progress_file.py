"""The file that keeps learning between program runs: resumed, it goes on to the same bits as if never stopped."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from agents.common.law_files import FORMAT, pack, unpack
from agents.common.network import Network
from agents.learning.progress import Learning
from ffgym.errors import FFGymError
from ffgym.files import check_writable, write_bytes
from ffgym.provenance import versions

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
            FFGymError: if the file is damaged, or of learning with other settings; the message says which.
        """
        if not self.path.exists():
            return Learning.begin(first, n_motions)
        header, arrays = unpack(self.path)
        if header.get("kind") != KIND:
            raise FFGymError(f"{self.path}: is a file of kind {header.get('kind')!r}, not of learning to go on with.")
        self._check(header["settings"])
        network, best = (
            first.with_weights({name: arrays[f"{role}.{name}"] for name in first.weights}) for role in _NETWORKS
        )
        rows: dict[str, Any] = {name: arrays[name] for name in _ROWS}
        return Learning(network=network, best=best, **rows)

    def _check(self, stored: Mapping[str, Any]) -> None:
        wanted = json.loads(json.dumps(dict(self.settings)))  # as a file gives them back
        differing = [name for name in sorted(stored.keys() | wanted.keys()) if stored.get(name) != wanted.get(name)]
        if differing:
            found = ", ".join(f"{name} {stored.get(name)!r}, now {wanted.get(name)!r}" for name in differing)
            raise FFGymError(
                f"{self.path}: learning cannot go on with other settings than it began with: {found}. "
                f"Go on with the same, or begin anew with another file."
            )
