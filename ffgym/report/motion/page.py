"""Report on any motion as text for a terminal and as a page: path of the tool, errors, torques."""

from collections.abc import Mapping, Sequence
from typing import Any

from ffgym.report.laws import law_column, law_styles
from ffgym.report.motion.plot import motion_figures
from ffgym.report.page import Legend, Note, Page, Part, Section, words_of
from ffgym.report.table import Cell, Column, Table, pair, underline, wrap_text
from ffgym.robot import RobotDescription
from ffgym.studies import MotionResult, MotionStudy

_WORDS = words_of("motion")


def format_motion(study: MotionStudy) -> str:
    """Format path error, motor errors and use of the limits of each motion, one line per law."""
    parts, joints = [], list(enumerate(study.robot.joints))
    for name, reference in study.references.items():
        results = study.results_of(name)
        agents = [result.agent for result in results]
        parts.append(underline(f"{name}: {reference.duration:.2f} s, {study.robot.title}"))
        if results[0].path:
            whole = [result.path[0] for result in results]
            columns = [
                law_column("path error [mm]", agents),
                Column("RMS", [stretch.rms_mm for stretch in whole], ".3f"),
                Column("max", [stretch.max_mm for stretch in whole], ".3f"),
                Column("along: RMS", [stretch.lag_rms_mm for stretch in whole], ".3f"),
                Column("max", [stretch.lag_max_mm for stretch in whole], ".3f"),
            ]
            parts += [wrap_text(f"Path error [mm]: {_WORDS['path']}"), "", Table(columns=columns).text(), ""]
        # motor errors, torques and speeds by joint
        errors = [Column(joint, [_motor_error(one, j) for one in results], kind="name") for j, joint in joints]
        torques = [Column(joint, [one.torque_use[j] for one in results], ".1%", kind="name") for j, joint in joints]
        speeds = [Column(joint, [results[0].speed_use[j]], ".1%", kind="name") for j, joint in joints]
        parts += [wrap_text(_WORDS["joints"]), ""]
        parts += [Table(columns=[law_column("motor error [mrad]", agents), *errors]).text(), ""]
        parts += [Table(columns=[law_column("torque [%]", agents), *torques]).text(), ""]
        parts += [Table(columns=[Column("speed [%]", ["all laws"], kind="text"), *speeds]).text(), ""]
    return "\n".join(parts)


def render_motion_page(study: MotionStudy, notes: Sequence[str], info: Mapping[str, Any]) -> str:
    """Render the page as HTML.

    Args:
        study: simulated motions.
        notes: notes on the motion for the reader.
        info: provenance by name; a dict in it gives a line per entry.

    Raises:
        FFGymError: if matplotlib or jinja2 is missing.
    """
    laws = {style.label: style.colour for style in law_styles(study.agents).values()}
    words = "Simulated under its own servo and rigid feed-forward, with these feed-forward laws:"
    return Page(
        title=f"{study.robot.title}: {', '.join(reference.name for reference in study.references.values())}",
        parts=[
            Legend(words, laws),
            *map(Note, notes),
            Section("Robot", [_robot(study.robot)]),
            *(_section(study, name) for name in study.references),
        ],
        provenance=info,
    ).html()


def _section(study: MotionStudy, name: str) -> Section:
    """Lay out errors, torques and speeds of one motion in tables and figures."""
    results, reference, joints = study.results_of(name), study.references[name], range(study.robot.n_joints)
    stretches = [
        Column("stretch", [stretch.label for stretch in results[0].path], kind="text"),
        Column("from", [stretch.start for stretch in results[0].path], ".2f", unit="s"),
    ]
    limits = [
        Column("joint", study.robot.joints, kind="name"),
        Column("speed", [results[0].speed_use[j] for j in joints], ".1%"),
    ]
    # columns of each law
    styles = law_styles(result.agent for result in results)
    for result in results:
        law, colour = styles[result.agent].label, styles[result.agent].colour
        across = [pair(stretch.rms_mm, stretch.max_mm, ".3f") for stretch in result.path]
        along = [pair(stretch.lag_rms_mm, stretch.lag_max_mm, ".3f") for stretch in result.path]
        stretches += [
            Column("across: RMS (max)", across, group=law, colour=colour),
            Column("along: RMS (max)", along, group=law),
        ]
        errors = [_motor_error(result, j) for j in joints]
        limits += [
            Column("error RMS (max)", errors, unit="mrad", group=law, colour=colour),
            Column("torque", [result.torque_use[j] for j in joints], ".1%", group=law),
        ]
    parts: list[Part] = [
        Section("Joints", [Note(_WORDS["joints"]), Table(columns=limits)]),
        *motion_figures(study, name),
    ]
    if results[0].path:
        table = Table(columns=stretches, strong=[0])
        parts.insert(0, Section("Path error [mm]", [Note(f"Across and along: {_WORDS['path']}"), table]))
    return Section(f"{reference.name} ({reference.duration:.2f} s)", parts)


def _robot(robot: RobotDescription) -> Table:
    kinematics, drive = robot.kinematics, robot.drive
    units = kinematics.units
    ranges = [f"{low:.4g} to {high:.4g} {unit}" for (low, high), unit in zip(kinematics.range, units, strict=True)]
    speeds = [f"{speed:.4g} {unit}/s" for speed, unit in zip(kinematics.max_speed, units, strict=True)]
    ratios = [f"{n:.5g}{' rad/m' * (unit == 'm')}" for n, unit in zip(drive.gear_ratio, units, strict=True)]
    columns = [
        Column("joint", robot.joints, kind="name"),
        Column("type", kinematics.types, kind="text"),
        Column("range", ranges),
        Column("speed limit", speeds),
        Column("motor turns per unit of joint", ratios),
        Column("peak torque", drive.peak_torque.tolist(), ".4g", unit="N m"),
    ]
    return Table(columns=columns, name="robot")


def _motor_error(result: MotionResult, joint: int) -> Cell | None:
    return pair(result.motor_rms_rad[joint] * 1e3, result.motor_max_rad[joint] * 1e3, ".2f")
