"""A column map: robot, header, and where each column of a recording is in a file of another tool."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Any

from ffgym.core.errors import FFGymError, check_number, errors_at
from ffgym.core.files import read_text, write_text
from ffgym.core.toml import parse_toml, toml_key, toml_value
from ffgym.logs.column import MappedColumn, check_truth, parse_column
from ffgym.logs.keys import KEYS, check_table
from ffgym.logs.text_layout import TextLayout
from ffgym.recordings.rewiring import Rewire, Rewiring
from ffgym.recordings.schema import FAMILIES, closest

TO_FILL_IN = "?"
"""Mark in a draft for what only the owner of a log knows."""

_NEUTRAL = {"factor": 1.0, "offset": 0.0, "delay": 0.0}


@dataclass(frozen=True, kw_only=True, eq=False)
class ColumnMap:
    """Meaning of the arrays of a file, made by `load_columns` or `parse_columns`."""

    where: str
    """Name of the file or text, for messages."""
    folder: Path = Path()
    """Folder from which the path of a robot's description starts."""
    robot: str = ""
    """Built-in robot, path, or with joints in `header` just a name; empty if the caller says which."""
    header: Mapping[str, Any] = field(default_factory=dict)
    """Fields of the recording's header that the map sets."""
    columns: Mapping[str, MappedColumn]
    """Family or column -> where its numbers are."""
    layout: TextLayout = field(default_factory=TextLayout)
    """Layout of a text file."""
    split: str = ""
    """Array whose value tells the motions apart; empty if there is one, or they lie along an axis."""
    names: str = ""
    """Array with the names of the motions."""
    meta: Mapping[str, Any] = field(default_factory=dict)
    """JSON values, or tables {"source": name} for arrays of the file."""
    trim: bool = False
    """True if rows that a column with a clock of its own does not reach are dropped."""
    rewiring: Rewiring = field(default_factory=Rewiring)
    """Corrections of what is read."""

    @property
    def is_for_recordings(self) -> bool:
        """Tell whether the files are recordings, of which nothing but the corrections has to be said."""
        return not self.columns


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
        return parse_columns(_map_text(name), where=name, folder=Path(columns).parent)
    return parse_columns(_map_text(name), where=f"{name}.toml")


def _map_text(columns: str | Path) -> str:
    """TOML text of a built-in map, or of a file that ends in .toml."""
    name = str(columns)
    if name.endswith(".toml"):
        return read_text(columns)
    if name not in builtin_columns():
        raise FFGymError(
            f"Unknown column map {name!r}. Built in: {', '.join(builtin_columns())}. A file must end in .toml; "
            "`ffgym log columns FILE` writes a draft."
        )
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
    with errors_at(where):
        return column_map_of(tree, where, Path(folder))


def column_map_of(tree: Mapping[str, Any], where: str, folder: Path) -> ColumnMap:
    """Column map of a TOML tree; arguments as for `parse_columns`."""
    tree = _with_base(tree, folder)
    _check_filled_in(tree)
    for key in tree:
        if key not in KEYS["tables"]:
            raise FFGymError(f"Unknown table [{key}]. {closest(key, KEYS['tables'])}")
    rewiring = _parse_rewiring(tree.get("rewire", {}))
    if set(tree) == {"rewire"}:
        return ColumnMap(where=where, folder=folder, columns={}, rewiring=rewiring)
    log, motions = (check_table(tree.get(name, {}), name) for name in ("log", "motions"))
    for name, value in [("robot", log.get("robot", "")), *motions.items()]:
        if not isinstance(value, str):
            raise FFGymError(f"{name} = {value!r} must be text.")
    meta = tree.get("meta", {})
    if not isinstance(meta, dict):
        raise FFGymError(f"[meta] must be a table, got {meta!r}.")
    return ColumnMap(
        where=where,
        folder=folder,
        robot=log.pop("robot", ""),
        trim=check_truth("trim", log.pop("trim", False)),
        header=log,
        columns=_parse_families(tree.get("columns")),
        layout=TextLayout.of(tree.get("file", {})),
        meta=meta,
        rewiring=rewiring,
        **motions,
    )


def _with_base(tree: Mapping[str, Any], folder: Path, seen: tuple[str, ...] = ()) -> dict[str, Any]:
    """The tree on top of those of the maps that it begins with."""
    log = tree.get("log", {})
    base = log.get("base") if isinstance(log, dict) else None
    if base is None:
        return dict(tree)
    if not isinstance(base, str) or base in seen:
        raise FFGymError(f"base = {base!r} must be the name of another column map, or its path.")
    if base.endswith(".toml"):
        text, folder = read_text(folder / base), (folder / base).parent
    elif base in builtin_columns():
        text = _map_text(base)
    else:
        raise FFGymError(f"base = {base!r} is unknown. Built in: {', '.join(builtin_columns())}; a file ends in .toml.")
    below = _with_base(parse_toml(text, base if base.endswith(".toml") else f"{base}.toml"), folder, (*seen, base))
    return _merge_tables(below, {**tree, "log": {key: value for key, value in log.items() if key != "base"}})


def _merge_tables(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """Both trees; where both have a key, tables are merged and `above` counts otherwise."""
    merged = dict(below)
    for key, value in above.items():
        both = isinstance(value, dict) and isinstance(merged.get(key), dict)
        merged[key] = _merge_tables(merged[key], value) if both else value
    return merged


def _check_filled_in(tree: Mapping[str, Any], path: str = "") -> None:
    """Raise where a draft still has a '?'."""
    for key, value in tree.items():
        here = f"{path}.{key}" if path else key
        if isinstance(value, dict):
            _check_filled_in(value, here)
        elif value == TO_FILL_IN:
            raise FFGymError(f"{here} = '?' is still to be filled in, or to be taken away.")


def _parse_families(tables: Any) -> dict[str, MappedColumn]:
    """Columns by family."""
    if not isinstance(tables, dict) or not tables:
        raise FFGymError('[columns] is missing: it holds a table like [columns."motor.position"] for each family.')
    spelt_out = (entry for name, table in tables.items() for entry in _spelt_out(name, table))
    columns = {family: parse_column(entries, f"[columns.{family!r}]") for family, entries in spelt_out}
    if "timestamp" not in columns:
        raise FFGymError("[columns.timestamp] is missing: give a source with its unit, or rate_hz.")
    return columns


def _spelt_out(name: str, table: Any) -> list[tuple[str, Any]]:
    """Tables by the full names of families: TOML makes of [columns.motor.position] a table in a table."""
    if isinstance(table, dict) and table and all(isinstance(entry, dict) for entry in table.values()):
        return [found for key, entry in table.items() for found in _spelt_out(f"{name}.{key}", entry)]
    return [(name, table)]


def _parse_rewiring(table: Any) -> Rewiring:
    """Corrections of the table [rewire]."""
    if not isinstance(table, dict):
        raise FFGymError(f"[rewire] must be a table, got {table!r}.")
    clock, families = 1.0, {}
    for name, entry in table.items():
        if name == "clock":
            clock = check_number("[rewire] clock", entry, low=0.0, open_low=True)
        elif name not in FAMILIES or FAMILIES[name].parts == "one":
            raise FFGymError(f"[rewire.{name!r}] is no family of columns. {closest(name, FAMILIES)}")
        else:
            families[name] = _parse_rewire(f"[rewire.{name!r}]", entry)
    return Rewiring(families=families, clock=clock)


def _parse_rewire(where: str, table: Any) -> Rewire:
    """Correction of one family."""
    if not isinstance(table, dict) or not table:
        raise FFGymError(f"{where} must be a table with {', '.join(KEYS['rewire'])}.")
    for key, entry in check_table(table, "rewire", where).items():
        if not isinstance(entry, list) or not entry:
            raise FFGymError(f"{where} {key} = {entry!r} must be a list with a number for each joint or axis.")
    (n, *others) = {len(entry) for entry in table.values()}
    if others:
        raise FFGymError(f"{where}: its lists must have one length, a number for each joint or axis.")
    source = table.get("source", list(range(n)))
    if not all(type(part) is int for part in source) or sorted(source) != list(range(n)):
        raise FFGymError(f"{where} source = {source} must hold each number from 0 to {n - 1} once.")
    numbers = {
        key: tuple(check_number(f"{where} {key}", number) for number in table.get(key, [neutral] * n))
        for key, neutral in _NEUTRAL.items()
    }
    if 0.0 in numbers["factor"]:
        raise FFGymError(f"{where} factor = {list(numbers['factor'])} must not be zero, which erases a column.")
    return Rewire(source=tuple(source), **numbers)


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
        tree = parse_toml(_map_text(columns), str(columns))
        robot = tree.get("log", {}).get("robot", "")
        if robot.endswith(".toml"):
            tree["log"]["robot"] = os.path.relpath(known.folder / robot, Path(path).parent)
        rewiring = known.rewiring.then(rewiring)
    # what changes nothing stays away
    tree["rewire"] = {} if rewiring.clock == 1.0 else {"clock": rewiring.clock}
    for name, rewire in rewiring.families.items():
        if not rewire.is_none:
            none = Rewire.none(len(rewire.source))
            changed = [key for key in KEYS["rewire"] if getattr(rewire, key) != getattr(none, key)]
            tree["rewire"][name] = {key: list(getattr(rewire, key)) for key in changed}
    head = [
        "# Column map with corrections that a fit of the wiring of the logs found:",
        *(f"# - {n}" for n in notes),
    ]
    write_text(path, "\n".join([*head, "", *_table_lines("", tree)]) + "\n")


def _table_lines(prefix: str, tree: Mapping[str, Any]) -> list[str]:
    """Lines of a table, and after them those of the tables in it; tables in [meta] and [log] stand in their line."""
    inline = prefix.split(".")[0] in ("meta", "log")
    tables = {key: value for key, value in tree.items() if isinstance(value, dict) and not inline}
    plain = [f"{toml_key(key)} = {toml_value(value)}" for key, value in tree.items() if key not in tables]
    lines = [f"[{prefix}]"] if prefix and plain else []
    lines += [*plain, ""] if plain else []
    for key, value in tables.items():
        lines += _table_lines(f"{prefix}.{toml_key(key)}" if prefix else toml_key(key), value)
    return lines
