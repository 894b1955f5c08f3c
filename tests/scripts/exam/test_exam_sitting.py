"""An exam is held: every question is recorded, diagnosed and marked, alone or beside others."""

from dataclasses import replace

import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.result import Cause, Diagnosis, SeparatingMotion, Size
from scripts.exam.exams import Exam, OwnExam, examine, hold

COULOMB = Cause(
    effect="coulomb_level",
    code="F1",
    title="",
    joint="j2",
    parameters=(Size(name="change", value=0.1, unit="1", interval=(0.0, 0.2)),),
    fixed={},
    held_out_gain=0.9,
)


def said(verdict, **more):
    return Diagnosis(verdict=verdict, sentence="", robot="", motions=(), **more)


def test_what_a_poor_log_proposes_is_recorded_on_the_same_machine_and_diagnosed_with_it(monkeypatch):
    logs = []

    def answer(exam, task):
        logs.append([recording.header.segment for recording in task.log])
        if len(task.log) > 3:
            return said("none")
        proposed = SeparatingMotion(
            between=("a", "b"), protocol="proposed", toml='[[step]]\nprotocol = "dwell_restart"\n', expected=1.0
        )
        return said("ambiguous", causes=(COULOMB,), separating_motion=proposed)

    monkeypatch.setattr(Exam, "answer", answer)
    mark = examine(("poor_clean", 1), exam=OwnExam(), seed=1020)
    assert (mark.outcome, mark.proposed, mark.then) == ("wrong_tie", "proposed", "none")
    first, both = logs
    assert both[: len(first)] == first
    assert [name.split(".")[0] for name in both[len(first) :]] == ["proposed/dwell_restart"]


def test_every_so_often_a_question_is_answered_twice(monkeypatch):
    answers = iter([said("none"), said("none", threshold=0.1), said("none")])
    monkeypatch.setattr(Exam, "answer", lambda exam, task: next(answers))
    assert examine(("poor_clean", 0), exam=OwnExam(), seed=1020).same_bytes is False
    assert examine(("poor_clean", 1), exam=OwnExam(), seed=1020).same_bytes is None


def test_a_question_that_cannot_be_answered_says_which_it_is(monkeypatch):
    def refuse(exam, task):
        raise FFGymError("no such log")

    monkeypatch.setattr(Exam, "answer", refuse)
    with pytest.raises(FFGymError, match="poor_clean-1 of seed 1020: no such log"):
        examine(("poor_clean", 1), exam=OwnExam(), seed=1020)


@pytest.mark.slow
def test_marks_are_the_same_at_any_number_of_processes():
    questions = [("poor_clean", 1), ("poor_clean", 2)]
    alone, beside = (
        [replace(mark, seconds=0.0) for mark in hold(questions, exam=OwnExam(), seed=1020, jobs=jobs)]
        for jobs in (1, 2)
    )
    assert sorted(alone, key=lambda mark: mark.number) == sorted(beside, key=lambda mark: mark.number)
