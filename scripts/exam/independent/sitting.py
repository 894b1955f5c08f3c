"""Questions of the second exam, answered and marked."""

import json
import time

from ffgym.core.errors import FFGymError
from ffgym.diagnosis import diagnose
from ffgym.diagnosis.document import diagnosis_document
from ffgym.diagnosis.result import Diagnosis
from scripts.exam.case import Row
from scripts.exam.independent.question import IndependentPaper, handed_out
from scripts.exam.marks import Mark, marked

REPEATED = 25
"""Every so many questions of a row are answered twice, to see whether the bytes are the same."""


def answered(paper: IndependentPaper) -> Diagnosis:
    """The diagnosis of a log, by what is told of its machine."""
    return diagnose(paper.robot, paper.log, calibration=paper.calibration)


def examined(question: tuple[Row, int], *, seed: int) -> Mark:
    """The mark of one question.

    Raises:
        FFGymError: if its log cannot be made; the message begins with the question.
    """
    row, number = question
    try:
        paper = handed_out(row, number, seed=seed)
    except FFGymError as error:
        raise FFGymError(f"Question {row}-{number} of seed {seed}: {error}") from error
    began = time.perf_counter()
    answer = _answered(paper)
    seconds = time.perf_counter() - began
    same = _bytes(answer) == _bytes(_answered(paper)) if number % REPEATED == 0 else None
    return marked(paper, answer, seconds=seconds, same_bytes=same, conditions=paper.setup.label)


def _answered(paper: IndependentPaper) -> Diagnosis:
    """The diagnosis; one that ends in an error is an answer, too, and a wrong one."""
    try:
        return answered(paper)
    except Exception as error:  # whatever it is, a good log has no diagnosis
        return Diagnosis(
            verdict="insufficient",
            sentence=f"{type(error).__name__}: {error}",
            robot=paper.robot.name,
            motions=tuple(recording.header.segment for recording in paper.log),
        )


def _bytes(answer: Diagnosis) -> str:
    return json.dumps(diagnosis_document(answer))
