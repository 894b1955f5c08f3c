"""Result of the calibration as files of the package."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit

from ffgym.core.files import write_text
from ffgym.core.types import Array
from scripts.workcell.free import File, Trees, applied, changed_entries, table_at

MACHINE = Path("ffgym/workcell/data/thesis.toml")
CONTROLLER = Path("ffgym/robot/parameters/irb4600_60_205_commissioned.toml")

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


def write_result(prior: Trees, x: Array) -> None:
    """Write the machine's file and its controller's parameters with the free numbers `x` (K,) in them."""
    trees = rounded(applied(prior, x))
    _write(MACHINE, "machine", trees["machine"], prior)
    parameters = {
        "robot": "irb4600_60_205",
        "title": "friction as identified when the robot was commissioned, years ago",
    }
    _write(CONTROLLER, "controller", {"parameters": parameters, **trees["controller"]}, prior)


def rounded(trees: Trees) -> dict[File, dict[str, Any]]:
    """The tables with changed numbers as they are written."""
    out: dict[File, dict[str, Any]] = dict(trees)
    for file, entry in changed_entries():
        table = table_at(out[file], entry)
        table["value"] = _to_digits(table["value"])
    return out


def _to_digits(value: Any) -> Any:
    if isinstance(value, list):
        return [_to_digits(entry) for entry in value]
    return float(f"{value:.{_DIGITS}g}")


def _write(path: Path, file: File, tree: Mapping[str, Any], prior: Trees) -> None:
    for changed_file, entry in changed_entries():
        if changed_file == file:
            _mark_fitted(table_at(tree, entry), table_at(prior[file], entry))
    write_text(path, f"{_HEADS[file]}\n\n" + tomlkit.dumps(_by_kind(tree)))


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
    """Whether entries differ is asked per joint."""
    array = np.atleast_1d(np.asarray(value, dtype=np.float64))
    return array if array.ndim == 1 else array[:, 0]


def _by_kind(tree: Mapping[str, Any]) -> dict[str, Any]:
    """Head first, then tables by name."""
    heads = ("parameters", "workcell", "machine")
    return {key: tree[key] for key in [*(key for key in heads if key in tree), *sorted(set(tree) - set(heads))]}
