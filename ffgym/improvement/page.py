"""An improvement as one HTML page that needs nothing else."""

from collections.abc import Mapping
from typing import Any

from ffgym.improvement.contenders import BASELINE, MODEL
from ffgym.improvement.loop import Improvement
from ffgym.improvement.text import change, verdict_of
from ffgym.report import ReportFigure
from ffgym.report.circles.paths_plot import paths_caption, paths_figure
from ffgym.report.diagnosis.words import size_text, title_of
from ffgym.report.learning.agents_plot import agents_figure
from ffgym.report.page import provenance_lines, render


def render_improvement(improvement: Improvement, info: Mapping[str, Any]) -> str:
    """HTML of the page.

    Args:
        improvement: what to show.
        info: provenance by name; a dict in it gives a line per entry.

    Raises:
        FFGymError: if matplotlib or jinja2 is missing.
    """
    scores = improvement.gain.scores
    titles = list(dict.fromkeys(score.title for score in scores))
    rows = [(title, [score for score in scores if score.title == title]) for title in titles]
    return render(
        "improvement.html.j2",
        headline=verdict_of(improvement),
        rig=improvement.rig.name,
        title=improvement.rig.robot.title,
        ended=improvement.ended,
        rounds=[_shown(each) for each in improvement.rounds],
        speeds=list(dict.fromkeys(score.speed_mm_s for score in scores)),
        rows=[(title, [(score, change(score)) for score in own]) for title, own in rows],
        figures=list(improvement_figures(improvement)),
        provenance=provenance_lines(info),
    )


def _shown(each: Any) -> dict[str, Any]:
    causes = [
        {
            "title": title_of(cause.effect),
            "joint": cause.joint,
            "sizes": "; ".join(size_text(size) for size in cause.parameters),
            "gain": f"{cause.held_out_gain:.0%}",
        }
        for cause in each.diagnosis.causes
    ]
    return {"round": each, "diagnosis": each.diagnosis, "causes": causes, "protocols": ", ".join(each.protocols)}


def improvement_figures(improvement: Improvement) -> list[ReportFigure]:
    """What laws leave, and the path of the tool before and after.

    Raises:
        FFGymError: if matplotlib is missing.
    """
    return [_laws(improvement), _paths(improvement)]


def _laws(improvement: Improvement) -> ReportFigure:
    scores = improvement.gain.scores
    speeds = list(dict.fromkeys(score.speed_mm_s for score in scores))
    errors = {
        title: [score.rms_um * 1e-3 for score in scores if score.title == title]
        for title in dict.fromkeys(score.title for score in scores)
    }
    return ReportFigure(
        name="laws",
        title="Mean path error of every law on the machine",
        thesis="",
        caption=f"Mean RMS path error, logarithmic; circles at each speed: {scores[0].circles}. No round recorded one "
        "at these places or of these sizes.",
        figure=agents_figure(errors, speeds),
    )


def _paths(improvement: Improvement) -> ReportFigure:
    both = improvement.gain.study.only(laws=[BASELINE, MODEL])
    study = both.renamed(BASELINE, "dynamic LuGre, nominal").renamed(MODEL, "extended model")
    return ReportFigure(
        name="paths",
        title="Path of the tool, dynamic LuGre with nominal parameters and the extended model",
        thesis="",
        caption=paths_caption(study),
        figure=paths_figure(study),
    )
