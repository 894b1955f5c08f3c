"""An exam is held: questions are handed out, answers marked, and each mark is kept as soon as it is there."""

import json
import multiprocessing
import signal
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from functools import cache, partial
from pathlib import Path

from ffgym.core.errors import FFGymError
from ffgym.diagnosis import Memory, diagnose
from ffgym.diagnosis.document import diagnosis_document
from ffgym.diagnosis.result import Diagnosis
from ffgym.recordings import Recording
from ffgym.robot import RigidArm, load_robot
from ffgym.simulation.protocols import load_protocols
from ffgym.simulation.run import Progress
from scripts.exam.case import Row
from scripts.exam.draw import ROBOT, draw_case
from scripts.exam.exams import ExamName
from scripts.exam.gain import gain_of
from scripts.exam.independent import sitting as independent
from scripts.exam.loudness import Paper, handed_out
from scripts.exam.marks import Mark, Outcome, marked, outcome
from scripts.exam.recording import recorded

Question = tuple[Row, int]
"""Row and number."""

REPEATED = 25
"""Every so many questions of a row are answered twice, to see whether the bytes are the same."""

LOUD = 10.0
"""Loudness from which on the gain of an answer is demanded, and computed."""

GAINED = 3
"""The gain of the answer is computed for every so many questions of a row: that takes as long as the answer."""

_LATER = 60.0
"""Time after a poor log at which what it proposes is recorded [s]; chosen: what it takes to read the proposal."""


@cache
def arm_of_exam() -> RigidArm:
    """The nominal robot."""
    return RigidArm(load_robot(ROBOT))


def answered(log: Sequence[Recording]) -> Diagnosis:
    """The diagnosis of a log."""
    return diagnose(arm_of_exam().robot, log, memory=_memory())


@cache
def _memory() -> Memory:
    """What questions of one process share: most are of the same motions."""
    return Memory()


def examined(question: Question, *, seed: int) -> Mark:
    """The mark of one question.

    Raises:
        FFGymError: if its log cannot be recorded or diagnosed; the message begins with the question.
    """
    row, number = question
    try:
        paper = handed_out(draw_case(row, number, seed=seed, arm=arm_of_exam()))
        began = time.perf_counter()
        answer = answered(paper.log)
        seconds = time.perf_counter() - began
        same = _bytes(answer) == _bytes(answered(paper.log)) if number % REPEATED == 0 else None
        then = _resolved(paper, answer) if paper.case.is_poor else None
        is_loud = number % GAINED == 0 and min(paper.loudness, default=0.0) >= LOUD
        gain = (
            gain_of(paper.case, answer.causes, answer.numbers)
            if is_loud and answer.verdict in ("named", "partly")
            else None
        )
    except FFGymError as error:
        raise FFGymError(f"Question {row}-{number} of seed {seed}: {error}") from error
    return marked(paper, answer, seconds=seconds, same_bytes=same, then=then, gain=gain)


def _bytes(answer: Diagnosis) -> str:
    return json.dumps(diagnosis_document(answer))


def _resolved(paper: Paper, answer: Diagnosis) -> Outcome | None:
    """What the diagnosis comes to with the motions that it proposes; None if it proposes none."""
    if answer.separating_motion is None:
        return None
    case = paper.case
    ends = [recording.header.meta["session_start"] + recording.t[-1] for recording in paper.log]
    seed, start = int(case.generator(1).integers(2**32)), float(max(ends)) + _LATER
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "proposed.toml"
        place.write_text(answer.separating_motion.toml, encoding="utf-8")
        protocols = load_protocols(place)
        more = recorded(
            case.arm,
            case.complete,
            protocols,
            seed=seed,
            current_offset=case.current_offset,
            start=start,
            lacks=case.lacks,
        )
    later = [recording.renamed(f"proposed/{recording.header.segment}") for recording in more]
    return outcome(answered([*paper.log, *later]), case.hidden)


def hold(
    questions: Sequence[Question],
    *,
    seed: int,
    jobs: int = 1,
    progress: Progress | None = None,
    exam: ExamName = "own",
) -> Iterator[Mark]:
    """Marks of questions as they come; their order depends on how long each takes.

    Args:
        questions: which.
        seed: of the exam.
        jobs: processes.
        progress: called after each, with how many are done and how many there are.
        exam: which.

    Raises:
        FFGymError: if one cannot be recorded or diagnosed.
    """
    examine: Callable[[Question], Mark] = partial(_examiner(exam), seed=seed)
    if jobs == 1:
        yield from _counted(map(examine, questions), len(questions), progress)
        return
    context = multiprocessing.get_context("spawn")  # what the engine's threads hold is not copied
    with context.Pool(jobs, initializer=_deaf) as pool:
        yield from _counted(pool.imap_unordered(examine, questions), len(questions), progress)


def _examiner(exam: ExamName) -> Callable[..., Mark]:
    return independent.examined if exam == "independent" else examined


def _deaf() -> None:
    """Leave an interruption to the process that hands out the questions, which ends the others."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _counted(marks: Iterator[Mark], total: int, progress: Progress | None) -> Iterator[Mark]:
    for done, mark in enumerate(marks, start=1):
        yield mark
        if progress is not None:
            progress(done, total)
