"""Mutation of a file by its format: as the tree, archive, table or text that it is, or as bare bytes."""

import gzip
import json
import sqlite3
import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Xml

import numpy as np

from ffgym.core.toml import toml_key, toml_value
from scripts.fuzz.archives import mutate_archive, mutate_array
from scripts.fuzz.raw import mutate_bytes, mutate_text
from scripts.fuzz.trees import mutate_tree
from scripts.fuzz.values import odd_value, write_markers

_BINARY = {".npz", ".zip", ".mat", ".h5", ".parquet", ".db3", ".mcap", ".bag", ".gz", ".bin", ".onnx"}
"""Suffixes of files that are no text."""


def mutate_file(name: str, data: bytes, rng: np.random.Generator) -> bytes:
    """Change the content of a file: by the format of its name if there is a mutation for it, or as text or bytes."""
    suffix = Path(name).suffix.lower()
    structured, share = _STRUCTURED.get(suffix), rng.random()
    if structured is not None and share < 0.6:
        try:
            return structured(data, rng)
        except Exception:  # an earlier change left a file that is none of its format
            return mutate_bytes(data, rng)
    if suffix in _BINARY or share > 0.85:
        return mutate_bytes(data, rng)
    return _encode(mutate_text(data.decode("utf-8", "surrogateescape"), rng))


def _encode(text: str) -> bytes:
    """Encode text; what UTF-8 has no form for becomes bytes that are no UTF-8."""
    return text.encode("utf-8", "surrogatepass")


def _mutate_json(data: bytes, rng: np.random.Generator) -> bytes:
    return _encode(write_markers(json.dumps(mutate_tree(json.loads(data), rng))))


def _mutate_toml(data: bytes, rng: np.random.Generator) -> bytes:
    return _encode(write_markers(_toml(mutate_tree(tomllib.loads(data.decode()), rng))))


def _toml(tree: Any) -> str:
    """Write tables inline, one entry a line; TOML has no null, which becomes a word."""
    if not isinstance(tree, dict):
        return str(tree)
    return "".join(f"{toml_key(str(key))} = {toml_value(_without_null(value))}\n" for key, value in tree.items())


def _without_null(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _without_null(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [_without_null(entry) for entry in value]
    return "null" if value is None else value


def _mutate_npz(data: bytes, rng: np.random.Generator) -> bytes:
    return mutate_archive(data, rng, mutate_array)


def _mutate_zip(data: bytes, rng: np.random.Generator) -> bytes:
    return mutate_archive(data, rng, mutate_file)


def _mutate_gzip(data: bytes, rng: np.random.Generator) -> bytes:
    text = gzip.decompress(data).decode("utf-8", "surrogateescape")
    return gzip.compress(_encode(mutate_text(text, rng)), 1, mtime=0)


def _mutate_sqlite(data: bytes, rng: np.random.Generator) -> bytes:
    """Put another value into a cell, drop a row or a table."""
    base = sqlite3.connect(":memory:")
    base.deserialize(data)
    tables = [name for (name,) in base.execute("select name from sqlite_master where type = 'table'")]
    table = str(rng.choice(tables))
    columns = [row[1] for row in base.execute(f"pragma table_info({table})")]
    rows = [row for (row,) in base.execute(f"select rowid from {table}")]
    # a table of the same rows, without the rules of the first one
    base.execute(f"create table free as select * from {table}")
    base.execute(f"drop table {table}")
    base.execute(f"alter table free rename to {table}")
    kind = rng.integers(10)
    if kind == 0 or not rows:
        base.execute(f"drop table {table}")
    elif kind == 1:
        base.execute(f"delete from {table} where rowid = ?", (int(rng.choice(rows)),))
    else:
        column, value = str(rng.choice(columns)), _cell(rng)
        base.execute(f"update {table} set {column} = ? where rowid = ?", (value, int(rng.choice(rows))))
    base.commit()
    changed = base.serialize()
    base.close()
    return changed


def _cell(rng: np.random.Generator) -> Any:
    value = odd_value(rng)
    if isinstance(value, int) and not -(2**63) <= value < 2**63:
        return None
    if isinstance(value, str):
        return value.encode("utf-8", "surrogatepass") if rng.random() < 0.5 else value.replace("\ud800", "?")
    return value if isinstance(value, int | float) else None


def _mutate_xml(data: bytes, rng: np.random.Generator) -> bytes:
    """Delete, repeat, move, rename or nest an element, or change one of its attributes."""
    root = Xml.fromstring(data)
    parents = [(parent, child) for parent in root.iter() for child in parent]
    parent, element = parents[rng.integers(len(parents))]
    other = parents[rng.integers(len(parents))][0]
    kind = rng.integers(12)
    if kind == 0:
        parent.remove(element)
    elif kind == 1:
        parent.extend([element] * int(rng.choice([1, 2, 500])))
    elif kind == 2:
        other.append(Xml.fromstring(Xml.tostring(element)))
    elif kind == 3:
        element.tag = str(
            rng.choice(["joint", "body", "geom", "link", "inertial", "replicate", "include", "frame", "x"])
        )
    elif kind == 4:
        parent.remove(element)
        wrapping = Xml.SubElement(parent, "replicate", count=str(rng.choice([0, 2, 100_000_000])), offset="0 0 1")
        wrapping.append(element)
    elif kind == 5:
        for _ in range(int(rng.choice([2, 50, 5000]))):
            element = Xml.SubElement(element, element.tag, element.attrib)
    elif element.attrib:
        _mutate_attribute(element, rng)
    return _encode(Xml.tostring(root, encoding="unicode"))


def _mutate_attribute(element: Xml.Element, rng: np.random.Generator) -> None:
    name = str(rng.choice(sorted(element.attrib)))
    value = element.attrib[name]
    if rng.random() < 0.15:
        del element.attrib[name]
    elif rng.random() < 0.5:
        element.attrib[name] = mutate_text(value, rng)
    else:
        element.attrib[name] = str(odd_value(rng)) if rng.random() < 0.5 else f"{value} {odd_value(rng)}"


_STRUCTURED: Mapping[str, Callable[[bytes, np.random.Generator], bytes]] = {
    ".json": _mutate_json,
    ".toml": _mutate_toml,
    ".npz": _mutate_npz,
    ".zip": _mutate_zip,
    ".gz": _mutate_gzip,
    ".db3": _mutate_sqlite,
    ".xml": _mutate_xml,
    ".urdf": _mutate_xml,
    ".pgf": _mutate_xml,
}
