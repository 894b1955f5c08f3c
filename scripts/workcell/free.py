"""Calibrations of workcells: the prior (nominal robot, `prior.toml`), free numbers (`free.toml`), results as files."""

import tomllib
from collections.abc import Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import tomlkit

from ffgym.core.files import write_text
from ffgym.core.toml import merge_tables
from ffgym.core.types import Array
from ffgym.robot import RobotDescription, builtin_parameters

File = Literal["machine", "controller"]
"""The machine, or the model that its controller knows."""

Trees = Mapping[File, dict[str, Any]]

_FOLDER = Path(__file__).parent
_SLIPPING = "effects.slip_elements.level"

SOURCE = (
    "scripts/calibrate_workcell.py: path errors of the published robot with no, static LuGre and dynamic LuGre "
    "compensation at 10 and 40 mm/s"
)

_DIGITS = 4
"""Significant digits that are kept: far below what the published errors determine."""

_HEADS: dict[File, str] = {
    "machine": "# Written by scripts/calibrate_workcell.py from scripts/workcell/prior.toml; for the simulation only.",
    "controller": "# Written by scripts/calibrate_workcell.py: what the controller of the workcell knows of friction.",
}


@dataclass(frozen=True, kw_only=True)
class Free:
    """One free number x; the head of `free.toml` says what each entry means."""

    name: str
    spread: float
    entries: tuple[str, ...]
    joints: tuple[int, ...] = (1, 2, 3, 4, 5, 6)
    file: File = "machine"
    added_to: str | None = None
    low: float = -np.inf
    high: float = np.inf


@dataclass(frozen=True, kw_only=True, eq=False)
class Calibration:
    """Calibration of one workcell: its files, its free numbers, and what its prior has beside that of the others."""

    nominal: str
    """Robot, or parameters that ship with the package, whose numbers are the prior."""
    machine: Path
    controller: Path
    free: tuple[Free, ...]
    beside: dict[str, Any]

    @property
    def spread(self) -> Array:
        """Standard deviations of the free numbers, shape (K,)."""
        return np.array([free.spread for free in self.free])

    def clip(self, x: Array) -> Array:
        """Bring free numbers (..., K) within their bounds."""
        low, high = ([getattr(free, end) for free in self.free] for end in ("low", "high"))
        return np.clip(x, low, high)

    @property
    def changes(self) -> set[tuple[File, str]]:
        """Files and entries that the calibration changes."""
        return {(free.file, entry) for free in self.free for entry in free.entries}


def _read_toml(name: str) -> dict[str, Any]:
    return tomllib.loads((_FOLDER / name).read_text(encoding="utf-8"))


def _free_numbers(workcell: str) -> Iterator[Free]:
    for row in _read_toml("free.toml")["free"]:
        each, only = row.pop("each", False), row.pop("only", workcell)
        free = Free(**row)
        if only != workcell:
            continue
        if each:
            for joint in free.joints:
                yield replace(free, name=f"{free.name}, joint {joint}", joints=(joint,))
        else:
            yield free


def _calibration(workcell: str, controller: str, nominal: str) -> Calibration:
    return Calibration(
        nominal=nominal,
        machine=Path(f"ffgym/workcell/data/{workcell}.toml"),
        controller=Path(f"ffgym/robot/parameters/{controller}.toml"),
        free=tuple(_free_numbers(workcell)),
        beside=_read_toml("prior.toml").get("only", {}).get(workcell, {}),
    )


CALIBRATIONS = {
    "thesis": _calibration("thesis", "irb4600_60_205_commissioned", "irb4600_60_205"),
    "thesis_arm": _calibration("thesis_arm", "irb4600_60_205_commissioned_arm", "irb4600_60_205_arm_losses"),
}
"""Calibrations by the name of their workcell."""


def applied(calibration: Calibration, prior: Trees, x: Array) -> dict[File, dict[str, Any]]:
    """The prior's tables with the free numbers `x` (K,) in them: shifts first, then factors."""
    out: dict[File, dict[str, Any]] = {name: deepcopy(tree) for name, tree in prior.items()}
    order = sorted(range(len(calibration.free)), key=lambda i: calibration.free[i].added_to is None)
    for i in order:
        free = calibration.free[i]
        for entry in free.entries:
            table = table_at(out[free.file], entry)
            values = np.array(table["value"], dtype=np.float64)
            where: Any = [j - 1 for j in free.joints] if values.ndim else ...
            if free.added_to is None:
                values[where] *= np.exp(x[i])
            else:
                scale = (
                    1.0 if free.added_to == "1" else np.array(table_at(prior[free.file], free.added_to)["value"])[where]
                )
                values[where] += x[i] * scale
            table["value"] = values.tolist()
    return out


def table_at(tree: Mapping[str, Any], entry: str) -> dict[str, Any]:
    """Table of value, unit and source of an entry such as 'friction.coulomb'."""
    found: Any = tree
    for key in entry.split("."):
        found = found[key]
    table: dict[str, Any] = found
    return table


def prior_trees(calibration: Calibration, nominal: RobotDescription) -> dict[File, dict[str, Any]]:
    """Tables of the machine and of its controller's model before the calibration."""
    machine = _read_toml("prior.toml")
    del machine["only"]
    trees: dict[File, dict[str, Any]] = {"machine": merge_tables(machine, calibration.beside), "controller": {}}
    for file, entry in sorted(calibration.changes):
        group, _, name = entry.partition(".")
        if entry in nominal.quantities:  # the others are in the file
            trees[file].setdefault(group, {})[name] = _table(nominal, entry)
    # the LuGre friction carries what slip elements leave, so that their sum is the friction that is known
    machine = trees["machine"]
    slipping = np.array(table_at(machine, _SLIPPING)["value"])
    for name in ("coulomb", "static", "bristle_stiffness", "bristle_damping"):
        table = machine["friction"][name]
        table["value"] = (np.array(table["value"]) * (1 - slipping / nominal.friction.coulomb)).tolist()
    return trees


def _table(nominal: RobotDescription, entry: str) -> dict[str, Any]:
    """An entry of the nominal robot; what was fitted there is where this fit begins."""
    quantity = nominal.quantities[entry]
    return {
        "value": quantity.value.tolist(),
        "unit": quantity.unit.split(", ")[0],
        "side": quantity.side,
        "origin": ["derived" if origin == "fitted" else origin for origin in quantity.origin],
        "source": f"the nominal robot's: {quantity.source}",
    }


def write_result(calibration: Calibration, prior: Trees, x: Array) -> None:
    """Write the machine's file and its controller's parameters with the free numbers `x` (K,) in them."""
    trees = round_entries(calibration, applied(calibration, prior, x))
    _write(calibration, "machine", trees["machine"], prior)
    parameters = {
        "robot": "irb4600_60_205",
        "title": "friction as identified when the robot was commissioned, years ago",
    }
    # all that the nominal robot has in place of the numbers of that robot, with the friction of commissioning
    beside = _parameters(calibration.nominal) if calibration.nominal in builtin_parameters() else {}
    _write(calibration, "controller", {"parameters": parameters, **merge_tables(beside, trees["controller"])}, prior)


def _parameters(name: str) -> dict[str, Any]:
    """Tables of a parameter file that ships with the package, without its head."""
    tree = tomllib.loads(Path(f"ffgym/robot/parameters/{name}.toml").read_text(encoding="utf-8"))
    return {group: tables for group, tables in tree.items() if group != "parameters"}


def round_entries(calibration: Calibration, trees: Trees) -> dict[File, dict[str, Any]]:
    """The tables with changed numbers as they are written."""
    out: dict[File, dict[str, Any]] = dict(trees)
    for file, entry in calibration.changes:
        table = table_at(out[file], entry)
        table["value"] = _to_digits(table["value"])
    return out


def _to_digits(value: Any) -> Any:
    if isinstance(value, list):
        return [_to_digits(entry) for entry in value]
    return float(f"{value:.{_DIGITS}g}")


def _write(calibration: Calibration, file: File, tree: Mapping[str, Any], prior: Trees) -> None:
    for changed_file, entry in calibration.changes:
        if changed_file == file:
            _mark_fitted(table_at(tree, entry), table_at(prior[file], entry))
    heads = [key for key in ("parameters", "workcell", "machine") if key in tree]
    ordered = {key: tree[key] for key in [*heads, *sorted(set(tree) - set(heads))]}
    write_text(getattr(calibration, file), f"{_HEADS[file]}\n\n" + tomlkit.dumps(ordered))


def _mark_fitted(table: dict[str, Any], before: Mapping[str, Any]) -> None:
    """Say of a number that it was fitted, and what it was before."""
    moved = _first_axis(table["value"]) != _first_axis(_to_digits(before["value"]))
    if not np.any(moved):
        return
    if "origin" not in table:  # of an effect or of the surroundings, whose source is one text
        table["source"] = f"calibrated: {SOURCE}; before: {before['source']}"
        return
    origins = before["origin"] * (len(moved) if len(before["origin"]) == 1 else 1)
    table["origin"] = ["fitted" if m else o for m, o in zip(moved, origins, strict=True)]
    table |= {"source": SOURCE, "prior": _to_digits(before["value"]), "prior_source": before["source"]}


def _first_axis(value: Any) -> Any:
    """Tell per joint whether entries differ."""
    array = np.atleast_1d(np.asarray(value, dtype=np.float64))
    return array if array.ndim == 1 else array[:, 0]
