"""Pages about files and formats: robots, column maps, motion files and protocols."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, Field, fields
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.logs.column import COUNTS, UNITS
from ffgym.logs.keys import KEYS
from ffgym.logs.quality import NEEDS, STAGES
from ffgym.paths.limits import MotionLimits
from ffgym.paths.motions.load import HEAD, PARTS, builtin_files
from ffgym.paths.motions.part import entries, is_required
from ffgym.recordings.schema import FAMILIES
from ffgym.robot import RigidArm, load_robot
from ffgym.robot.reading.quantity import OTHER_UNITS
from ffgym.robot.reading.rules import CAPABILITIES, REQUIRED, RULES
from ffgym.simulation.protocols import PROTOCOLS, Protocol
from ffgym.simulation.protocols.load import MotionFile
from ffgym.simulation.protocols.protocol import settings
from ffgym.simulation.protocols.stage import ProtocolStage
from scripts.tables.page import WHOLE, Contents, markdown

_ROBOTS = {"irb4600_60_205": "six-axis robot", "one_axis": "one axis"}
"""Robots that durations of protocols are told for, and what the heading calls them."""


def robot_description() -> Contents:
    """Every entry of a description, and what each function needs."""
    rows = []
    for path, rule in RULES.items():
        comma = "," if len(rule.shape) == 1 else ""
        shape = f"({', '.join(map(str, rule.shape))}{comma})" if rule.shape else "number"
        units = " or ".join((rule.unit, *OTHER_UNITS.get(rule.unit, {})))
        required = "no" if rule.optional else "yes"
        rows.append((f"`{path}`", shape, units, rule.side or "", required, rule.meaning))
    # entries that every function needs the table says once
    whole, functions = set(REQUIRED), []
    for entry in CAPABILITIES:
        needs = [path for path in entry.needs if path not in CAPABILITIES[0].needs] or list(entry.needs)
        if whole <= set(entry.needs):
            needs = ["all that are required", *(path for path in entry.needs if path not in whole)]
        functions.append((entry.title, ", ".join(f"`{path}`" if "." in path else path for path in needs)))
    return Contents(
        parts={
            "entries": markdown(("entry", "shape", "unit", "side", "required", "meaning"), rows),
            "functions": markdown(("function", "entries"), functions),
        }
    )


def robot(name: str) -> Contents:
    """Every number of a built-in robot with unit, side, origin and source."""
    described = load_robot(name)
    rows = []
    for path, quantity in described.quantities.items():
        prior = "" if quantity.prior is None else f"<br>prior: {_numbers(quantity.prior)}"
        origin = ", ".join(quantity.origin)
        value = f"{_numbers(quantity.value)}{prior}"
        rows.append((f"`{path}`", value, quantity.unit, quantity.side or "", origin, quantity.source))
    text = f"""# {described.title} (`{described.name}`)

Written by `python -m scripts.tables` from the description in `ffgym/robot/data`; SI units, rad.

- *sourced*: published; *derived*: computed from published numbers; *chosen*: an engineering choice;
- *fitted*: see [calibration](../calibration.md); prior is what it replaced.

{markdown(("entry", "value", "unit", "side", "origin", "source"), rows)}
"""
    return Contents(parts={WHOLE: text})


def _numbers(value: Array) -> str:
    """Numbers to 6 digits; the rows of a matrix are separated by semicolons."""
    if value.ndim == 2:
        return "; ".join(_numbers(row) for row in value)
    return ", ".join(f"{x:.6g}" for x in np.atleast_1d(value))


def column_maps() -> Contents:
    """Every key of a column map, and the units that numbers may come in."""
    units = []
    for si, others in UNITS.items():
        also = [unit for unit, angle in COUNTS.items() if angle == si]
        units.append((f"`{si}`", ", ".join(f"`{unit}`" for unit in (si, *others, *also))))
    parts = {name: _name("key", "meaning", meanings) for name, meanings in KEYS.items()}
    return Contents(parts=parts | {"units": markdown(("kept in", "may come in"), units)})


def recordings() -> Contents:
    """Every family of columns of a recording."""
    suffix = {"one": "", "joint": ".<joint>", "xyz": ".x/y/z", "quaternion": ".qw/qx/qy/qz"}
    rows = [
        (
            f"`{f.name}{suffix[f.parts]}`",
            f.unit,
            f.side,
            f"`{f.decided_by}`" if f.decided_by else "",
            "yes" if f.may_miss else "",
            f.meaning,
        )
        for f in FAMILIES.values()
    ]
    head = ("column", "unit", "side", "header field that decides", "NaN allowed", "meaning")
    return Contents(parts={"columns": markdown(head, rows)})


def quality() -> Contents:
    """All checks of a log by stage, and what each use needs."""
    checks: list[tuple[str, ...]] = []
    for stage, own in STAGES.items():
        checks.append((f"**{stage}**", "", "", "", "", ""))
        for check in own:
            limits = ["" if limit is None else f"{limit:.3g}" for limit in (check.flag, check.refuse)]
            figure = check.figure.replace("|ln|", "absolute logarithm")
            checks.append((f"`{check.name}`", figure, check.unit, *limits, check.why))
    needs = []
    for name, need in NEEDS.items():
        columns, sound = (", ".join(f"`{each}`" for each in names) for names in (need.columns, need.sound))
        columns += "".join([", ", " or ".join(f"`{each}`" for each in need.any_of)] if need.any_of else [])
        least = ", ".join(f"{figure} {value:g}" for figure, value in need.least.items())
        needs.append((f"`{name}`", columns, least, sound, need.why))
    return Contents(
        parts={
            "checks": markdown(("check", "figure", "unit", "flagged above", "refused above", "why"), checks),
            "needs": markdown(("need", "columns", "at least, on one joint", "flags refused", "why"), needs),
        }
    )


def motion_files() -> Contents:
    """List the entries, parts and limits of a motion file, and the built-in motions with their first comments."""
    files = sorted(builtin_files().items())
    comments = {
        name: re.search(r"^\s*[#!] (.*)$", file.read_text(encoding="utf-8"), flags=re.M) for name, file in files
    }
    return Contents(
        parts={
            "head": _name("entry", "meaning", HEAD),
            "parts": "\n\n".join(
                _section(kind, part.__doc__ or "", "entry", entries(part)) for kind, part in PARTS.items()
            ),
            "limits": _table("limit", fields(MotionLimits)),
            "built-in": _name("name", "motion", {name: found[1] if found else "" for name, found in comments.items()}),
        }
    )


def protocols() -> Contents:
    """List what each protocol serves, how long it takes, and its settings."""
    arms = [RigidArm(load_robot(name)) for name in _ROBOTS]
    rows = []
    for name, protocol in PROTOCOLS.items():
        durations = []
        for arm in arms:
            try:
                motions = protocol().motions(ProtocolStage(arm=arm))
                durations.append(f"{len(motions)}: {sum(motion.reference.duration for motion in motions):.0f} s")
            except FFGymError:  # not on this robot
                durations.append("")
        rows.append((f"[`{name}`](#{name})", protocol.purpose, *durations))
    kinds: list[type[Protocol]] = [*PROTOCOLS.values(), MotionFile]
    sections = [
        _section(
            protocol.name,
            " ".join((protocol.__doc__ or "").split("\n    Reference:")[0].split()),
            "setting",
            settings(protocol),
        )
        for protocol in kinds
    ]
    purposes = markdown(("protocol", "serves", *_ROBOTS.values()), rows)
    return Contents(parts={"purposes": purposes, "settings": "\n\n".join(sections)})


def _section(title: str, summary: str, what: str, entries: Iterable[Field[Any]]) -> str:
    """Heading, summary and table of the fields of a part or protocol."""
    return f"### {title}\n\n{summary}\n\n{_table(what, entries)}"


def _table(what: str, entries: Iterable[Field[Any]]) -> str:
    """Table of fields with their meanings."""
    rows = [
        (f"`{f.name}`", f.metadata["unit"], "required" if is_required(f) else _default(f), f.metadata["meaning"])
        for f in entries
    ]
    return markdown((what, "unit", "default", "meaning"), rows)


def _default(f: Field[Any]) -> str:
    """Default of a field as a file would write it."""
    if f.default is MISSING or f.default is None or f.default == "":
        return ""
    if isinstance(f.default, bool):
        return str(f.default).lower()
    if isinstance(f.default, tuple):
        return f"[{', '.join(f'{x:g}' for x in f.default)}]"
    return f"{f.default:g}" if isinstance(f.default, float) else str(f.default)


def _name(name: str, meaning: str, meanings: Mapping[str, str]) -> str:
    return markdown((name, meaning), [(f"`{key}`", text) for key, text in meanings.items()])
