"""What a robot check found, as tables of text."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array
from ffgym.robot import CAPABILITIES
from ffgym.robot.inverse_kinematics import MAX_CONDITION
from ffgym.robot.reading.quantity import ORIGINS
from ffgym.robot.reading.rules import RULES
from ffgym.studies.robot_check import POSES, Place, RobotCheck

_SHOWN_MODES = 3
"""Resonances that a table shows, the lowest ones: those that feed-forward meets."""


@dataclass(frozen=True, kw_only=True)
class FactTable:
    """A table of text."""

    name: str
    title: str
    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""


def robot_tables(check: RobotCheck) -> list[FactTable]:
    """All tables of a check, those with nothing in them left out."""
    tables = [_entries(check), _functions(check), _joints(check), _places(check), _loads(check), _motors(check)]
    return [table for table in tables if table.rows]


def _entries(check: RobotCheck) -> FactTable:
    draft = check.draft
    groups = dict.fromkeys(path.split(".")[0] for path in (*RULES, *draft.quantities))
    rows = []
    for group in groups:
        own = [quantity for path, quantity in draft.quantities.items() if path.split(".")[0] == group]
        origins = Counter(origin for quantity in own for origin in dict.fromkeys(quantity.origin))
        lacking = [path.split(".")[1] for path in draft.missing if path.split(".")[0] == group]
        if own or lacking:
            counts = [str(origins[origin] or "") for origin in ORIGINS]
            rows.append((group, str(len(own)), *counts, _few(lacking)))
    waiting = f"{', '.join(draft.waiting)}: counted once drive.gear_ratio is there." if draft.waiting else ""
    return FactTable(
        name="entries",
        title="What is there",
        headings=("group", "entries", *ORIGINS, "missing"),
        rows=tuple(rows),
        note=waiting,
    )


def _functions(check: RobotCheck) -> FactTable:
    rows = [
        (entry.title, "yes" if check.works(entry) else "no", _few(check.lacks[entry.name])) for entry in CAPABILITIES
    ]
    return FactTable(
        name="functions", title="What works", headings=("function", "works", "still needed"), rows=tuple(rows)
    )


def _joints(check: RobotCheck) -> FactTable:
    draft = check.draft
    columns: list[tuple[str, list[str]]] = [("joint", list(draft.joints)), ("type", list(draft.types))]
    values = {path: quantity.value for path, quantity in draft.quantities.items()}
    scale = np.array([1.0 if kind == "slide" else 180 / np.pi for kind in draft.types])
    units = ["m" if kind == "slide" else "deg" for kind in draft.types]
    if (limits := values.get("kinematics.range")) is not None:
        lows = limits * scale[:, None]
        columns.append(("range", [f"{a:.4g} to {b:.4g} {u}" for (a, b), u in zip(lows, units, strict=True)]))
    if (speed := values.get("kinematics.max_speed")) is not None:
        columns.append(("speed", [f"{v:.4g} {u}/s" for v, u in zip(speed * scale, units, strict=True)]))
    for path, heading, digits in (
        ("drive.gear_ratio", "gear ratio", 5),
        ("drive.rotor_inertia", "rotor [kg m^2]", 3),
        ("drive.joint_stiffness", "stiffness", 3),
    ):
        if path in values:
            columns.append((heading, [f"{v:.{digits}g}" for v in values[path]]))
    note = "Stiffness: link side, N m/rad, or N/m for a sliding joint." if columns[-1][0] == "stiffness" else ""
    return _table("joints", "Joints", columns, note)


def _places(check: RobotCheck) -> FactTable:
    rows = []
    for place in check.places:
        condition = "-" if place.condition is None else _condition(place.condition)
        found = (check.resonances or {}).get(place.name)
        locked, free = ("-", "-") if found is None else (_modes(found.locked), _modes(found.free))
        rows.append((place.name, "yes" if place.q is not None else "no", condition, _pose(check, place), locked, free))
    return FactTable(
        name="places",
        title="Places",
        headings=("place", "reached", "condition", "joints", "resonances, motors held [Hz]", "motors free [Hz]"),
        rows=tuple(rows),
        note=f"Condition: of the Jacobian of the TCP; above {MAX_CONDITION:g} a path counts as too near a singularity.",
    )


def _loads(check: RobotCheck) -> FactTable:
    columns: list[tuple[str, list[str]]] = [("joint", list(check.draft.joints))]
    if check.gravity is not None:
        columns += [(f"at {name}", _numbers(torque)) for name, torque in check.gravity.places.items()]
        columns.append(("worst", _numbers(check.gravity.worst)))
        if check.gravity.motor_worst is not None:
            columns.append(("worst, motor side", _numbers(check.gravity.motor_worst)))
    note = (
        f"Torque that holds the arm still, link side [N m; N for a sliding joint]; worst: over {POSES} poses in the "
        "ranges."
    )
    return _table("gravity", "Gravity load", columns if len(columns) > 1 else [], note)


def _motors(check: RobotCheck) -> FactTable:
    columns: list[tuple[str, list[str]]] = [("joint", list(check.draft.joints))]
    if check.inertia is not None:
        columns.append(("links / rotor", _numbers(check.inertia.ratio)))
    if (margin := check.margin) is not None:
        columns += [("peak [N m]", _numbers(margin.peak)), ("gravity", _shares(margin.gravity / margin.peak))]
        columns += [("breakaway", _shares(margin.breakaway / margin.peak))]
        columns += [("friction at speed limit", _shares(margin.friction_at_speed / margin.peak))]
        columns += [("left at start", _shares(margin.at_start)), ("acceleration", _numbers(margin.acceleration))]
    circles = check.circles
    if circles is not None and circles.torque is not None and circles.joint_speed is not None:
        columns += [("circles: torque", _shares(circles.torque)), ("circles: speed", _shares(circles.joint_speed))]
    note = (
        "Links / rotor: inertia at the motor. Shares are of the peak torque, gravity in its worst pose; friction at "
        "the speed limit by the viscous line, which overstates it. Acceleration: of one joint alone at home "
        "[rad/s^2, m/s^2]."
    )
    if circles is not None:
        note += f" Circles: 1, 3 and 5 mm at all positions at {circles.speed * 1e3:g} mm/s"
        note += f": cannot be followed. {circles.problem}" if circles.problem else ", rigid arm."
    return _table("motors", "Motors", columns if len(columns) > 1 else [], note)


def _table(name: str, title: str, columns: Sequence[tuple[str, list[str]]], note: str) -> FactTable:
    """Table from columns with headings; none gives no rows."""
    rows = tuple(zip(*(cells for _, cells in columns), strict=True)) if columns else ()
    return FactTable(name=name, title=title, headings=tuple(heading for heading, _ in columns), rows=rows, note=note)


def _few(paths: Sequence[str], room: int = 2) -> str:
    """The first paths, and how many more there are."""
    more = f" and {len(paths) - room} more" if len(paths) > room else ""
    return ", ".join(paths[:room]) + more


def _pose(check: RobotCheck, place: Place) -> str:
    if place.q is None:
        return "-"
    scaled = [x if kind == "slide" else np.degrees(x) for x, kind in zip(place.q, check.draft.types, strict=True)]
    digits = [3 if kind == "slide" else 1 for kind in check.draft.types]
    return " ".join(f"{round(float(x), d) + 0.0:.{d}f}" for x, d in zip(scaled, digits, strict=True))  # and no -0.0


def _condition(number: float) -> str:
    return "singular" if number > MAX_CONDITION else f"{number:.3g}"


def _modes(frequencies: Array | None) -> str:
    if frequencies is None:
        return "-"
    return " ".join(f"{f:.3g}" for f in frequencies[:_SHOWN_MODES]) or "rigid"


def _numbers(values: Array) -> list[str]:
    """Three digits; what is zero but for rounding is 0."""
    return [f"{0.0 if abs(value) < 1e-9 else value:.3g}" for value in values]


def _shares(values: Array) -> list[str]:
    return [f"{value:.0%}" for value in values]
