"""The picture of an exam: each answer is there, and in the colour of what it came to."""

import pytest

from ffgym.core.errors import FFGymError
from scripts.exam.marks import Mark
from scripts.exam.report import GOOD, PART, SILENT, TIE, WRONG, outcomes_figure, sum_up
from scripts.exam.tasks import Truth


def mark(row="single", outcome="right", verdict="named", loudness=20.0, number=0):
    hidden = Truth(effect="cogging", answer="cogging", joint="j1", is_foreign=False, loudness=loudness, numbers={})
    return Mark(
        row=row,
        number=number,
        truth=() if row in ("clean", "poor_clean") else (hidden,),
        outcome=outcome,
        verdict=verdict,
        sentence="",
        causes=(),
        tied=(),
        first_is_right=outcome == "right",
    )


@pytest.mark.parametrize(
    ("row", "outcome", "verdict", "word"),
    [
        ("single", "right", "named", GOOD),
        ("single", "tie", "ambiguous", TIE),
        ("single", "wrong_tie", "ambiguous", WRONG),
        ("single", "wrong", "named", WRONG),
        ("single", "none", "none", SILENT),
        ("single", "unknown", "unknown", SILENT),
        ("pair", "part", "named", PART),
        ("pair", "surplus", "partly", PART),
        ("clean", "none", "none", GOOD),
        ("clean", "wrong", "named", WRONG),
        ("clean", "insufficient", "insufficient", SILENT),
        ("outside", "unknown", "unknown", GOOD),
        ("outside", "wrong_partly", "partly", GOOD),
        ("outside", "wrong", "named", WRONG),
        ("outside", "none", "none", SILENT),
    ],
)
def test_what_an_answer_is_summed_up_to(row, outcome, verdict, word):
    assert sum_up(mark(row, outcome, verdict)) == word


def test_each_answer_has_a_marker_at_its_loudness_and_none_hides_another():
    marks = [mark(number=k) for k in range(5)] + [mark("clean", "none", "none"), mark("pair", "part", loudness=1e6)]
    (axes,) = outcomes_figure(marks).axes
    markers = [line for line in axes.lines if line.get_label() in (GOOD, PART)]
    places = [(float(line.get_xdata()[0]), float(line.get_ydata()[0])) for line in markers]
    assert len(set(places)) == len(marks)
    assert sorted(x for x, _ in places) == pytest.approx([1, 20, 20, 20, 20, 20, 1e4])
    assert [label.get_text() for label in axes.get_yticklabels()] == ["pair (1)", "single (5)", "clean (1)"]


def test_an_exam_without_answers_is_refused():
    with pytest.raises(FFGymError, match="no marks"):
        outcomes_figure([])
