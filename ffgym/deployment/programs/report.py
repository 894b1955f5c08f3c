"""Report of a corrected program: what was changed, by how much at most, and how the controller may differ."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from ffgym.control import SetpointResponse
from ffgym.deployment.plan import SetpointPlan, numbers_per_unit
from ffgym.deployment.programs.changes import LargestChange
from ffgym.report.figure import ReportFigure, panels
from ffgym.report.page import Items, Page, Section, words_of
from ffgym.report.table import Column, Table

if TYPE_CHECKING:
    from ffgym.deployment.programs.folder import WrittenProgram


def describe_changes(written: "WrittenProgram", plan: SetpointPlan) -> dict[str, Any]:
    """Describe what was changed as JSON values, in SI units."""
    changes = written.changes
    return {
        "program": plan.name,
        "robot": plan.robot,
        "law": plan.law,
        "format": written.format,
        "files": list(written.files),
        "setpoints": len(plan.program),
        "points": written.points,
        "duration": float(plan.t[-1]),
        "tolerance": written.tolerance,
        "read_back": asdict(written.deviation),
        "largest": {joint: asdict(one) for joint, one in zip(plan.joints, changes.joints, strict=True)},
        "largest_at_tool": asdict(changes.tool),
        "share_changed": changes.share,
    }


def format_changes(written: "WrittenProgram", plan: SetpointPlan) -> str:
    """Format what was changed for a terminal."""
    return "\n".join([_table(written, plan).text(), "", *_sentences(written, plan)])


def render_changes(written: "WrittenProgram", plan: SetpointPlan, info: Mapping[str, Any]) -> str:
    """Render the page as HTML.

    Raises:
        FFGymError: if matplotlib or jinja2 is missing.
    """
    words = words_of("programs")
    return Page(
        title=f"Corrected program of {plan.robot}: {plan.name}",
        subtitle=f"Law {plan.law}, format {written.format}: {', '.join(written.files)}",
        headline=_sentences(written, plan),
        parts=[
            Section("What was changed", [_table(written, plan), _draw(written, plan)]),
            Section("What the controller may do otherwise", [Items([words["all"], words[written.format]])]),
        ],
        provenance=info,
    ).html()


def _sentences(written: "WrittenProgram", plan: SetpointPlan) -> list[str]:
    changes, back = written.changes, written.deviation
    nothing = SetpointResponse().describe()
    undone = plan.meta.get("response", nothing)
    warning = (
        f"The plan undoes a controller with {undone}, as a stream meets it. A program rarely does: plan the motion "
        "without --controller, unless yours delays and filters programs, too."
    )
    return [
        f"The correction moves the tool by {1e3 * changes.tool.size:.3f} mm at most, at {changes.tool.t:.3f} s; "
        f"{changes.share:.0%} of the set-points are changed by more than a tenth of that.",
        f"{written.points} points of {len(plan.program)} set-points. Read back, the path is "
        f"{1e3 * back.distance:.4f} mm from the plan at most, at {back.t:.3f} s; {1e3 * written.tolerance:.4f} mm are "
        "allowed.",
        f"The plan takes {plan.t[-1]:.3f} s, the program as it is read back {back.duration:.3f} s.",
        *([] if undone == nothing else [warning]),
    ]


def _table(written: "WrittenProgram", plan: SetpointPlan) -> Table:
    """Tabulate the largest changes of the joints and of the tool."""
    scale = numbers_per_unit(plan.units)
    units = ["deg" if unit == "rad" else "mm" for unit in plan.units]
    rows: list[tuple[str, float, str, LargestChange]] = [
        (joint, one.size * s, unit, one)
        for joint, one, s, unit in zip(plan.joints, written.changes.joints, scale, units, strict=True)
    ]
    tool = written.changes.tool
    rows.append(("tool", 1e3 * tool.size, "mm", tool))
    places = [", ".join(f"{1e3 * x:.1f}" for x in one.position) for _, _, _, one in rows]
    return Table(
        columns=[
            Column("joint", [name for name, _, _, _ in rows], kind="text"),
            Column("largest change", [f"{size:.5f} {unit}" for _, size, unit, _ in rows], kind="text"),
            Column("at", [one.t for _, _, _, one in rows], ".3f", "s"),
            Column("where the tool is", places, unit="mm", kind="text"),
        ]
    )


def _draw(written: "WrittenProgram", plan: SetpointPlan) -> ReportFigure:
    """Draw the displacement of the tool in time."""
    with panels(1, 1, size=(10.0, 2.6)) as (figure, grid):
        axes = grid[0, 0]
        axes.plot(plan.t, 1e3 * written.changes.displacement, color="#0072B2")
        axes.set_xlabel("time in the plan [s]")
        axes.set_ylabel("displacement [mm]")
        axes.set_ylim(bottom=0.0, top=1.05e3 * float(np.max(written.changes.displacement)) or 1.0)
    return ReportFigure(
        name="displacement",
        title="Displacement of the tool by the correction",
        caption="What the corrected set-points add to those of the program, at the tool.",
        figure=figure,
    )
