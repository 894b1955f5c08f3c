"""Report page on the circle test and the sine test: pictures, tables, findings and provenance."""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ffgym.core.files import check_writable, write_text
from ffgym.core.provenance import versions
from ffgym.report.circles.comparison import (
    FACTOR,
    SpeedTable,
    circle_tables,
    nearness,
    sine_table,
    speed_table,
    summary_table,
)
from ffgym.report.circles.errors_plot import motor_error_figure, ratios_figure
from ffgym.report.circles.findings import PARTLY, REPRODUCED, findings, headline
from ffgym.report.circles.friction_plot import joint_loops_figure, one_axis_figure, one_axis_loops_figure
from ffgym.report.circles.paths_plot import paths_figure
from ffgym.report.figure import ReportFigure
from ffgym.report.laws import law_styles
from ffgym.report.page import (
    Code,
    Items,
    Legend,
    Note,
    Page,
    Part,
    Section,
    now,
    provenance_lines,
    verdict_cell,
    words_of,
)
from ffgym.report.table import Column, Table
from ffgym.studies import CircleStudy, OneAxisStudy


def write_report(
    path: str | os.PathLike[str],
    circle_study: CircleStudy,
    one_axis_study: OneAxisStudy,
    info: Mapping[str, Any],
    commands: Sequence[str] = (),
) -> Path:
    """Write the report of both studies to `path`, whole or not at all.

    Args:
        path: the page, usually .html.
        circle_study: the circle test.
        one_axis_study: the sine test.
        info: more lines of provenance by name, e.g. seed and command; they replace lines of the same name. A dict
            in it, e.g. of versions, gives a line per entry.
        commands: commands that make the page again, and go on from it, as they run.

    Returns:
        The path.

    Raises:
        FFGymError: if matplotlib or jinja2 is missing, or the file cannot be written.
    """
    target = Path(path)
    check_writable(target)  # drawing takes seconds
    write_text(target, render_report(circle_study, one_axis_study, info, commands))
    return target


def render_report(
    circle_study: CircleStudy, one_axis_study: OneAxisStudy, info: Mapping[str, Any], commands: Sequence[str] = ()
) -> str:
    """Render the report as HTML; arguments as `write_report`."""
    tables = circle_tables(circle_study)
    styles = law_styles([*tables[0].agents, *(result.agent for result in one_axis_study.results)])
    words, robot = words_of("circles"), one_axis_study.robot.title
    shares = {"reproduced": REPRODUCED, "partly reproduced": PARTLY}
    counted = ", ".join(f"“{word}” if at least {share:.0%}" for word, share in shares.items())
    # verdicts on what is reproduced, and the sine test
    found = findings(circle_study)
    columns = [
        Column("question", [finding.question for finding in found], kind="prose"),
        Column("verdict", [verdict_cell(finding.verdict) for finding in found], kind="text"),
        Column("numbers", [finding.text for finding in found], kind="prose"),
    ]
    results = headline(circle_study, one_axis_study)
    note = words["verdicts"].format(words=counted, factor=FACTOR)
    verdicts: list[Part] = [Note(note), Table(columns=columns, name="findings")]
    sines: list[Part] = [words["sines"].format(robot=robot), sine_table(one_axis_study)]
    return Page(
        title=f"Friction compensation on {circle_study.title}",
        subtitle="Simulated circle test and sine test with feed-forward friction compensation, beside the published "
        "numbers of the real robot.",
        reading=[Legend(words["reading"], {s.label: s.colour for s in styles.values()})],
        headline=results[:1],
        parts=[
            Section("Mean path error", [words["means"], summary_table(tables), Items(results[1:])]),
            Section("What is and is not reproduced", verdicts),
            Section("Circle test", [*map(_at_speed, tables), *circle_figures(circle_study)]),
            Section("Sine test of one axis", [*sines, *one_axis_figures(one_axis_study)]),
            *[Section("Make this page again", [words["again"], Code("\n".join(commands))])] * bool(commands),
        ],
        provenance=provenance(circle_study, one_axis_study, info),
        is_dated=False,  # its provenance has the date
    ).html()


def _at_speed(table: SpeedTable) -> Section:
    near = nearness(table.ratios().values())
    if near is not None:
        note = (
            f"{near.near} of {near.total} circles without compensation are within a factor of {FACTOR:g} of the real "
            "robot; ratio: simulated over published RMS."
        )
    elif table.is_published:
        note = "No run without compensation to compare."
    else:
        note = "No numbers were published for these circles at this speed."
    title = f"Path error at {table.speed_mm_s:g} mm/s: RMS (max) [mm], in the plane of the circle"
    return Section(title, [speed_table(table), Note(note)])


def provenance(
    circle_study: CircleStudy, one_axis_study: OneAxisStudy, info: Mapping[str, Any] | None = None
) -> dict[str, str]:
    """Collect the origin of the numbers by name: robots, physics, seed, versions, time, and `info`."""
    recorded = next(iter(circle_study.recordings.values())).header.provenance
    one_axis = next(iter(one_axis_study.recordings.values())).header.provenance
    return {
        "robot": circle_study.robot.name,
        "physics fingerprint": circle_study.fingerprint,
        "one-axis robot": one_axis_study.robot.name,
        "one-axis physics fingerprint": str(one_axis.get("physics_fingerprint", "unknown")),
        "seed": str(recorded.get("seed", "unknown")),
        "physics time step": f"{recorded.get('physics_dt', 'unknown')} s",
        **provenance_lines({"versions": versions()}),
        "written": now(),
        **provenance_lines(info or {}),
    }


def circle_figures(study: CircleStudy) -> list[ReportFigure]:
    """Draw ratios (if numbers were published), paths, motor errors and friction of the circle test."""
    figures = [paths_figure(study), motor_error_figure(study)]
    if any(table.is_published for table in circle_tables(study)):
        figures.insert(0, ratios_figure(study))
    if all(recording.has("friction.effort") for recording in study.recordings.values()):  # friction is recorded
        figures.append(joint_loops_figure(study))
    return figures


def one_axis_figures(study: OneAxisStudy) -> list[ReportFigure]:
    """Draw friction over speed, and one figure over time per frequency."""
    frequencies = dict.fromkeys(frequency for _, frequency in study.recordings)
    return [one_axis_loops_figure(study), *(one_axis_figure(study, frequency) for frequency in frequencies)]
