"""The report's figures under the names of the thesis' figures."""

from collections.abc import Mapping, Sequence

from ffgym.agents.learning.progress import Learning
from ffgym.report import ReportFigure, law_styles
from ffgym.report.circles.bars import motor_error_caption, motor_error_figure
from ffgym.report.circles.friction_loops import (
    joint_loops_caption,
    joint_loops_figure,
    one_axis_loops_caption,
    one_axis_loops_figure,
)
from ffgym.report.circles.one_axis_plot import one_axis_caption, one_axis_figure
from ffgym.report.circles.paths_plot import paths_caption, paths_figure
from ffgym.report.learning.training_plot import Training, training_caption, training_figure
from ffgym.studies import CircleStudy, OneAxisStudy


def axis_friction(name: str, study: OneAxisStudy) -> list[ReportFigure]:
    """Friction of one axis over speed, and what each law adds."""
    return [
        ReportFigure(
            name=name,
            title="Friction and added torque over speed",
            thesis="",
            caption=one_axis_loops_caption(study),
            figure=one_axis_loops_figure(study),
        )
    ]


def axis_outputs(name: str, study: OneAxisStudy) -> list[ReportFigure]:
    """Speed, error and feedback of one axis over time, at the only frequency of the study."""
    [frequency] = {f for _, f in study.recordings}
    return [
        ReportFigure(
            name=name,
            title="Speed, motor error and feedback before and after",
            thesis="",
            caption=one_axis_caption(study, frequency),
            figure=one_axis_figure(study, frequency),
        )
    ]


def paths_and_errors(name: str, study: CircleStudy) -> list[ReportFigure]:
    """Path of the tool (a) and motor errors (b)."""
    return [
        ReportFigure(
            name=f"{name}a",
            title="Path of the tool",
            thesis="",
            caption=paths_caption(study),
            figure=paths_figure(study),
        ),
        ReportFigure(
            name=f"{name}b",
            title="RMS motor position error per joint",
            thesis="",
            caption=motor_error_caption(study),
            figure=motor_error_figure(study),
        ),
    ]


def joint_friction(name: str, study: CircleStudy, beside: str) -> list[ReportFigure]:
    """Friction of each joint over speed, what each law adds, and what the law `beside` would add."""
    return [
        ReportFigure(
            name=name,
            title="Friction and added torque of each joint over speed",
            thesis="",
            caption=joint_loops_caption(study, beside=beside),
            figure=joint_loops_figure(study, beside=beside),
        )
    ]


def trainings(learning: Mapping[str, Learning]) -> list[Training]:
    """How each network learned, for figures; all learn on one motion."""
    return [
        Training(title=law_styles([name])[name].label, error=each.error[:, 0], signal=each.signal[:, 0])
        for name, each in learning.items()
    ]


def training_curves(name: str, learning: Mapping[str, Learning], joints: Sequence[str]) -> list[ReportFigure]:
    """Mean squares of error and learning signal of each network over iterations."""
    return [
        ReportFigure(
            name=name,
            title="Mean squares of error and learning signal over iterations",
            thesis="",
            caption=training_caption(trainings(learning), joints),
            figure=training_figure(trainings(learning), joints),
        )
    ]
