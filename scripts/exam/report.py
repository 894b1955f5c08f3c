"""Results of an exam to be read: figures beside demands, answers by loudness, what went wrong, and a picture."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, get_args

from ffgym.core.errors import FFGymError
from ffgym.report.figure import house_style, legend_above, new_figure
from scripts.exam.marks import Mark, Outcome
from scripts.exam.tables import BANDS, Line
from scripts.exam.tasks import ROWS
from scripts.tables.page import markdown

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_OUTCOMES: tuple[Outcome, ...] = get_args(Outcome)

GOOD, TIE, PART, SILENT, WRONG = (
    "right",
    "tie with the truth in it",
    "part, or more than all",
    "not found, or refused",
    "wrong",
)
"""Classes of answers."""

_LOOKS = {
    GOOD: ("o", "#2a8f5b"),
    TIE: ("s", "#3b78c2"),
    PART: ("D", "#d99000"),
    SILENT: ("o", "#b5bcc5"),
    WRONG: ("X", "#c62f2f"),
}
"""Marker and colour of each."""

_LOUDEST = 1e4
"""Louder effects are drawn here."""

_LANES, _NEAR = 7, 0.045
"""Lanes of a row that markers take so that they do not hide one another, and decades of loudness within which they
would."""


def figures_text(lines: Sequence[Line]) -> str:
    """Markdown table of figures and demands."""
    met = {True: "yes", False: "NO", None: "-"}
    body = [[str(line.number), line.figure, line.demand, line.got, str(line.of), met[line.is_met]] for line in lines]
    return markdown(["row", "figure", "demand", "got", "of", "met"], body, aligned=True)


def outcomes_text(marks: Sequence[Mark]) -> str:
    """Markdown table of what answers came to, by kind of question and loudness."""
    body = []
    for row in ROWS:
        for name, low, high in BANDS:
            here = [mark for mark in marks if mark.row == row and low <= mark.loudness < high]
            if here:
                count = Counter(mark.outcome for mark in here)
                band = name if here[0].truth else "nothing hidden"
                body.append([row, band, str(len(here)), *(str(count[one] or "") for one in _OUTCOMES)])
    return markdown(["question", "loudness", "of", *_OUTCOMES], body, aligned=True)


def misses_text(marks: Sequence[Mark]) -> str:
    """Answers that were not right, one line each."""
    lines = []
    for mark in marks:
        good = "none" if not mark.truth else "right"
        if mark.outcome != good and not (mark.row == "outside" and mark.clue_found):
            hidden = ", ".join(f"{t.effect} on {t.joint or 'machine'} ({t.loudness:.3g})" for t in mark.truth)
            said = ", ".join(f"{c.effect} on {c.joint or 'machine'}" for c in mark.causes)
            about = f" [{mark.conditions}]" if mark.conditions else ""
            lines.append(f"{mark.name}: {hidden or 'nothing'}; {mark.verdict}: {said or '-'}{about}")
    return "\n".join(lines)


def sum_up(mark: Mark) -> str:
    """Sum an answer up in one of a few words.

    Of nothing hidden, `none` is right; outside the library, an answer that is sure of no name.
    """
    if mark.row == "outside":
        return WRONG if mark.verdict in ("named", "ambiguous") else SILENT if mark.outcome == "none" else GOOD
    if not mark.truth:
        return {"none": GOOD, "insufficient": SILENT}.get(mark.outcome, WRONG)
    return {"right": GOOD, "tie": TIE, "part": PART, "surplus": PART}.get(
        mark.outcome, SILENT if mark.outcome in ("none", "unknown", "insufficient") else WRONG
    )


def outcomes_figure(marks: Sequence[Mark]) -> "Figure":
    """A marker for each answer, row by row of the exam, over loudness; lines where the demands change.

    Raises:
        FFGymError: if there are no marks.
    """
    by_row = {row: [mark for mark in marks if mark.row == row] for row in reversed(ROWS)}
    rows = {f"{row} ({len(answers)})": answers for row, answers in by_row.items() if answers}
    about = "loudness of what is hidden (1: nothing, or not distinguishable from noise)"
    figure = answers_figure(rows, lambda mark: min(mark.loudness, _LOUDEST), about, (0.62, 1.3))
    (axes,) = figure.axes
    for _, low, _ in BANDS[1:]:
        axes.axvline(low, color="#888888", linewidth=0.8, linestyle="--")
    axes.set_xlim(0.9, 1.25 * _LOUDEST)
    return figure


def answers_figure(
    rows: Mapping[str, Sequence[Mark]], x: Callable[[Mark], float], label: str, heights: tuple[float, float]
) -> "Figure":
    """A marker for each answer over `x`, row by row from below; `heights` are those of a row and of all else [in].

    Raises:
        FFGymError: if there are no marks.
    """
    rows = {name: answers for name, answers in rows.items() if answers}
    if not rows:
        raise FFGymError("There is nothing to draw: the exam has no marks.")
    with house_style():
        figure = new_figure(9.0, heights[0] * len(rows) + heights[1])
        axes = figure.subplots()
        for place, answers in enumerate(rows.values()):
            _draw_row(axes, place, answers, x)
        axes.set_xscale("log")
        axes.set_xlabel(label)
        axes.set_yticks(range(len(rows)), list(rows))
        axes.grid(visible=False, axis="y")
        known = dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
        names = [name for name in _LOOKS if name in known]
        legend_above(figure, [known[name] for name in names], names)
    return figure


def _draw_row(axes: "Axes", place: int, marks: Sequence[Mark], x: Callable[[Mark], float]) -> None:
    """One row of answers at a height `place` over `x`, which is positive; the largest last, wrong ones on top."""
    ends = [0.0] * _LANES
    for mark in sorted(marks, key=x):
        along = x(mark)
        lane = min(range(_LANES), key=lambda k: (ends[k] > along, abs(k - _LANES // 2), ends[k]))
        if ends[lane] > along:
            lane = ends.index(min(ends))
        ends[lane] = along * 10**_NEAR
        name = sum_up(mark)
        marker, colour = _LOOKS[name]
        height = place + 0.8 * (lane / (_LANES - 1) - 0.5)
        order = 3 + list(_LOOKS).index(name)
        axes.plot(along, height, marker, color=colour, markersize=4.5, linestyle="", label=name, zorder=order)
