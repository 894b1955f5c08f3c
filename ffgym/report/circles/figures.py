"""Every figure of the report, with its caption and the figure of the thesis that it corresponds to."""

from ffgym.report.circles.bars import motor_error_caption, motor_error_figure
from ffgym.report.circles.comparison import circle_tables
from ffgym.report.circles.friction_loops import (
    joint_loops_caption,
    joint_loops_figure,
    one_axis_loops_caption,
    one_axis_loops_figure,
)
from ffgym.report.circles.one_axis_plot import one_axis_caption, one_axis_figure
from ffgym.report.circles.paths_plot import paths_caption, paths_figure
from ffgym.report.circles.ratios_plot import ratios_caption, ratios_figure
from ffgym.report.figure import ReportFigure
from ffgym.studies import CircleStudy, OneAxisStudy


def circle_figures(study: CircleStudy) -> list[ReportFigure]:
    """Ratios (where numbers were published), paths, motor errors and friction of the circle test."""
    ratios = (
        ReportFigure(
            name="ratios",
            title="How near the simulated robot is to the published one",
            thesis="Tables 4.1, 4.2, 5.1 and 5.2",
            caption=ratios_caption(study),
            figure=ratios_figure(study),
        )
        if any(table.is_published for table in circle_tables(study))
        else None
    )
    others = [
        ReportFigure(
            name="paths",
            title="Path of the tool",
            thesis="Figures 4.6a to 4.9a (simulated), 4.10a to 4.12a (real robot)",
            caption=paths_caption(study),
            figure=paths_figure(study),
        ),
        ReportFigure(
            name="motor-errors",
            title="Motor position error per joint",
            thesis="Figures 4.6b to 4.9b (simulated), 4.10b to 4.12b (real robot)",
            caption=motor_error_caption(study),
            figure=motor_error_figure(study),
        ),
    ]
    return [*([ratios] if ratios else []), *others, *_joint_friction(study)]


def _joint_friction(study: CircleStudy) -> list[ReportFigure]:
    """Friction of each joint, on a robot that lets its true friction be seen."""
    if not all(recording.has("friction.effort") for recording in study.recordings.values()):
        return []
    return [
        ReportFigure(
            name="joint-friction",
            title="Friction of each joint over speed",
            thesis="in the manner of Figure 5.11",
            caption=joint_loops_caption(study),
            figure=joint_loops_figure(study),
        )
    ]


def one_axis_figures(study: OneAxisStudy) -> list[ReportFigure]:
    """Friction over speed, and one figure over time per frequency."""
    loops = ReportFigure(
        name="one-axis-friction",
        title="Friction of one axis over speed",
        thesis="Figures 4.2 (1 Hz) and 4.4 (3 Hz)",
        caption=one_axis_loops_caption(study),
        figure=one_axis_loops_figure(study),
    )
    frequencies = dict.fromkeys(f for _, f in study.recordings)
    return [loops, *(_sine_figure(study, f) for f in frequencies)]


def _sine_figure(study: OneAxisStudy, frequency: float) -> ReportFigure:
    thesis = {1.0: "Figure 4.3", 3.0: "Figure 4.5"}.get(frequency, "not shown at this frequency")
    return ReportFigure(
        name=f"one-axis-{frequency:g}-hz",
        title=f"One axis on a sine of {frequency:g} Hz",
        thesis=thesis,
        caption=one_axis_caption(study, frequency),
        figure=one_axis_figure(study, frequency),
    )
