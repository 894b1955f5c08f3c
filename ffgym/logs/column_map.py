"""A column map: robot, header, and where each column of a recording is in a file of another tool."""

import os
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from types import MappingProxyType
from typing import Any, final

from ffgym.core.errors import FFGymError, check_number
from ffgym.core.files import read_text, write_text
from ffgym.core.toml import parse_toml, toml_key, toml_value
from ffgym.logs.column import Column, parse_column
from ffgym.logs.text_layout import TextLayout
from ffgym.recordings.rewiring import Rewire, Rewiring
from ffgym.recordings.schema import FAMILIES, closest

LOG_KEYS: Mapping[str, str] = MappingProxyType(
    {
        "base": "column map that this one begins with, a built-in name or a .toml beside it: keys here are added to "
        "its tables, or count in place of its keys",
        "robot": "built-in robot, or a description (.toml) beside the map; with `joints`, just a name; absent if the "
        "caller says it",
        "joints": "joint names of a robot without description; then `gear_ratio` is needed, and `coupling` and "
        "`joint_types` may follow",
        "gear_ratio": "motor angle over joint angle, one per joint",
        "coupling": "how far motor i turns with joint j",
        "joint_types": '"hinge" or "slide", one per joint',
        "position_side": "side on which the recording keeps motor and reference positions; absent is that of the "
        "description, or `motor`",
        "torque_semantics": "what the torque is; absent is the description's, or `unspecified`",
        "hold": "when the torque of a row acts; absent is `sampled` with a description, otherwise `unspecified`",
        "encoder_bits": "resolution of the motor encoder",
        "filters": "list of the filters already applied, in words",
        "payload": "table with `mass` [kg], `com` [m] and `inertia` [kg m^2]; absent is the "
        'description\'s tool, "unknown" is null',
        "segment": "name of the motion; absent is the name of the file",
        "trim": "true: rows before and after the samples of a column with a clock of its own are dropped",
    }
)
"""What the table [log] may say; except `base`, `robot` and `trim` these are header fields (docs/recordings.md)."""

MOTION_KEYS: Mapping[str, str] = MappingProxyType(
    {
        "split": "array with one number or word per row that is the same throughout a motion, e.g. `episode_index`",
        "names": "array with the name of each motion; absent are numbers from 0",
    }
)
"""What the table [motions] may say of a file with several motions."""

TABLES: Mapping[str, str] = MappingProxyType(
    {
        "log": "whose log it is, and what its torque and positions are",
        "columns": "the columns of the recording, by family",
        "file": "layout of a text file",
        "motions": "how a file holds several motions",
        "rewire": "corrections of columns that were read, by family; a map without other tables is for recordings",
        "meta": 'what goes into `meta` of the header: values, or `{ source = "name" }` for an array of the file, '
        "which may be `optional = true`; with `since_first = true`, times of day ('20:29', or seconds) become seconds "
        "since the earliest motion of the file, as `session_start` needs them",
    }
)
"""Tables of a column map."""

TO_FILL_IN = "?"
"""What stands in a draft where only the owner of a log knows."""

REWIRE_KEYS: Mapping[str, str] = MappingProxyType(
    {
        "source": "which of the columns of the family, from 0, holds the numbers of each joint or axis, one each",
        "factor": "by which they are multiplied, one each",
        "offset": "added after `factor`, in the unit that the recording keeps, one each",
        "delay": "by which they come late [s of the clock as it is in the file], one each; rows without a sample are "
        "dropped",
    }
)
"""What a table [rewire."..."] of a family may say; absent keys change nothing. `clock` in [rewire] multiplies all
times."""

_NEUTRAL = {"factor": 1.0, "offset": 0.0, "delay": 0.0}


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ColumnMap:
    """What the arrays of a file mean. Made by `load_columns` or `parse_columns`."""

    where: str
    """Name of the file or text, for messages."""
    folder: Path = Path()
    """Where the path of a robot's description starts."""
    robot: str = ""
    """Built-in robot, path, or with joints in `header` just a name; empty if the caller says which."""
    header: Mapping[str, Any] = field(default_factory=dict)
    """Fields of the recording's header that the map sets."""
    columns: Mapping[str, Column]
    """Family or column -> where its numbers are."""
    layout: TextLayout = field(default_factory=TextLayout)
    """Of a text file."""
    split: str = ""
    """Array whose value tells the motions apart; empty if there is one, or they lie along an axis."""
    names: str = ""
    """Array with the names of the motions."""
    meta: Mapping[str, Any] = field(default_factory=dict)
    """JSON values, or tables {"source": name} for arrays of the file."""
    trim: bool = False
    """Whether rows that a column with a clock of its own does not reach are dropped."""
    rewiring: Rewiring = field(default_factory=Rewiring)
    """Corrections of what is read."""

    @property
    def is_for_recordings(self) -> bool:
        """Whether the files are recordings, of which nothing but the corrections has to be said."""
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


def parse_rewiring(table: Any) -> Rewiring:
    """Corrections of the table [rewire].

    Raises:
        FFGymError: if an entry is unknown or invalid.
    """
    if not isinstance(table, dict):
        raise FFGymError(f"[rewire] must be a table, got {table!r}.")
    clock, families = 1.0, {}
    for name, entry in table.items():
        if name == "clock":
            clock = check_number("[rewire] clock", entry, low=0.0, open_low=True)
        elif name not in FAMILIES or FAMILIES[name].parts == "one":
            raise FFGymError(f"[rewire.{name!r}] is no family of columns. {closest(name, FAMILIES)}")
        else:
            families[name] = _rewire(f"[rewire.{name!r}]", entry)
    return Rewiring(families=families, clock=clock)


def rewiring_table(rewiring: Rewiring) -> dict[str, Any]:
    """The table [rewire] of corrections; what changes nothing stays away."""
    table: dict[str, Any] = {} if rewiring.clock == 1.0 else {"clock": rewiring.clock}
    for name, rewire in rewiring.families.items():
        if rewire.is_none:
            continue
        given, none = rewire, Rewire.none(len(rewire.source))
        keys = [key for key in REWIRE_KEYS if getattr(given, key) != getattr(none, key)]
        table[name] = {key: list(getattr(given, key)) for key in keys}
    return table


def _rewire(where: str, table: Any) -> Rewire:
    if not isinstance(table, dict) or not table:
        raise FFGymError(f"{where} must be a table with {', '.join(REWIRE_KEYS)}.")
    for key, entry in table.items():
        if key not in REWIRE_KEYS:
            raise FFGymError(f"Unknown key {key!r} in {where}. {closest(key, REWIRE_KEYS)}")
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
        raise FFGymError(f"{where} factor = {list(numbers['factor'])} must not be zero: nothing of them would be left.")
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
