"""Entries of a description as TOML text, and a description with entries filled in."""

import json
import os
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ffgym.core.types import Array
from ffgym.robot.description import RobotDescription
from ffgym.robot.reading.draft import RobotDraft, stand_ins
from ffgym.robot.reading.load import GROUPS
from ffgym.robot.reading.quantity import LINK, JointFrame, Rule, si_units
from ffgym.robot.reading.rules import RULES
from ffgym.robot.template.proposals import Proposal

MARK = "#? "
"""Begins the lines of an entry that waits for numbers; without it they are TOML."""
_DIGITS = 5
"""Of proposed numbers per joint; rules of thumb deserve no more. Single numbers are times, which must fit exactly."""


def text(value: str) -> str:
    """A string in quotes; JSON's are TOML's, but for a control character that JSON leaves as it is."""
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def names(values: Sequence[str]) -> str:
    """A list of strings."""
    return f"[{', '.join(map(text, values))}]"


def filled_entry(proposal: Proposal, rule: Rule, types: tuple[str, ...]) -> list[str]:
    """Lines of an entry with its numbers."""
    return _entry(
        proposal.path,
        _numbers(proposal.value),
        _unit(rule, proposal.side, types),
        proposal.side,
        proposal.origin,
        text(proposal.source),
    )


def empty_entry(path: str, rule: Rule, types: tuple[str, ...]) -> list[str]:
    """Lines of an entry that waits for numbers."""
    shape = tuple(len(types) if s == "N" else int(s) for s in rule.shape)
    unit = _unit(rule, rule.side, types)
    if rule.side == LINK and rule.gear_power is None:  # angles of joints are read in degrees
        unit = unit.replace('"rad', '"deg')
    lines = _entry(path, _numbers(np.full(shape, np.nan)), unit, rule.side, "sourced", '"?"')
    return [MARK + line for line in lines]


def marked(lines: list[str]) -> list[str]:
    """The same lines, waiting for numbers."""
    return [MARK + line for line in lines]


def _entry(path: str, value: str, unit: str, side: str | None, origin: str, source: str) -> list[str]:
    sides = [] if side is None else [f"side = {text(side)}"]
    return [f"[{path}]", f"value = {value}", f"unit = {unit}", *sides, f"origin = {text(origin)}", f"source = {source}"]


def _unit(rule: Rule, side: str | None, types: tuple[str, ...]) -> str:
    units = si_units(rule, side, JointFrame(types=types))
    return text(units[0]) if len(units) == 1 else names(units)


def _numbers(value: Array) -> str:
    """Numbers to five digits, times with all, NaN as a question mark."""
    return _nested(value.tolist()) if value.ndim or np.isnan(value) else repr(float(value))


def _nested(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_nested, value))}]"
    if np.isnan(value):
        return "?"
    if np.isinf(value):
        return "inf"
    return repr(float(f"{value:.{_DIGITS}g}"))


def filled_text(toml: str, proposals: Sequence[Proposal], types: tuple[str, ...]) -> str:
    """Text of a description with entries added: in place of their waiting lines, or at the end.

    Args:
        toml: text of the description.
        proposals: entries that it lacks.
        types: 'hinge' or 'slide', one per joint.
    """
    lines = toml.splitlines()
    for proposal in proposals:
        entry = filled_entry(proposal, RULES[proposal.path], types)
        start, stop = _waiting(lines, proposal.path)
        lines[start:stop] = entry if stop > start else ["", *entry]
    return "\n".join(lines) + "\n"


def _waiting(lines: Sequence[str], path: str) -> tuple[int, int]:
    """Rows of the lines that wait for the numbers of an entry; the end of the text, twice, if there are none."""
    head = f"{MARK}[{path}]"
    if head not in lines:
        return len(lines), len(lines)
    start = stop = lines.index(head)
    while (
        stop < len(lines) and lines[stop].startswith(MARK) and (stop == start or not lines[stop].startswith(f"{MARK}["))
    ):
        stop += 1
    return start, stop


_SOURCE = "stand-in: nobody said it; what depends on it means nothing"

_MODEL = re.compile(r'^(\s*model\s*=\s*)"([^"]*)"', re.MULTILINE)
"""The entry of [robot] that names the arm file."""


def completed_text(toml: str, draft: RobotDraft, robot: RobotDescription, *, before: Path, folder: Path) -> str:
    """Text of a description with stand-ins for all that it lacks; numbers that `robot` has of it are taken from there.

    Args:
        toml: text of the description.
        draft: what it says.
        robot: the same robot with numbers that were fitted since.
        before: folder of the description, where the path of its arm file begins.
        folder: folder that the text is for.
    """
    known = {path: quantity.value for path, quantity in draft.quantities.items()}
    instead = stand_ins(known, len(draft.joints)) | {path: _fitted(robot, path) for path in draft.missing if _has(path)}
    proposals = [
        Proposal(path=path, value=np.asarray(instead[path]), source=_SOURCE, side=RULES[path].side)
        for path in draft.missing
    ]
    return filled_text(_moved(toml, before, folder), proposals, draft.types)


def _has(path: str) -> bool:
    return path.partition(".")[0] in GROUPS


def _fitted(robot: RobotDescription, path: str) -> Array:
    group, _, name = path.partition(".")
    return np.asarray(getattr(getattr(robot, GROUPS[group]), name), dtype=np.float64)


def _moved(toml: str, before: Path, folder: Path) -> str:
    """The text with the path of its arm file from another folder."""

    def named(match: re.Match[str]) -> str:
        path = (before / match.group(2)).resolve()
        try:
            relative = Path(os.path.relpath(path, folder.resolve())).as_posix()
        except ValueError:  # another drive
            relative = path.as_posix()
        return f"{match.group(1)}{text(relative)}"

    return _MODEL.sub(named, toml, count=1)
