"""Files that keep learning between program runs: resumed, it goes on to the same bits as if never stopped."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ffgym.agents.law_files import FORMAT, pack, unpack
from ffgym.core.errors import FFGymError
from ffgym.core.files import check_writable, write_bytes
from ffgym.core.provenance import versions
from ffgym.core.types import Array


@dataclass(frozen=True, kw_only=True)
class StateFile:
    """Arrays of some learning on disk, written whole or not at all."""

    path: Path
    kind: str
    """Kind of the file, beside those of laws."""
    settings: Mapping[str, Any]
    """What must be the same for learning to go on; JSON can hold it."""

    def __post_init__(self) -> None:
        check_writable(self.path)

    def write(self, arrays: Mapping[str, Array]) -> None:
        """Replace the file.

        Raises:
            FFGymError: if it cannot be written.
        """
        header = {"format": FORMAT, "kind": self.kind, "settings": dict(self.settings), "versions": versions()}
        write_bytes(self.path, pack(header, arrays))

    def read(self) -> dict[str, Array] | None:
        """Arrays of the file; None where there is no file yet.

        Raises:
            FFGymError: if the file is damaged, or of learning with other settings; the message says which.
        """
        if not self.path.exists():
            return None
        header, arrays = unpack(self.path)
        if header.get("kind") != self.kind:
            raise FFGymError(f"{self.path}: is a file of kind {header.get('kind')!r}, not of learning to go on with.")
        theirs, ours = header.get("settings"), json.loads(json.dumps(dict(self.settings)))  # as a file gives them back
        way_out = "Go on with the same, or begin anew with another file."
        check_same(theirs if isinstance(theirs, dict) else {}, ours, self.path, "other learning", way_out)
        return arrays


def check_same(theirs: Mapping[str, Any], ours: Mapping[str, Any], place: Path, what: str, way_out: str) -> None:
    """Check that a file or folder is of what is asked for, and of nothing else.

    Args:
        theirs: settings that are kept in it.
        ours: settings of what is asked for.
        place: the file or folder.
        what: it would hold otherwise, e.g. 'another training'.
        way_out: end of the message.

    Raises:
        FFGymError: if they differ; the message says in what.
    """
    flat, own = _flat(theirs), _flat(ours)
    changes = [
        f"{name} was {_short(flat.get(name))}, now {_short(own.get(name))}"
        for name in sorted(set(flat) | set(own))
        if flat.get(name) != own.get(name)
    ]
    if changes:
        raise FFGymError(f"{place}: holds {what}: {'; '.join(changes)}. {way_out}")


def _flat(values: Mapping[str, Any]) -> dict[str, Any]:
    """Entries of tables in tables by one name each."""
    flat: dict[str, Any] = {}
    for name, value in values.items():
        if isinstance(value, Mapping):
            flat |= {f"{name}.{inner}": each for inner, each in _flat(value).items()}
        else:
            flat[name] = value
    return flat


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
