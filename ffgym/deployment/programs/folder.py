"""A corrected program in a folder: the files of a controller, compared with the plan before they are written."""

import json
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.files import new_folder, write_text
from ffgym.core.types import Array
from ffgym.deployment.plan import SetpointPlan, check_fits
from ffgym.deployment.programs.changes import ProgramChanges, measure_changes
from ffgym.deployment.programs.deviation import PathDeviation, measure_deviation
from ffgym.deployment.programs.krl import read_krl, write_krl
from ffgym.deployment.programs.points import (
    TOLERANCE,
    choose_points,
    count_digits,
    tool_levers,
)
from ffgym.deployment.programs.rapid import read_rapid, write_rapid
from ffgym.deployment.programs.scripts import read_csv, read_servo_script, write_csv, write_servo_script
from ffgym.deployment.streams import ServoProgram
from ffgym.robot import RigidArm

FORMATS: Mapping[str, str] = {
    "rapid": "module of MoveAbsJ for ABB (.mod)",
    "krl": "PTP splines for KUKA (.src, .dat)",
    "urscript": "servoj for Universal Robots (.script)",
    "csv": "table of joint positions (.csv)",
}
"""Formats of programs, with what they are."""


@dataclass(frozen=True, kw_only=True)
class WrittenProgram:
    """A program that was written, and how it differs from its plan and from the program without correction."""

    format: str
    files: tuple[str, ...]
    """Names of the files in the folder."""
    points: int
    """Points of the path that are written."""
    tolerance: float
    """Largest distance of the tool from the plan that was allowed [m]."""
    deviation: PathDeviation
    changes: ProgramChanges


def write_program(
    plan: SetpointPlan,
    arm: RigidArm,
    folder: str | os.PathLike[str],
    format: str,
    *,
    tolerance: float = TOLERANCE,
    period: float | None = None,
    servo: ServoProgram | None = None,
    report: Mapping[str, Any] | None = None,
    tell: Callable[[str, float], None] = lambda what, share: None,
) -> WrittenProgram:
    """Write a plan as a program for a controller, with a report of what was changed.

    The files are read back, RAPID with the corners that zones make, and compared with the plan.

    Args:
        plan: set-points with their correction.
        arm: the robot of the plan.
        folder: folder to write; it must be empty or not exist.
        format: one of FORMATS.
        tolerance: largest distance of the tool from the plan [m].
        period: time that points of RAPID and KRL are apart at least [s]; None leaves it to the path.
        servo: how servoj follows (URScript); None takes the defaults.
        report: provenance by name for the page; None writes no page.
        tell: function that is called with what is being done, and the share of the work that is done.

    Raises:
        FFGymError: if the controller cannot have the robot's joints, or the path read back is farther from the plan
            than the tolerance; nothing is written then.
    """
    check_choice("format of program", format, list(FORMATS))
    check_fits(plan, arm.robot)
    tell("choosing points", 0.0)
    files, points = _texts(plan, arm, format, tolerance, period, servo or ServoProgram())
    tell("reading the program back", 0.3)
    path, duration = _read(files, arm, format)
    tell("comparing it with the plan", 0.8)
    deviation = measure_deviation(arm, plan.setpoints, plan.t, path, duration)
    if not deviation.distance <= tolerance:
        closer = "" if period is None else ", or points closer in time (period, --period-ms)"
        raise FFGymError(
            f"The {format} program is {1e3 * deviation.distance:.4f} mm from the plan at {deviation.t:.3f} s, may be "
            f"{1e3 * tolerance:.4f} mm from it. Allow more (tolerance, --tolerance-mm){closer}."
        )
    written = WrittenProgram(
        format=format,
        files=tuple(files),
        points=points,
        tolerance=tolerance,
        deviation=deviation,
        changes=measure_changes(plan, arm),
    )
    pages = {} if report is None else _pages(written, plan, report)
    with new_folder(folder) as place:
        for name, text in (files | pages).items():
            write_text(place / name, text)
    return written


def _texts(
    plan: SetpointPlan, arm: RigidArm, format: str, tolerance: float, period: float | None, servo: ServoProgram
) -> tuple[dict[str, str], int]:
    """Texts of the files by name, and the number of points."""
    if format == "urscript":
        return write_servo_script(plan, servo), len(plan.program)
    if format == "csv":
        digits = count_digits(tool_levers(arm, plan.setpoints), plan.units, tolerance)
        return write_csv(plan, digits), len(plan.program)
    points = choose_points(plan, arm, tolerance=tolerance, period=period)
    return write_rapid(points, arm) if format == "rapid" else write_krl(points), len(points.t)


def _read(files: dict[str, str], arm: RigidArm, format: str) -> tuple[Array, float]:
    """Joint positions along the path of written files, and its duration [s]."""
    if format == "rapid":
        return read_rapid(files, arm)
    if format == "urscript":
        return read_servo_script(files)
    units = tuple(arm.robot.kinematics.units)
    return read_krl(files, units) if format == "krl" else read_csv(files, units)


def _pages(written: WrittenProgram, plan: SetpointPlan, info: Mapping[str, Any]) -> dict[str, str]:
    from ffgym.deployment.programs.report import describe_changes, render_changes

    numbers = json.dumps(dict(info) | describe_changes(written, plan), indent=2) + "\n"
    return {"changes.html": render_changes(written, plan, info), "changes.json": numbers}
