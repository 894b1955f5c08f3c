"""Entries of a description as TOML text, and a description with entries filled in."""

import os
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ffgym.core.toml import single, toml_table, toml_value
from ffgym.robot.description import RobotDescription
from ffgym.robot.reading.draft import RobotDraft, stand_ins
from ffgym.robot.reading.load import GROUPS
from ffgym.robot.reading.quantity import LINK, Rule, si_units
from ffgym.robot.reading.rules import RULES
from ffgym.robot.template.proposals import Proposal

MARK = "#? "
"""Begins the lines of an entry that waits for numbers; without it they are TOML."""
_DIGITS = 5
"""Of proposed numbers per joint; rules of thumb deserve no more. Single numbers are times, which must fit exactly."""
_SOURCE = "stand-in: nobody said it; what depends on it means nothing"
_MODEL = re.compile(r'^(\s*model\s*=\s*)"([^"]*)"', re.MULTILINE)
"""The entry of [robot] that names the arm file."""


def filled_entry(proposal: Proposal, rule: Rule, types: tuple[str, ...]) -> list[str]:
    """Lines of an entry with its numbers, waiting if one of them is NaN."""
    value = proposal.value
    entries = {
        "value": _rounded(value.tolist()) if value.ndim else float(value),
        "unit": single(si_units(rule, proposal.side, types)),
        "side": proposal.side,
        "origin": proposal.origin,
        "source": proposal.source,
    }
    lines = toml_table(proposal.path, entries)
    if not np.any(np.isnan(value)):
        return lines
    lines[1] = lines[1].replace("nan", "?")
    return [MARK + line for line in lines]


def empty_entry(path: str, rule: Rule, types: tuple[str, ...]) -> list[str]:
    """Lines of an entry that waits for numbers."""
    value = np.full(rule.shape_for(len(types)), np.nan)
    lines = filled_entry(Proposal(path=path, value=value, source="?", origin="sourced", side=rule.side), rule, types)
    if rule.side == LINK and rule.gear_power is None:  # angles of joints are read in degrees
        lines[2] = lines[2].replace('"rad', '"deg')
    return lines


def filled_text(toml: str, proposals: Sequence[Proposal], types: tuple[str, ...]) -> str:
    """Text of a description with entries added, in place of their waiting lines or at the end; all else stays.

    Args:
        toml: text of the description.
        proposals: entries that it lacks.
        types: 'hinge' or 'slide', one per joint.
    """
    lines = toml.splitlines()
    for proposal in proposals:
        entry = filled_entry(proposal, RULES[proposal.path], types)
        head = f"{MARK}[{proposal.path}]"
        if head not in lines:
            lines += ["", *entry]
            continue
        start = lines.index(head)  # of the lines that wait for its numbers
        stop = start + 1
        while stop < len(lines) and lines[stop].startswith(MARK) and not lines[stop].startswith(f"{MARK}["):
            stop += 1
        lines[start:stop] = entry
    return "\n".join(lines) + "\n"


def completed_text(toml: str, draft: RobotDraft, robot: RobotDescription, *, before: Path, folder: Path) -> str:
    """Text of a description with stand-ins for all that it lacks, each of which says that it is one.

    Args:
        toml: text of the description.
        draft: what it says.
        robot: the same robot with numbers that were fitted since, which are taken where the description lacks them.
        before: folder of the description, where the path of its arm file begins.
        folder: folder that the text is for.
    """
    instead = stand_ins({path: quantity.value for path, quantity in draft.quantities.items()}, len(draft.joints))
    for path in draft.missing:
        group, _, name = path.partition(".")
        if group in GROUPS:
            instead[path] = np.asarray(getattr(getattr(robot, GROUPS[group]), name), dtype=np.float64)
    proposals = [
        Proposal(path=path, value=np.asarray(instead[path]), source=_SOURCE, side=RULES[path].side)
        for path in draft.missing
    ]

    def moved(match: re.Match[str]) -> str:
        """The path of the arm file from the other folder."""
        path = (before / match.group(2)).resolve()
        try:
            relative = Path(os.path.relpath(path, folder.resolve())).as_posix()
        except ValueError:  # another drive
            relative = path.as_posix()
        return f"{match.group(1)}{toml_value(relative)}"

    return filled_text(_MODEL.sub(moved, toml, count=1), proposals, draft.types)


def _rounded(value: Any) -> Any:
    """Nested lists of numbers to a few digits."""
    return [_rounded(entry) for entry in value] if isinstance(value, list) else float(f"{value:.{_DIGITS}g}")
