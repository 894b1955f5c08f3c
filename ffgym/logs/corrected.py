"""A corrected column map: the map of some files, or none for recordings, with what their wiring calls for."""

import os
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ffgym.core.files import write_text
from ffgym.core.toml import toml_key, toml_value
from ffgym.logs.column_map.load import load_columns, map_text
from ffgym.logs.column_map.rewire import rewiring_table
from ffgym.recordings.rewiring import Rewiring


def write_corrected(
    path: str | os.PathLike[str], rewiring: Rewiring, columns: str | Path | None, notes: Sequence[str] = ()
) -> None:
    """Write a map that, read with the same files, gives the corrected recordings.

    Args:
        path: file to write, .toml.
        rewiring: corrections of the recordings that were read.
        columns: map that they were read with, built-in or a file; None for recordings.
        notes: what was wrong, for comment lines.

    Raises:
        FFGymError: if it cannot be written.
    """
    tree: dict[str, Any] = {}
    if columns is not None:
        known = load_columns(columns)
        tree = tomllib.loads(map_text(columns))
        robot = tree.get("log", {}).get("robot", "")
        if robot.endswith(".toml"):
            tree["log"]["robot"] = os.path.relpath(known.folder / robot, Path(path).parent)
        rewiring = known.rewiring.then(rewiring)
    tree["rewire"] = rewiring_table(rewiring)
    head = ["# Column map with corrections that a fit of the wiring of the logs found:", *(f"# - {n}" for n in notes)]
    write_text(path, "\n".join([*head, "", *_tables("", tree)]) + "\n")


def _tables(prefix: str, tree: Mapping[str, Any]) -> list[str]:
    """Lines of a table and of the tables in it."""
    plain = {key: value for key, value in tree.items() if not _is_table(prefix, value)}
    lines = [f"[{prefix}]"] if prefix and plain else []
    lines += [f"{toml_key(key)} = {toml_value(value)}" for key, value in plain.items()]
    lines += [""] if plain else []
    for key, value in tree.items():
        if _is_table(prefix, value):
            lines += _tables(f"{prefix}.{toml_key(key)}" if prefix else toml_key(key), value)
    return lines


def _is_table(prefix: str, value: Any) -> bool:
    """Whether a value stands in a table of its own; those of [meta] and [log] are written in their line."""
    return isinstance(value, dict) and prefix.split(".")[0] not in ("meta", "log")
