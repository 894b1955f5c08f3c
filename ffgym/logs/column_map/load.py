"""Column maps by name or from a file."""

from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

from ffgym.core.errors import FFGymError
from ffgym.core.files import read_text
from ffgym.core.toml import parse_toml
from ffgym.logs.column_map.column import Column, parse_column
from ffgym.logs.column_map.column_map import LOG_KEYS, MOTION_KEYS, TABLES, ColumnMap
from ffgym.logs.column_map.rewire import parse_rewiring
from ffgym.logs.text_layout import TextLayout
from ffgym.recordings.schema import closest

TO_FILL_IN = "?"
"""What stands in a draft where only the owner of a log knows."""


def builtin_columns() -> tuple[str, ...]:
    """Names of the column maps that ship with the package."""
    folder = resources.files("ffgym.logs") / "data"
    return tuple(sorted(Path(f.name).stem for f in folder.iterdir() if f.name.endswith(".toml")))


def load_columns(columns: ColumnMap | str | Path) -> ColumnMap:
    """Column map as it is, built-in by name, or from a file that ends in .toml.

    Raises:
        FFGymError: if there is none, or an entry is unknown or invalid.
    """
    if isinstance(columns, ColumnMap):
        return columns
    if not isinstance(columns, str | Path):
        raise FFGymError(f"columns = {columns!r} must be a ColumnMap, a name or a path.")
    name = str(columns)
    if name.endswith(".toml"):
        return parse_columns(map_text(name), where=name, folder=Path(columns).parent)
    return parse_columns(map_text(name), where=f"{name}.toml")


def map_text(columns: str | Path) -> str:
    """TOML text of a built-in map, or of a file that ends in .toml.

    Raises:
        FFGymError: if there is none.
    """
    name = str(columns)
    if name.endswith(".toml"):
        return read_text(columns)
    if name not in builtin_columns():
        raise FFGymError(
            f"Unknown column map {name!r}. Built in: {', '.join(builtin_columns())}. A file must end in .toml; "
            "`ffgym log columns FILE` writes a draft."
        )
    return _builtin_text(name)


def _builtin_text(name: str) -> str:
    return (resources.files("ffgym.logs") / "data" / f"{name}.toml").read_text(encoding="utf-8")


def parse_columns(text: str, where: str = "column map", folder: str | Path = ".") -> ColumnMap:
    """Column map from TOML text.

    Args:
        text: the map.
        where: its name, for messages.
        folder: where the path of a robot's description starts.

    Raises:
        FFGymError: if the text is not TOML, or an entry is missing, unknown or invalid.
    """
    tree = parse_toml(text, where)
    try:
        return column_map_of(tree, where, Path(folder))
    except FFGymError as error:
        raise FFGymError(f"{where}: {error}") from error


def _with_base(tree: Mapping[str, Any], folder: Path, seen: tuple[str, ...] = ()) -> dict[str, Any]:
    """The tree on top of those of the maps that it begins with.

    Raises:
        FFGymError: if there is no such map, or maps begin with one another.
    """
    log = tree.get("log", {})
    base = log.get("base") if isinstance(log, dict) else None
    if base is None:
        return dict(tree)
    if not isinstance(base, str) or base in seen:
        raise FFGymError(f"base = {base!r} must be the name of another column map, or its path.")
    if base.endswith(".toml"):
        below = _with_base(parse_toml(read_text(folder / base), base), (folder / base).parent, (*seen, base))
    elif base in builtin_columns():
        below = _with_base(parse_toml(_builtin_text(base), f"{base}.toml"), folder, (*seen, base))
    else:
        raise FFGymError(f"base = {base!r} is unknown. Built in: {', '.join(builtin_columns())}; a file ends in .toml.")
    own = {**tree, "log": {key: value for key, value in log.items() if key != "base"}}
    return _merged(below, own)


def _merged(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """Both trees; where both have a key, tables are merged and `above` counts otherwise."""
    merged = dict(below)
    for key, value in above.items():
        both = isinstance(value, dict) and isinstance(merged.get(key), dict)
        merged[key] = _merged(merged[key], value) if both else value
    return merged


def _check_filled_in(tree: Mapping[str, Any], path: str = "") -> None:
    """Raise where a draft still has a '?'."""
    for key, value in tree.items():
        here = f"{path}.{key}" if path else key
        if isinstance(value, dict):
            _check_filled_in(value, here)
        elif value == TO_FILL_IN:
            raise FFGymError(f"{here} = '?' is still to be filled in, or to be taken away.")


def column_map_of(tree: Mapping[str, Any], where: str, folder: Path) -> ColumnMap:
    """Column map of a TOML tree; arguments as for `parse_columns`.

    Raises:
        FFGymError: if an entry is missing, unknown or invalid.
    """
    tree = _with_base(tree, folder)
    _check_filled_in(tree)
    for key in tree:
        if key not in TABLES:
            raise FFGymError(f"Unknown table [{key}]. {closest(key, TABLES)}")
    if set(tree) == {"rewire"}:
        return ColumnMap(where=where, folder=folder, columns={}, rewiring=parse_rewiring(tree["rewire"]))
    log = _table(tree, "log", LOG_KEYS)
    motions = _table(tree, "motions", MOTION_KEYS)
    for name, value in [("robot", log.get("robot", "")), *motions.items()]:
        if not isinstance(value, str):
            raise FFGymError(f"{name} = {value!r} must be text.")
    trim = log.pop("trim", False)
    if not isinstance(trim, bool):
        raise FFGymError(f"trim = {trim!r} must be true or false.")
    return ColumnMap(
        where=where,
        folder=folder,
        robot=log.pop("robot", ""),
        header=log,
        columns=_columns(tree.get("columns")),
        layout=TextLayout.of(tree.get("file", {})),
        meta=_table(tree, "meta"),
        trim=trim,
        rewiring=parse_rewiring(tree.get("rewire", {})),
        **motions,
    )


def _columns(tables: Any) -> dict[str, Column]:
    """Columns by family; TOML makes of [columns.motor.position] what it makes of quoted names."""
    if not isinstance(tables, dict) or not tables:
        raise FFGymError('[columns] is missing: it holds a table like [columns."motor.position"] for each family.')
    columns: dict[str, Column] = {}
    for name, table in tables.items():
        for family, entries in _spelt_out(name, table):
            try:
                columns[family] = parse_column(entries)
            except FFGymError as error:
                raise FFGymError(f"[columns.{family!r}]: {error}") from error
    if "timestamp" not in columns:
        raise FFGymError("[columns.timestamp] is missing: give a source with its unit, or rate_hz.")
    return columns


def _spelt_out(name: str, table: Any) -> list[tuple[str, Any]]:
    """Tables of columns by their full names, for those whose names were not quoted."""
    if isinstance(table, dict) and table and all(isinstance(entry, dict) for entry in table.values()):
        return [found for key, entry in table.items() for found in _spelt_out(f"{name}.{key}", entry)]
    return [(name, table)]


def _table(tree: Mapping[str, Any], name: str, known: Mapping[str, str] | None = None) -> dict[str, Any]:
    table = tree.get(name, {})
    if not isinstance(table, dict):
        raise FFGymError(f"[{name}] must be a table, got {table!r}.")
    for key in table:
        if known is not None and key not in known:
            raise FFGymError(f"Unknown key {key!r} in [{name}]. {closest(key, known)}")
    return dict(table)
