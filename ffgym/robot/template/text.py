"""The table for a new robot: its entries as TOML text, with what is known filled in and a place for everything else."""

import os
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from textwrap import wrap
from typing import Any

import numpy as np

from ffgym.core.toml import single, toml_table, toml_value
from ffgym.robot.arm_file import ArmFile, flange_at
from ffgym.robot.description import RobotDescription
from ffgym.robot.reading.draft import RobotDraft, stand_ins
from ffgym.robot.reading.load import GROUPS
from ffgym.robot.reading.quantity import LINK, MOTOR, Rule, si_units
from ffgym.robot.reading.rules import POINT, RULES, list_capabilities_needing
from ffgym.robot.template.proposals import Proposal

MARK = "#? "
"""Begins the lines of an entry that waits for numbers; without it they are TOML."""
_DIGITS = 5
"""Digits of proposed numbers per joint; rules of thumb deserve no more. Single numbers are times, which must fit
exactly."""
_SOURCE = "stand-in: unknown; results that depend on it mean nothing"
_MODEL = re.compile(r'^(\s*model\s*=\s*)"([^"]*)"', re.MULTILINE)
"""The entry of [robot] that names the arm file."""


def fill_entry(proposal: Proposal, rule: Rule, types: tuple[str, ...]) -> list[str]:
    """Write lines of an entry with its numbers; it waits if one of them is NaN."""
    value = proposal.value
    entries = {
        "value": _round(value.tolist()) if value.ndim else float(value),
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
    """Write lines of an entry that waits for numbers."""
    value = np.full(rule.shape_for(len(types)), np.nan)
    lines = fill_entry(Proposal(path=path, value=value, source="?", origin="sourced", side=rule.side), rule, types)
    if rule.side == LINK and rule.gear_power is None:  # angles of joints are read in degrees
        lines[2] = lines[2].replace('"rad', '"deg')
    return lines


def fill_text(toml: str, proposals: Sequence[Proposal], types: tuple[str, ...]) -> str:
    """Add entries to the text of a description, in place of their waiting lines or at the end; all else stays.

    Args:
        toml: text of the description.
        proposals: entries that it lacks.
        types: 'hinge' or 'slide', one per joint.
    """
    lines = toml.splitlines()
    for proposal in proposals:
        entry = fill_entry(proposal, RULES[proposal.path], types)
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


def complete_text(toml: str, draft: RobotDraft, robot: RobotDescription, *, before: Path, folder: Path) -> str:
    """Complete the text of a description by stand-ins for all absent entries, which are marked as such.

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
    model = _MODEL.search(toml)
    if model is not None:  # the arm file, from the other folder
        file = (before / model[2]).resolve()
        with suppress(ValueError):  # raised where it is on another drive
            file = Path(os.path.relpath(file, folder.resolve()))
        toml = f"{toml[: model.start()]}{model[1]}{toml_value(file.as_posix())}{toml[model.end() :]}"
    return fill_text(toml, proposals, draft.types)


def _round(value: Any) -> Any:
    """Round nested lists of numbers to a few digits."""
    return [_round(entry) for entry in value] if isinstance(value, list) else float(f"{value:.{_DIGITS}g}")


_SIMULATED = "a simulator's number unless measured"
_HINTS: Mapping[str, tuple[str, str | None, str]] = {
    "kinematics.max_speed": ("speed", LINK, "speed limits"),
    "drive.gear_ratio": ("gear_ratio", None, "gear of transmission or actuator"),
    "drive.rotor_inertia": ("armature", LINK, f"armature, the rotor at the joint; {_SIMULATED}"),
    "drive.peak_torque": ("effort", LINK, "effort or force limits"),
    "friction.coulomb": ("friction", LINK, f"joint friction; {_SIMULATED}"),
    "friction.viscous": ("damping", LINK, f"joint damping; {_SIMULATED}"),
}
"""Entry, the field of `JointHints` that hints at it, the side it is on, and what it is in the file."""

_WIDTH = 118
"""Columns of comments."""
TOOL_FRAMES = ("tcp", "tool0", "tool", "flange", "ee_link", "ee", "attachment_site")
"""Names that frames for tools usually have, the most likely one first."""
_SHOWN = 3
"""Functions that a comment names."""


def template(
    name: str,
    arm: ArmFile,
    model: str,
    *,
    joints: Sequence[str] | None = None,
    tool_frame: str | None = None,
    looks: bool = True,
) -> str:
    """TOML text of a description to fill in.

    Args:
        name: of the robot.
        arm: the arm file.
        model: its path as the description is to say it.
        joints: joints that move, if not all.
        tool_frame: frame of the last link that is tool0; None takes one with a usual name, if there is one.
        looks: whether the description takes the shapes of the file.

    Raises:
        FFGymError: if there is no such frame.
    """
    frame = tool_frame or next((usual for usual in TOOL_FRAMES if usual in arm.frames), None)
    given = set(arm.quantities) | (set(flange_at(arm, frame)) if frame else set())
    hints = _list_hints(arm)
    blocks = {path: _block(path, rule, hints.get(path), arm.types) for path, rule in RULES.items() if path not in given}
    head = {"name": name, "title": name, "model": model, "joints": None if joints is None else list(joints)}
    head |= {"tool_frame": frame, "looks": None if looks else "none"}
    said = _comment(f"The arm file says: {', '.join(path for path in RULES if path in given)}.")
    said += _comment("A table of that name here replaces what it says, e.g. better masses.")
    for note in arm.notes:
        said += _comment(f"Note: {note}.")
    points = (
        "# --- work_area.positions.NAME: points in the world where the tool works, for circles and by name in motions"
    )
    parts = [
        _head(name, arm, head),
        said,
        *(block for path, block in blocks.items() if not RULES[path].optional),
        ["# ------ What follows is optional."],
        *(block for path, block in blocks.items() if RULES[path].optional),
        [points, "# Optional, any number of them.", *empty_entry("work_area.positions.p1", POINT, arm.types)],
    ]
    return "\n\n".join("\n".join(part) for part in parts) + "\n"


def _list_hints(arm: ArmFile) -> dict[str, Proposal]:
    """List entries that the file hints at for some joints or all, by path; NaN stands for joints without a hint."""
    found = {}
    for path, (name, side, what) in _HINTS.items():
        value = np.array([getattr(hint, name) for hint in arm.hints], dtype=np.float64)  # None becomes NaN
        if path not in arm.quantities and not np.all(np.isnan(value)):
            source = f"{Path(arm.path).name}: {what}"
            found[path] = Proposal(path=path, value=value, source=source, origin="sourced", side=side)
    return found


def _head(name: str, arm: ArmFile, entries: Mapping[str, Any]) -> list[str]:
    """Write instructions, and the table of the robot's names."""
    mark = MARK.strip()
    lines = _comment(
        f"{name}: a robot to fill in, from {Path(arm.path).name}. Lines that begin with '{mark}' wait for numbers: put "
        f"numbers for the question marks and take '{mark}' away. Every number says where it comes from: origin is "
        "sourced (published), derived (computed from published numbers), chosen (source says why) or fitted."
    )
    lines += _comment("ffgym robot check FILE says what is missing, and what works without it.")
    lines += _comment("ffgym robot fill FILE fills in what follows from the rest by rules of thumb.")
    lines += ["", *toml_table("robot", entries)]
    lines += _comment(f"Its joints, from the base outwards: {', '.join(arm.joints)}.")
    if arm.frames:
        lines += _comment(f"Frames on {arm.links[-1]} that tool_frame may name: {', '.join(arm.frames)}.")
    return lines


def _block(path: str, rule: Rule, hint: Proposal | None, types: tuple[str, ...]) -> list[str]:
    """Write the table of an entry, below comments on its meaning, usual size, source and use."""
    size = " x ".join(map(str, rule.shape_for(len(types))))
    sides = f"; as it counts on the {rule.side} side, or on the other, said by side" if rule.gear_power else ""
    numbers = f"{size} numbers" if size else "One number"
    own_unit = rule.slide_unit is not None and rule.side != MOTOR
    hinged = "" if own_unit and "hinge" not in types else rule.typical
    sliding = rule.sliding if "slide" in types else ""
    typical = "; ".join(dict.fromkeys(filter(None, (hinged, sliding))))
    usual = f" Usual: {typical}." if typical else ""
    titles, use = [entry.title for entry in list_capabilities_needing(path)], "Optional."
    if titles:
        more = f"; and {len(titles) - _SHOWN} more" if len(titles) > _SHOWN else ""
        use = f"{'Optional, for' if rule.optional else 'For'}: {'; '.join(titles[:_SHOWN])}{more}."
    return [
        f"# --- {path}: {rule.meaning}",
        *_comment(f"{numbers}{sides}.{usual} Where: {rule.where}. {use}"),
        *(empty_entry(path, rule, types) if hint is None else fill_entry(hint, rule, types)),
    ]


def _comment(sentence: str) -> list[str]:
    return [f"# {line}" for line in wrap(sentence, _WIDTH, break_long_words=False, break_on_hyphens=False)]
