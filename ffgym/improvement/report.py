"""Report on an improvement as text for a terminal, and as one HTML page."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ffgym.diagnosis.held_out_share import compute_held_out_share
from ffgym.improvement.gain import BASELINE, MODEL, LawScore
from ffgym.improvement.loop import Improvement
from ffgym.improvement.rounds import ImprovementRound
from ffgym.report import Column, Note, Page, ReportFigure, Section, Table, wrap_text
from ffgym.report.circles.comparison import percent
from ffgym.report.circles.paths_plot import paths_figure
from ffgym.report.diagnosis.words import size_text, title_of
from ffgym.report.learning_plots import agents_figure
from ffgym.report.table import pair


def format_improvement(improvement: Improvement) -> str:
    """Format the findings of each round, and the path errors of the laws."""
    parts = [wrap_text(line) for each in improvement.rounds for line in _round_lines(each)]
    table = _scores(improvement, with_largest=False)
    parts += [wrap_text(f"ended: {improvement.ended}"), "", table.text(), "", wrap_text(write_verdict(improvement))]
    return "\n".join(parts)


def render_improvement(improvement: Improvement, info: Mapping[str, Any]) -> str:
    """Render the page as HTML.

    Args:
        improvement: the improvement.
        info: provenance by name; a dict in it gives a line per entry.

    Raises:
        FFGymError: if matplotlib or jinja2 is missing.
    """
    laws, paths = improvement_figures(improvement)
    note = (
        "Means over circles that no round recorded, measured by the machine's own tracker. Change against dynamic "
        "LuGre with nominal parameters, and on how many circles the error is smaller. Friction of the “identified” "
        "laws was identified from the recordings of the first round."
    )
    return Page(
        title="What the extended model gains",
        subtitle=f"{improvement.rig.robot.title}, machine: {improvement.rig.name}. Recorded, diagnosed and extended in "
        "rounds; then feed-forward from the model before and after ran on the machine.",
        headline=[write_verdict(improvement)],
        parts=[
            Section("Path error", [laws, _scores(improvement, with_largest=True), Note(note), paths]),
            Section("Rounds", [_rounds(improvement), Note(f"Ended as {improvement.ended}.")]),
        ],
        provenance=info,
        is_dated=False,
    ).html()


def improvement_figures(improvement: Improvement) -> list[ReportFigure]:
    """Draw path errors of the laws, and the path of the tool before and after.

    Raises:
        FFGymError: if matplotlib is missing.
    """
    errors = {law: [score.rms_um * 1e-3 for score in own] for law, own in _by_law(improvement).items()}
    both = improvement.gain.study.only(laws=[BASELINE, MODEL])
    study = both.rename(BASELINE, "dynamic LuGre, nominal").rename(MODEL, "extended model")
    return [
        ReportFigure(
            name="laws",
            title="Mean path error of every law on the machine",
            caption=f"Mean RMS path error, logarithmic; circles at each speed: {improvement.gain.scores[0].circles}. "
            "No round recorded one at these places or of these sizes.",
            figure=agents_figure(errors, _speeds(improvement)),
        ),
        replace(
            paths_figure(study),
            title="Path of the tool, dynamic LuGre with nominal parameters and the extended model",
            thesis="",
        ),
    ]


def write_verdict(improvement: Improvement) -> str:
    """Write the gain of the model of the last round in one sentence."""
    own = [score for score in improvement.gain.scores if score.law == MODEL]
    said = ", ".join(f"{percent(score.against)} at {score.speed_mm_s:g} mm/s" for score in own)
    better, circles = (sum(getattr(score, name) for score in own) for name in ("better_on", "circles"))
    return (
        f"Feed-forward from the extended model against dynamic LuGre with nominal parameters, mean RMS path error: "
        f"{said}; smaller on {better} of {circles} circles that no round recorded."
    )


def _scores(improvement: Improvement, *, with_largest: bool) -> Table:
    """Tabulate mean RMS path error of every law at every speed [um], and its change against dynamic LuGre.

    Args:
        improvement: improvement with the scores.
        with_largest: True for largest errors, and the number of circles on which a law is better.
    """
    laws = _by_law(improvement)
    columns = [Column("mean RMS path error", list(laws), kind="text")]
    for k, speed in enumerate(_speeds(improvement)):
        scores, group = [own[k] for own in laws.values()], f"{speed:g} mm/s"
        if with_largest:
            errors = [pair(score.rms_um, score.max_um, ".1f") for score in scores]
            columns.append(Column("RMS (largest)", errors, unit="um", group=group))
        else:
            columns.append(Column("um", [score.rms_um for score in scores], ".1f", group=group))
        counts = [f", {score.better_on}/{score.circles}" if with_largest else "" for score in scores]
        changes = [percent(score.against) if score.against else "the same" for score in scores]
        texts = [change + count for change, count in zip(changes, counts, strict=True)]
        own = ["" if score.law == BASELINE else text for score, text in zip(scores, texts, strict=True)]
        columns.append(Column("change", own, group=group))
    return Table(columns=columns, name="scores")


def _by_law(improvement: Improvement) -> dict[str, list[LawScore]]:
    """Group scores at each speed by the title of the law."""
    scores = improvement.gain.scores
    return {title: [s for s in scores if s.title == title] for title in dict.fromkeys(s.title for s in scores)}


def _speeds(improvement: Improvement) -> list[float]:
    return list(dict.fromkeys(score.speed_mm_s for score in improvement.gain.scores))


def _rounds(improvement: Improvement) -> Table:
    rounds = improvement.rounds
    added = ["; ".join(_causes(each, with_share=True)) or "nothing" for each in rounds]
    columns = [
        Column("round", [each.number for each in rounds]),
        Column("recorded", [f"{', '.join(each.protocols)}, {each.seconds:.0f} s" for each in rounds], kind="prose"),
        Column("verdict", [f"{each.diagnosis.verdict}: {each.diagnosis.sentence}" for each in rounds], kind="prose"),
        Column("added to the model", added, kind="prose"),
    ]
    return Table(columns=columns, name="rounds")


def _round_lines(each: ImprovementRound) -> list[str]:
    """Write the recordings and findings of one round."""
    what = f"{', '.join(each.protocols)}, {each.seconds:.0f} s"
    first = f"round {each.number} ({what}): {each.diagnosis.verdict}: {each.diagnosis.sentence}"
    return [first, *(f"  {cause}" for cause in _causes(each))]


def _causes(each: ImprovementRound, *, with_share: bool = False) -> list[str]:
    """List the causes that were added to the model, with sizes and the share explained on motions left out."""
    listed = []
    for cause in each.diagnosis.causes:
        place = f"{title_of(cause.effect)}{f' of {cause.joint}' if cause.joint else ''}"
        listed.append(f"{place}: {'; '.join(size_text(size) for size in cause.parameters)}")
        held_out = compute_held_out_share(each.diagnosis.levels, [cause.joint])
        if with_share and held_out is not None:
            listed[-1] += f"; explains {held_out.share:.0%} of the misfit on data left out of its fit"
    return listed
