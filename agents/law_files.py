"""Learned laws, and states of learning, as files: one NPZ with the arrays and a JSON header that describes them.

Learning that goes on from a file of its state comes to the same bits as if it had never stopped.
"""

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, fields
from hashlib import sha256
from pathlib import Path
from typing import Any, ClassVar, Self

import numpy as np

from ffgym.control import FeedForwardLaw
from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.files import check_writable, decode_arrays, encode_arrays, read_bytes, write_bytes
from ffgym.core.plugins import load_families
from ffgym.core.provenance import versions
from ffgym.core.typed_json import parse_json
from ffgym.core.types import Array

FORMAT = 1
"""Version of the file format; see docs/agents/files.md."""

LARGEST = 1e30
"""Largest number of a law's arrays; chosen: far beyond any weight, and products of some stay finite."""

KINDS: dict[str, type["StoredLaw"]] = {}
"""Classes of laws by the kind of their files; each class enters itself."""


class StoredLaw:
    """A law that can be written to a file and read back, bit for bit."""

    kind: ClassVar[str]
    """Word in the header of its files, which no other class has."""

    def __init_subclass__(cls, **options: Any) -> None:
        """Let files of this kind be read.

        Raises:
            FFGymError: if another class has files of this kind.
        """
        super().__init_subclass__(**options)
        if "kind" in vars(cls):
            known = KINDS.setdefault(cls.kind, cls)
            if (known.__module__, known.__qualname__) != (cls.__module__, cls.__qualname__):
                raise FFGymError(f"{cls.__qualname__}: {known.__qualname__} has files of kind {cls.kind!r} already.")

    def parts(self) -> tuple[dict[str, Any], dict[str, Array]]:
        """Split the law into settings that JSON can hold and arrays; by default the fields of a dataclass."""
        values = {each.name: getattr(self, each.name) for each in fields(self)}  # type: ignore[arg-type]
        arrays = {name: value for name, value in values.items() if isinstance(value, np.ndarray)}
        return {name: value for name, value in values.items() if name not in arrays}, arrays

    @classmethod
    def from_parts(cls, settings: Mapping[str, Any], arrays: Mapping[str, Array]) -> Self:
        """Rebuild the law from its parts.

        Raises:
            FFGymError: if a part is missing or wrong.
        """
        missing = {each.name for each in fields(cls)} - {*settings, *arrays}  # type: ignore[arg-type]
        if missing:
            raise FFGymError(f"the file lacks {', '.join(sorted(missing))}.")
        return cls(**settings, **arrays)


def save_law(path: str | os.PathLike[str], law: StoredLaw, meta: Mapping[str, Any] | None = None) -> Path:
    """Write a law, whole or not at all; `meta` is kept in the header, e.g. how it was learned.

    Raises:
        FFGymError: if the file cannot be written, or its name does not end in .npz.
    """
    target = npz_target(path, "law")
    settings, arrays = law.parts()
    header = {
        "format": FORMAT,
        "kind": law.kind,
        "settings": settings,
        "meta": dict(meta or {}),
        "versions": versions(),
    }
    write_bytes(target, pack(header, arrays))
    return target


def npz_target(path: str | os.PathLike[str], what: str) -> Path:
    """Check the name of a file to be written, and return its path.

    Raises:
        FFGymError: if it cannot be written, or its name does not end in .npz.
    """
    target = Path(path)
    if target.suffix != ".npz":
        raise FFGymError(f"{path}: the name of a {what}'s file must end in .npz.")
    check_writable(target)
    return target


def load_law(path: str | os.PathLike[str]) -> FeedForwardLaw:
    """Read a law that `save_law` wrote.

    Raises:
        FFGymError: if the file is missing or damaged, or holds something else.
    """
    header, arrays = unpack(path)
    kind = str(header.get("kind"))
    if kind not in KINDS:
        load_families("ffgym.agents")
    stored = KINDS[check_choice(f"kind of law in {path}", kind, list(KINDS))]
    try:
        for name, values in arrays.items():
            if values.dtype.kind == "f" and np.any(np.abs(values) > np.float64(LARGEST)):
                raise FFGymError(f"{name} must be finite, and {LARGEST:g} at most in size.")
        law: Any = stored.from_parts(header["settings"], arrays)
        if not isinstance(law.name, str):
            raise FFGymError(f"name = {law.name!r} must be text.")
    except (KeyError, TypeError, FFGymError) as error:
        reason = str(error).rstrip(".")
        raise FFGymError(f"{path}: holds no complete law of kind {kind!r}: {reason}. Train it again.") from error
    found: FeedForwardLaw = law
    return found


def pack(header: Mapping[str, Any], arrays: Mapping[str, Array]) -> bytes:
    """Encode an NPZ file with a JSON header; equal contents give equal bytes."""
    return encode_arrays({"header": np.array(json.dumps(header, sort_keys=True, allow_nan=False)), **arrays})


def unpack(path: str | os.PathLike[str]) -> tuple[dict[str, Any], dict[str, Array]]:
    """Read header and arrays of a file that `pack` made.

    Raises:
        FFGymError: if the file is missing, damaged, or of another format.
    """
    data = read_bytes(path)
    try:
        arrays = decode_arrays(data)
        header = parse_json(str(arrays.pop("header", "")), "its header")
    except FFGymError as error:
        raise FFGymError(f"{path}: is damaged or no file of ffgym: {error}") from error
    if not isinstance(header, dict) or header.get("format") != FORMAT:
        found = header.get("format") if isinstance(header, dict) else header
        raise FFGymError(f"{path}: has format {found!r}, this version of ffgym reads {FORMAT}.")
    for name, values in arrays.items():
        if values.dtype.kind not in "biufU":
            raise FFGymError(f"{path}: {name} is {values.dtype}, must be real numbers or text.")
    for name in ("settings", "meta"):
        if not isinstance(header.get(name, {}), dict):
            raise FFGymError(f"{path}: {name} = {header[name]!r} in its header must be an object.")
    return header, arrays


def digest(*arrays: Array) -> str:
    """Hash arrays to a short text, equal for equal shapes and bits."""
    total = sha256()
    for array in arrays:
        total.update(repr(array.shape).encode())
        total.update(np.ascontiguousarray(array).tobytes())
    return total.hexdigest()[:16]


@dataclass(frozen=True, kw_only=True)
class StateFile:
    """State of learning on disk, written whole or not at all."""

    path: Path
    kind: str
    """Kind of the file, beside those of laws."""
    settings: Mapping[str, Any]
    """Settings that must be the same for learning to go on; JSON can hold them."""

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
        """Read the arrays of the file; return None where there is no file yet.

        Raises:
            FFGymError: if the file is damaged, or of learning with other settings; the message names them.
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
    """Check that settings kept in a file or folder equal the wanted ones; else it holds `what`, e.g. another training.

    Raises:
        FFGymError: if they differ; the message names the settings.
    """

    def short(value: Any) -> str:
        text = repr(value)
        return text if len(text) <= 60 else f"{text[:57]}..."

    flat, own = _flat(theirs), _flat(ours)
    changes = [
        f"{name} was {short(flat.get(name))}, now {short(own.get(name))}"
        for name in sorted(set(flat) | set(own))
        if flat.get(name) != own.get(name)
    ]
    if changes:
        raise FFGymError(f"{place}: holds {what}: {'; '.join(changes)}. {way_out}")


def _flat(values: Mapping[str, Any]) -> dict[str, Any]:
    """Flatten nested tables to entries by one name each."""
    flat: dict[str, Any] = {}
    for name, value in values.items():
        if isinstance(value, Mapping):
            flat |= {f"{name}.{inner}": each for inner, each in _flat(value).items()}
        else:
            flat[name] = value
    return flat
