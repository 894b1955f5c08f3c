"""Prior of the calibration and what it may change: the nominal robot and `prior.toml`, moved by `free.toml`."""

import tomllib
from collections.abc import Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ffgym.core.types import Array
from ffgym.robot import RobotDescription

File = Literal["machine", "controller"]
"""The machine, or the model that its controller knows."""

Trees = Mapping[File, dict[str, Any]]

_FOLDER = Path(__file__).parent
_SLIPPING = "effects.slip_elements.level"


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


def _free_numbers() -> Iterator[Free]:
    for row in tomllib.loads((_FOLDER / "free.toml").read_text(encoding="utf-8"))["free"]:
        each = row.pop("each", False)
        free = Free(**row)
        if each:
            for joint in free.joints:
                yield replace(free, name=f"{free.name}, joint {joint}", joints=(joint,))
        else:
            yield free


FREE = tuple(_free_numbers())
SPREAD = np.array([free.spread for free in FREE])
LOW = np.array([free.low for free in FREE])


def applied(prior: Trees, x: Array) -> dict[File, dict[str, Any]]:
    """The prior's tables with the free numbers `x` (K,) in them: shifts first, then factors."""
    out: dict[File, dict[str, Any]] = {name: deepcopy(tree) for name, tree in prior.items()}
    order = sorted(range(len(FREE)), key=lambda i: FREE[i].added_to is None)
    for i in order:
        free = FREE[i]
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


def changed_entries() -> set[tuple[File, str]]:
    """Files and entries that the calibration changes."""
    return {(free.file, entry) for free in FREE for entry in free.entries}


def table_at(tree: Mapping[str, Any], entry: str) -> dict[str, Any]:
    """Table of value, unit and source of an entry such as 'friction.coulomb'."""
    found: Any = tree
    for key in entry.split("."):
        found = found[key]
    table: dict[str, Any] = found
    return table


def prior_trees(nominal: RobotDescription) -> dict[File, dict[str, Any]]:
    """Tables of the machine and of its controller's model before the calibration."""
    trees: dict[File, dict[str, Any]] = {
        "machine": tomllib.loads((_FOLDER / "prior.toml").read_text(encoding="utf-8")),
        "controller": {},
    }
    for file, entry in sorted(changed_entries()):
        group, _, name = entry.partition(".")
        if entry in nominal.quantities:  # the others are in the file
            trees[file].setdefault(group, {})[name] = _table(nominal, entry)
    _without_slip_elements(trees["machine"], nominal)
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


def _without_slip_elements(machine: dict[str, Any], nominal: RobotDescription) -> None:
    """Take off the LuGre friction what slip elements carry, so that their sum is the friction that is known."""
    shares = [
        1 - slip / coulomb
        for slip, coulomb in zip(table_at(machine, _SLIPPING)["value"], nominal.friction.coulomb, strict=True)
    ]
    for name in ("coulomb", "static", "bristle_stiffness", "bristle_damping"):
        table = machine["friction"][name]
        table["value"] = [value * share for value, share in zip(table["value"], shares, strict=True)]
