"""Results of an exam to be read: figures beside demands, answers by loudness, and what went wrong."""

from collections import Counter
from collections.abc import Sequence
from typing import get_args

from scripts.exam.case import ROWS
from scripts.exam.figures import Line
from scripts.exam.marks import Mark, Outcome
from scripts.exam.table import BANDS

_OUTCOMES: tuple[Outcome, ...] = get_args(Outcome)


def figures_text(lines: Sequence[Line]) -> str:
    """Markdown table of figures and demands."""
    met = {True: "yes", False: "NO", None: "-"}
    body = [[str(line.number), line.figure, line.demand, line.got, str(line.of), met[line.is_met]] for line in lines]
    return _markdown(["row", "figure", "demand", "got", "of", "met"], body)


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
    return _markdown(["question", "loudness", "of", *_OUTCOMES], body)


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


def _markdown(head: Sequence[str], body: Sequence[Sequence[str]]) -> str:
    widths = [max(len(row[k]) for row in [head, *body]) for k in range(len(head))]
    rows = [head, ["-" * width for width in widths], *body]
    return "\n".join("| " + " | ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)) + " |" for row in rows)
