"""A diagnosis on a page that can be sent, for readers who do not know the tool."""

from collections.abc import Sequence
from typing import Any

from ffgym.diagnosis.held_out import LoopLevel
from ffgym.diagnosis.regimes import REGIMES
from ffgym.diagnosis.result import Level, Rival
from ffgym.report.diagnosis.diagnosis_report import DiagnosisReport
from ffgym.report.diagnosis.figures import (
    candidate_figures,
    level_figures,
    map_figures,
    place_figures,
    tool_figures,
)
from ffgym.report.diagnosis.joint_units import in_joint_units
from ffgym.report.diagnosis.models import FINE
from ffgym.report.diagnosis.words import VERDICTS, place_of, rivals_of, signature_of, size_text, title_of, together
from ffgym.report.figure import ReportFigure
from ffgym.report.page import provenance_lines, render

_MOST_RIVALS = 8
"""Rivals of a cause that the table lists, those that explain most; a tie is always listed."""


def render_diagnosis_page(report: DiagnosisReport) -> str:
    """HTML of the page; the same diagnosis gives the same bytes.

    Raises:
        FFGymError: if matplotlib or jinja2 is missing.
    """
    diagnosis = in_joint_units(report.diagnosis, None if report.before is None else report.before.robot)
    return render(
        "diagnosis.html.j2",
        diagnosis=diagnosis,
        regimes=REGIMES,
        meaning=VERDICTS[diagnosis.verdict],
        verdicts=VERDICTS,
        causes=[(cause, title_of(cause.effect), signature_of(cause.effect)) for cause in diagnosis.causes],
        size_text=size_text,
        place_of=place_of,
        rivals=[(cause, _listed(rivals_of(diagnosis, cause))) for cause in diagnosis.causes],
        not_excited=together(diagnosis.not_excited),
        not_judgeable=together(diagnosis.not_judgeable),
        levels=[
            _readable(level, "measured", "noise_floor", "before", "after") | {"left": diagnosis.tell_left(level)}
            for level in diagnosis.levels
        ],
        held_out=[_readable(level, "measured", "before", "after") for level in report.held_out],
        closed_loop=[_readable(level, "measured", "before", "after") for level in report.closed_loop],
        figures=_figures(report),
        provenance=provenance_lines(diagnosis.provenance),
    )


def _figures(report: DiagnosisReport) -> dict[str, list[ReportFigure]]:
    """Pictures by the section that they stand in, in the order of the page."""
    return {
        "gain": level_figures(report),
        "maps": map_figures(report),
        "evidence": [
            *(figure for place in report.places for figure in place_figures(report, place)),
            *tool_figures(report),
        ],
        "candidates": candidate_figures(report),
    }


def _listed(rivals: Sequence[Rival]) -> list[Rival]:
    return [rival for i, rival in enumerate(rivals) if rival.tied or i < _MOST_RIVALS]


def _readable(level: Level | LoopLevel, *names: str) -> dict[str, Any]:
    """A level with its numbers in the unit in which people read them."""
    factor, unit = FINE[level.unit]
    return vars(level) | {"unit": unit} | {name: factor * getattr(level, name) for name in names}
