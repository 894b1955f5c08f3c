"""Mutation of NPZ and other ZIP files, entry by entry; checksums are made again, so that damage reaches the reader."""

import io
import json
import warnings
import zipfile
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scripts.fuzz.raw import mutate_bytes
from scripts.fuzz.trees import mutate_tree
from scripts.fuzz.values import NUMBERS, TEXTS, write_markers

Entries = list[tuple[str, bytes]]
"""Names and contents; a name may come twice."""
Rewrite = Callable[[str, bytes, np.random.Generator], bytes]
"""Function that changes the content of an entry, by its name."""

_TYPES = ("<f4", ">f8", "<i8", "<u1", "?", "<c16", "<U3", "S3", "<M8[ns]", "<m8[s]", "<f2", "V4")
"""Types of arrays that readers may get instead of float64."""


def mutate_archive(data: bytes, rng: np.random.Generator, rewrite: Rewrite) -> bytes:
    """Change a ZIP file: an entry goes, comes twice, takes another name or content; `rewrite` changes most contents."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        entries = [(entry.filename, archive.read(entry)) for entry in archive.infolist()]
    if not entries:
        return mutate_bytes(data, rng)
    k, other = (int(rng.integers(len(entries))) for _ in range(2))
    kind = rng.integers(12)
    name, content = entries[k]
    if kind == 0:
        del entries[k]
    elif kind == 1:
        entries.append((name, entries[other][1]))
    elif kind == 2:
        entries[k] = (TEXTS[rng.integers(len(TEXTS))][:60_000], content)
    elif kind == 3:
        entries[k] = (name, entries[other][1])
    elif kind == 4:
        entries[k] = (name, mutate_bytes(content, rng))
    else:
        entries[k] = (name, rewrite(name, content, rng))
    return _pack(entries, zipfile.ZIP_DEFLATED if rng.random() < 0.3 else zipfile.ZIP_STORED)


def _pack(entries: Entries, compression: int) -> bytes:
    buffer = io.BytesIO()
    with warnings.catch_warnings(), zipfile.ZipFile(buffer, "w", compression) as archive:
        warnings.simplefilter("ignore")  # of a name that comes twice
        for name, content in entries:
            safe = name.encode("utf-8", "replace").decode()
            entry = zipfile.ZipInfo(safe or "nameless")
            entry.filename = safe
            archive.writestr(entry, content, compression)
    return buffer.getvalue()


def mutate_array(name: str, content: bytes, rng: np.random.Generator) -> bytes:
    """Change one array of an NPZ file: JSON text as a tree; else values, length, shape, type or head."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of numbers in a damaged head that overflow
            array = np.load(io.BytesIO(content), allow_pickle=False)
    except Exception:  # damaged by an earlier change
        return mutate_bytes(content, rng)
    if array.dtype.kind == "U" and array.ndim == 0 and str(array).startswith("{"):
        tree = mutate_tree(json.loads(str(array)), rng)
        return _npy(np.array(write_markers(json.dumps(tree))))
    if rng.random() < 0.15:
        return _other_head(content, array, rng)
    changed = _CHANGES[rng.integers(len(_CHANGES))](array, rng)
    return _npy(np.asarray(changed))


def _npy(array: NDArray[Any]) -> bytes:
    buffer = io.BytesIO()
    np.lib.format.write_array(buffer, array, allow_pickle=True)
    return buffer.getvalue()


def _other_head(content: bytes, array: NDArray[Any], rng: np.random.Generator) -> bytes:
    """Write another shape, type or order into the head of the array's file; its numbers stay as they are."""
    shapes = (0, -1, 10**6, 10**12, 2**63, 10**40)
    shape = tuple(int(rng.choice(np.array(shapes, dtype=object))) for _ in range(int(rng.integers(4))))
    kind = rng.integers(3)
    head = {
        "descr": str(rng.choice(_TYPES)) if kind == 0 else "|O" if kind == 1 else array.dtype.str,
        "fortran_order": bool(rng.integers(2)),
        "shape": array.shape if kind < 2 else shape,
    }
    text = repr(head).encode()
    start = len(content) - array.nbytes
    return b"\x93NUMPY\x01\x00" + (len(text) + 1).to_bytes(2, "little") + text + b"\n" + content[max(start, 0) :]


def _odd_numbers(array: NDArray[Any], rng: np.random.Generator) -> NDArray[Any]:
    changed = array.astype(object) if array.dtype.kind not in "fiub" else array.astype(np.float64)
    flat = changed.reshape(-1)
    for place in rng.integers(0, max(flat.size, 1), size=int(rng.integers(1, 4))) if flat.size else ():
        value = NUMBERS[rng.integers(len(NUMBERS))]
        flat[place] = np.inf if isinstance(value, int) and abs(value) > 2**1000 else float(value)
    return changed if array.dtype.kind in "fiub" else array


def _scaled(array: NDArray[Any], rng: np.random.Generator) -> NDArray[Any]:
    if array.dtype.kind not in "fiub":
        return array
    with np.errstate(all="ignore"):
        return array.astype(np.float64) * float(rng.choice([0.0, -1.0, 1e9, 1e-9, 1e300, np.nan, np.inf, 1e-320]))


def _resized(array: NDArray[Any], rng: np.random.Generator) -> NDArray[Any]:
    if not array.ndim:
        return np.repeat(array, int(rng.integers(4)))
    axis = int(rng.integers(array.ndim))
    length = array.shape[axis]
    rows = int(rng.choice([0, 1, 2, max(length - 1, 0), length + 1, 2 * length]))
    return np.take(array, np.arange(rows) % length, axis=axis) if length else array


def _reshaped(array: NDArray[Any], rng: np.random.Generator) -> NDArray[Any]:
    kind = rng.integers(5)
    if kind == 0:
        return array.T
    if kind == 1:
        return array[None]
    if kind == 2:
        return array.reshape(-1)
    if kind == 3:
        return array.reshape(-1)[0] if array.size else array
    return np.flip(array)


def _retyped(array: NDArray[Any], rng: np.random.Generator) -> NDArray[Any]:
    if rng.random() < 0.1:
        return np.array([{"run": 1}, None], dtype=object)
    try:
        with np.errstate(all="ignore"):
            return array.astype(str(rng.choice(_TYPES)))
    except (ValueError, TypeError):
        return array.astype(object)


_CHANGES: tuple[Callable[[NDArray[Any], np.random.Generator], Any], ...]
_CHANGES = (_odd_numbers, _odd_numbers, _scaled, _resized, _reshaped, _retyped)
