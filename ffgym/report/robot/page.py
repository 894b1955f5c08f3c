"""Results of a robot check in sentences and tables, as text for a terminal and as a page."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ffgym.core.types import Array
from ffgym.report.page import Items, Note, Page, Section, words_of
from ffgym.report.robot.pictures import robot_figures
from ffgym.report.table import Cell, Column, Table, underline, wrap_text
from ffgym.robot import CAPABILITIES
from ffgym.robot.inverse_kinematics import MAX_CONDITION
from ffgym.robot.reading.quantity import ORIGINS
from ffgym.robot.reading.rules import RULES
from ffgym.studies.robot_check import POSES, RobotCheck

_WORDS = words_of("robot")
_SHOWN_MODES = 3
"""Number of resonances in a table, the lowest ones, which feed-forward excites."""


def format_check(check: RobotCheck) -> str:
    """Format the check as text, at most 120 columns wide."""
    parts = [wrap_text(" ".join(facts(check)))]
    for table in robot_tables(check):
        parts.append(f"{underline(table.title)}\n{table.text()}")
        if table.note:
            parts.append(wrap_text(table.note))
    doubts = [f"- {doubt}" for doubt in check.doubts] or ["none"]
    parts.append("\n".join([underline("Doubts"), *(wrap_text(doubt) for doubt in doubts)]))
    return "\n\n".join(parts) + "\n"


def render_robot_page(check: RobotCheck, info: Mapping[str, Any]) -> str:
    """Render the page as HTML; `info` is its provenance by name. FFGymError if matplotlib or jinja2 is missing."""
    draft, figures = check.draft, robot_figures(check)
    sources = Table(
        columns=[
            Column("entry", list(draft.quantities), kind="code"),
            Column("origin", [", ".join(quantity.origin) for quantity in draft.quantities.values()], kind="text"),
            Column("source", [quantity.source for quantity in draft.quantities.values()], kind="prose"),
        ],
        name="sources",
        title="Where the robot's numbers come from",
    )
    bare = draft.geoms and all(figure.name != "looks" for figure in figures)
    doubts = Items(check.doubts) if check.doubts else "No number is out of the usual."
    return Page(
        title=draft.title,
        subtitle=f"What the description says, what it lacks, and what it amounts to. File: `{draft.where}`",
        headline=facts(check),
        parts=[
            Section("Doubts", [doubts]),
            *figures,
            *([Note("The description has shapes, but no OpenGL works here to draw them.")] if bare else []),
            *robot_tables(check),
            sources,
        ],
        provenance=info,
    ).html()


def facts(check: RobotCheck) -> list[str]:
    """Write sentences about the robot as a whole."""
    draft, servo = check.draft, check.servo
    state = "complete" if not draft.missing else f"{len(draft.missing)} entries missing"
    found = [f"{draft.title} ({draft.name}), {len(draft.joints)} joint{'s' if len(draft.joints) > 1 else ''}: {state}."]
    if draft.missing:
        found.append(f"Missing: {', '.join(draft.missing)}.")
    if check.mass is not None:
        found.append(f"The joints carry {check.mass:.4g} kg.")
    if check.reach is not None and check.reach.distance > 0:
        reach = check.reach
        tip = "The TCP" if "tool.tcp" in draft.quantities and draft.can("kinematics") else "The last link"
        box = ", ".join(f"{n} {a:.2f} to {b:.2f}" for n, a, b in zip("xyz", reach.low, reach.high, strict=True))
        found.append(f"{tip} comes up to {reach.distance:.3g} m away from the first joint, within {box} m.")
    if servo is not None and not servo.problem:
        margin = "more than 100" if servo.gain_margin is None else f"{servo.gain_margin:.3g}"
        found.append(
            f"Servo stable at {servo.place} up to {margin} times the gains; least damped oscillation "
            f"{servo.frequency:.3g} Hz with damping ratio {servo.damping:.2g}, without friction."
            if servo.stable
            else f"Servo unstable at {servo.place}, without friction."
        )
    return found


def robot_tables(check: RobotCheck) -> list[Table]:
    """List the tables of a check without empty ones."""
    tables = [_entries(check), _functions(check), _joints(check), _places(check), _loads(check), _motors(check)]
    return [table for table in tables if table.n_rows and len(table.columns) > 1]


def _entries(check: RobotCheck) -> Table:
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
    headings = ("group", "entries", *ORIGINS, "missing")
    return Table.of_rows(headings, rows, name="entries", title="What is there", note=waiting)


def _functions(check: RobotCheck) -> Table:
    words = {True: "yes", False: Cell("no", style="no")}
    rows = [(entry.title, words[check.works(entry)], _few(check.lacks[entry.name])) for entry in CAPABILITIES]
    return Table.of_rows(("function", "works", "still needed"), rows, name="functions", title="What works")


def _joints(check: RobotCheck) -> Table:
    draft = check.draft
    columns = {"joint": list(draft.joints), "type": list(draft.types)}
    values = {path: quantity.value for path, quantity in draft.quantities.items()}
    scale = np.array([1.0 if kind == "slide" else 180 / np.pi for kind in draft.types])
    units = ["m" if kind == "slide" else "deg" for kind in draft.types]
    if (limits := values.get("kinematics.range")) is not None:
        lows = limits * scale[:, None]
        columns["range"] = [f"{a:.4g} to {b:.4g} {u}" for (a, b), u in zip(lows, units, strict=True)]
    if (speed := values.get("kinematics.max_speed")) is not None:
        columns["speed"] = [f"{v:.4g} {u}/s" for v, u in zip(speed * scale, units, strict=True)]
    for path, heading, digits in (
        ("drive.gear_ratio", "gear ratio", 5),
        ("drive.rotor_inertia", "rotor [kg m^2]", 3),
        ("drive.joint_stiffness", "stiffness", 3),
        ("friction.arm_share", "friction on the arm", 3),
        ("drive.torque_lag", "torque lag [s]", 3),
        ("drive.torque_delay", "torque delay [s]", 3),
        ("drive.torque_rate", "torque rate [N m/s]", 3),
    ):
        if path in values:
            columns[heading] = [f"{v:.{digits}g}" for v in values[path]]
    if (period := values.get("drive.resolver_period")) is not None:
        columns["resolver period [s]"] = [f"{float(period):.3g}"] * len(draft.joints)
    note = "Stiffness: link side, N m/rad, or N/m for a sliding joint." if "stiffness" in columns else ""
    return _table("joints", "Joints", columns, note)


def _places(check: RobotCheck) -> Table:
    rows = []
    sliding = [kind == "slide" for kind in check.draft.types]
    for place in check.places:
        pose, condition, locked, free = "-", "-", "-", "-"
        if place.q is not None:
            scaled = [(float(x), 3) if s else (float(np.degrees(x)), 1) for x, s in zip(place.q, sliding, strict=True)]
            pose = " ".join(f"{round(x, digits) + 0.0:.{digits}f}" for x, digits in scaled)  # and no -0.0
        if place.condition is not None:
            condition = "singular" if place.condition > MAX_CONDITION else f"{place.condition:.3g}"
        if (found := (check.resonances or {}).get(place.name)) is not None:
            locked, free = _modes(found.locked), _modes(found.free)
        rows.append((place.name, "yes" if place.q is not None else "no", condition, pose, locked, free))
    headings = ("place", "reached", "condition", "joints", "resonances, motors held [Hz]", "motors free [Hz]")
    note = _WORDS["places"].format(most=MAX_CONDITION)
    return Table.of_rows(headings, rows, name="places", title="Places", note=note)


def _loads(check: RobotCheck) -> Table:
    columns = {"joint": list(check.draft.joints)}
    if check.gravity is not None:
        columns |= {f"at {name}": _numbers(torque) for name, torque in check.gravity.places.items()}
        columns["worst"] = _numbers(check.gravity.worst)
        if check.gravity.motor_worst is not None:
            columns["worst, motor side"] = _numbers(check.gravity.motor_worst)
    return _table("gravity", "Gravity load", columns, _WORDS["loads"].format(poses=POSES))


def _motors(check: RobotCheck) -> Table:
    columns = {"joint": list(check.draft.joints)}
    if check.inertia is not None:
        columns["links / rotor"] = _numbers(check.inertia.ratio)
    if (margin := check.margin) is not None:
        columns |= {"peak [N m]": _numbers(margin.peak), "gravity": _shares(margin.gravity / margin.peak)}
        columns["breakaway"] = _shares(margin.breakaway / margin.peak)
        columns["friction at speed limit"] = _shares(margin.friction_at_speed / margin.peak)
        columns |= {"left at start": _shares(margin.at_start), "acceleration": _numbers(margin.acceleration)}
    return _table("motors", "Motors", columns, _WORDS["motors"])


def _table(name: str, title: str, columns: Mapping[str, Sequence[str]], note: str) -> Table:
    """Make a table from cells by heading."""
    texts = [Column(heading, cells, kind="text") for heading, cells in columns.items()]
    return Table(columns=texts, name=name, title=title, note=note)


def _few(paths: Sequence[str], room: int = 2) -> str:
    """Name the first paths, and the number of others."""
    more = f" and {len(paths) - room} more" if len(paths) > room else ""
    return ", ".join(paths[:room]) + more


def _modes(frequencies: Array | None) -> str:
    if frequencies is None:
        return "-"
    return " ".join(f"{f:.3g}" for f in frequencies[:_SHOWN_MODES]) or "rigid"


def _numbers(values: Array) -> list[str]:
    """Format numbers with three digits; zero but for rounding becomes 0."""
    return [f"{0.0 if abs(value) < 1e-9 else value:.3g}" for value in values]


def _shares(values: Array) -> list[str]:
    return [f"{value:.0%}" for value in values]
