"""The table for a new robot: what its arm file says, what can be proposed, and a place for everything else."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import wrap
from typing import Any

import numpy as np

from ffgym.core.toml import toml_table
from ffgym.robot.arm_file import ArmFile, flange_at
from ffgym.robot.reading.quantity import LINK, MOTOR, Rule
from ffgym.robot.reading.rules import POINT, RULES, needed_by
from ffgym.robot.template.proposals import Proposal
from ffgym.robot.template.text import MARK, empty_entry, filled_entry

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
    hints = _hinted(arm)
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


def _hinted(arm: ArmFile) -> dict[str, Proposal]:
    """Entries that the file hints at for some joints or all, by path; NaN stands for joints that it is silent about."""
    found = {}
    for path, (name, side, what) in _HINTS.items():
        value = np.array([getattr(hint, name) for hint in arm.hints], dtype=np.float64)  # None becomes NaN
        if path not in arm.quantities and not np.all(np.isnan(value)):
            source = f"{Path(arm.path).name}: {what}"
            found[path] = Proposal(path=path, value=value, source=source, origin="sourced", side=side)
    return found


def _head(name: str, arm: ArmFile, entries: Mapping[str, Any]) -> list[str]:
    """How to fill the table in, and who the robot is."""
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
    """Table of an entry, below what it is, how large it usually is, where it is found, and what it is for."""
    size = " x ".join(map(str, rule.shape_for(len(types))))
    sides = f"; as it counts on the {rule.side} side, or on the other, said by side" if rule.gear_power else ""
    numbers = f"{size} numbers" if size else "One number"
    own_unit = rule.slide_unit is not None and rule.side != MOTOR
    hinged = "" if own_unit and "hinge" not in types else rule.typical
    sliding = rule.sliding if "slide" in types else ""
    typical = "; ".join(dict.fromkeys(filter(None, (hinged, sliding))))
    usual = f" Usual: {typical}." if typical else ""
    titles, use = [entry.title for entry in needed_by(path)], "Optional."
    if titles:
        more = f"; and {len(titles) - _SHOWN} more" if len(titles) > _SHOWN else ""
        use = f"{'Optional, for' if rule.optional else 'For'}: {'; '.join(titles[:_SHOWN])}{more}."
    return [
        f"# --- {path}: {rule.meaning}",
        *_comment(f"{numbers}{sides}.{usual} Where: {rule.where}. {use}"),
        *(empty_entry(path, rule, types) if hint is None else filled_entry(hint, rule, types)),
    ]


def _comment(sentence: str) -> list[str]:
    return [f"# {line}" for line in wrap(sentence, _WIDTH, break_long_words=False, break_on_hyphens=False)]
