"""Hold both exams of the project: draw tasks, diagnose their logs and mark the answers."""

import json
import multiprocessing
import signal
import tempfile
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import asdict, replace
from functools import cache, partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.provenance import versions
from ffgym.diagnosis import DiagnosisCache, diagnose
from ffgym.diagnosis.diagnosis_file import diagnosis_document
from ffgym.diagnosis.result import Diagnosis
from ffgym.robot import RigidArm, load_robot
from ffgym.simulation import SimulatedRig
from ffgym.simulation.protocols import load_protocols
from ffgym.simulation.run import Progress
from scripts.exam import draw
from scripts.exam.draw import ROBOT, draw_case
from scripts.exam.gain import gain_of
from scripts.exam.independent import question
from scripts.exam.loudness import OwnTask, record_task
from scripts.exam.marks import Mark, Outcome, mark_of, outcome
from scripts.exam.report import figures_text, misses_text, outcomes_figure, outcomes_text
from scripts.exam.tables import Line, independent_table, table
from scripts.exam.tasks import ROWS, Question, Row, Task

if TYPE_CHECKING:
    from matplotlib.figure import Figure

REPEATED = 25
"""Every so many questions of a row are answered twice, to see whether the bytes are the same."""

LOUD = 10.0
"""Loudness from which on the gain of an answer is demanded, and computed."""

GAINED = 3
"""The gain of the answer is computed for every so many questions of a row: that takes as long as the answer."""

_LATER = 60.0
"""Time after a poor log at which what it proposes is recorded [s]; chosen: what it takes to read the proposal."""


class Exam(ABC):
    """Questions, how they are answered, and what is demanded of the answers."""

    robot: str
    """Name of its robot."""
    part: ClassVar[str]
    """Mark of its results on the page, and name of their picture."""
    prefix: str = ""
    """Name of the file of marks begins with it."""

    @property
    @abstractmethod
    def counts(self) -> Mapping[Row, int]:
        """Questions of a whole exam, by row."""

    def questions(self, rows: Sequence[str], cases: int | None) -> list[Question]:
        """Questions that are asked: of some rows, none is all; so many of each, None is a whole exam.

        Raises:
            FFGymError: if the exam has no such row.
        """
        counts = self.counts
        for row in rows:
            check_choice("row of the exam", row, [one for one in ROWS if one in counts])
        asked = [row for row in counts if row in rows or not rows]
        return [(row, k) for row in asked for k in range(cases or counts[row])]

    @abstractmethod
    def table(self, marks: Sequence[Mark]) -> list[Line]:
        """Figures beside demands."""

    @abstractmethod
    def draw_task(self, row: Row, number: int, seed: int) -> Task:
        """Draw the task of a question."""

    def file_of(self, seed: int) -> str:
        """Name of the file of marks."""
        return f"{self.prefix}seed_{seed}.jsonl"

    def texts(self, marks: Sequence[Mark]) -> list[str]:
        """Results to be read, paragraph by paragraph."""
        return [figures_text(self.table(marks)), outcomes_text(marks), misses_text(marks)]

    def picture(self, marks: Sequence[Mark]) -> "Figure":
        """Answers as a picture."""
        return outcomes_figure(marks)

    def document(self, marks: Sequence[Mark]) -> dict[str, Any]:
        """Results for programs."""
        return {"figures": [asdict(line) for line in self.table(marks)]}

    @property
    def fingerprint(self) -> str | None:
        """Fingerprint of the simulation that made the logs; None where none of the project's did."""
        return SimulatedRig(arm=RigidArm(load_robot(self.robot))).fingerprint

    def head(self, seed: int) -> dict[str, Any]:
        """First line of the file of marks: what all of them depend on beside the question."""
        return {"format": "ffgym-exam", "seed": seed, "versions": versions()}

    def answer(self, task: Task) -> Diagnosis:
        """The diagnosis of a log, by what is told of its machine."""
        return diagnose(task.robot, task.log, prior=task.prior, cache=_memory())

    def extras(self, task: Task, answer: Diagnosis) -> dict[str, Any]:
        """Further fields of the mark."""
        return {}


class OwnExam(Exam):
    """Logs of one robot by the project's own simulation."""

    robot, part, counts = ROBOT, "exam", draw.COUNTS

    def table(self, marks: Sequence[Mark]) -> list[Line]:
        """Compute the figures of the exam on the built-in robot."""
        return table(marks)

    def draw_task(self, row: Row, number: int, seed: int) -> OwnTask:
        """Draw a question about the built-in robot."""
        return record_task(draw_case(row, number, seed=seed, arm=_arm(self.robot)))

    def extras(self, task: Task, answer: Diagnosis) -> dict[str, Any]:
        """Record the motions that a poor log's answer proposes, and compute the gain of a loud effect's model."""
        assert isinstance(task, OwnTask)
        then = self._resolve(task, answer) if task.case.is_poor else None
        loudness = min((one.loudness for one in task.truth), default=0.0)
        gain = None
        if task.number % GAINED == 0 and loudness >= LOUD and answer.verdict in ("named", "partly"):
            gain = gain_of(task.case, answer.causes, answer.numbers)
        return {"then": then, "gain": gain}

    def _resolve(self, task: OwnTask, answer: Diagnosis) -> Outcome | None:
        """Diagnose again with the motions that an answer proposes; None if it proposes none."""
        if answer.separating_motion is None:
            return None
        case = task.case
        with tempfile.TemporaryDirectory() as folder:
            place = Path(folder) / "proposed.toml"
            place.write_text(answer.separating_motion.toml, encoding="utf-8")
            bench = replace(case.bench, protocols=tuple(load_protocols(place)))
        ends = [recording.header.meta["session_start"] + recording.t[-1] for recording in task.log]
        seed = int(case.generator(1).integers(2**32))
        start = float(max(ends)) + _LATER
        more = bench.record(case.complete, seed=seed, current_offset=case.current_offset, start=start)
        later = [recording.rename(f"proposed/{recording.header.segment}") for recording in more]
        both = Task(row=task.row, number=task.number, robot=task.robot, log=(*task.log, *later))
        return outcome(self.answer(both), task.truth)


class IndependentExam(Exam):
    """Logs of drawn machines by a plant that shares nothing with the simulation."""

    robot, part, prefix, counts, fingerprint = "drawn", "independent", "independent_", question.COUNTS, None

    def table(self, marks: Sequence[Mark]) -> list[Line]:
        """Compute the figures of the exam on drawn machines."""
        return independent_table(marks)

    def head(self, seed: int) -> dict[str, Any]:
        """Describe the exam in the first line of its marks; no robot of the project is in it."""
        return {"format": "ffgym-exam", "exam": "independent", "seed": seed, "versions": versions()}

    def draw_task(self, row: Row, number: int, seed: int) -> Task:
        """Draw a question about a drawn machine."""
        return question.draw_task(row, number, seed=seed)

    def answer(self, task: Task) -> Diagnosis:
        """The diagnosis; one that ends in an error is an answer, too, and a wrong one."""
        try:
            return diagnose(task.robot, task.log, prior=task.prior)
        except Exception as error:  # whatever it is, a good log has no diagnosis
            return Diagnosis(
                verdict="insufficient",
                sentence=f"{type(error).__name__}: {error}",
                robot=task.robot.name,
                motions=tuple(recording.header.segment for recording in task.log),
            )


ExamName = Literal["own", "independent"]

EXAMS: Mapping[ExamName, Exam] = MappingProxyType({"own": OwnExam(), "independent": IndependentExam()})
"""Exams of the project by name."""


@cache
def _arm(robot: str) -> RigidArm:
    """The nominal robot."""
    return RigidArm(load_robot(robot))


@cache
def _memory() -> DiagnosisCache:
    """Memory that questions of one process share: most are of the same motions."""
    return DiagnosisCache()


def examine(question: Question, *, exam: Exam, seed: int) -> Mark:
    """The mark of one question.

    Raises:
        FFGymError: if its log cannot be recorded or diagnosed; the message begins with the question.
    """
    row, number = question
    try:
        task = exam.draw_task(row, number, seed)
        began = time.perf_counter()
        answer = exam.answer(task)
        seconds = time.perf_counter() - began
        same = None
        if number % REPEATED == 0:
            one, other = (json.dumps(diagnosis_document(each)) for each in (answer, exam.answer(task)))
            same = one == other
        extras = exam.extras(task, answer)
    except FFGymError as error:
        raise FFGymError(f"Question {row}-{number} of seed {seed}: {error}") from error
    return mark_of(task, answer, seconds=seconds, same_bytes=same, **extras)


def hold(
    questions: Sequence[Question], *, exam: Exam, seed: int, jobs: int = 1, progress: Progress | None = None
) -> Iterator[Mark]:
    """Marks of questions as they come from so many processes; their order depends on how long each takes.

    Raises:
        FFGymError: if one cannot be recorded or diagnosed.
    """
    ask: Callable[[Question], Mark] = partial(examine, exam=exam, seed=seed)
    with ExitStack() as stack:
        marks: Iterator[Mark] = map(ask, questions)
        if jobs > 1:
            context = multiprocessing.get_context("spawn")  # what the engine's threads hold is not copied
            # an interruption is left to this process, which ends the others
            pool = context.Pool(jobs, initializer=signal.signal, initargs=(signal.SIGINT, signal.SIG_IGN))
            marks = stack.enter_context(pool).imap_unordered(ask, questions)
        for done, mark in enumerate(marks, start=1):
            yield mark
            if progress is not None:
                progress(done, len(questions))
