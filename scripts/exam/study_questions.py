"""Questions that the study of settings asks: causes in a log, and friction that is identified again."""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import NamedTuple, Protocol

from ffgym.diagnosis.result import Diagnosis
from ffgym.report.identification.friction import LETTERS
from ffgym.robot import load_robot
from scripts.exam.exams import IndependentExam
from scripts.exam.independent import question
from scripts.exam.marks import Mark, mark_of
from scripts.exam.tasks import Row, Task
from scripts.tables.friction import Repetition, identify_joints, true_friction


class Statement(NamedTuple):
    """Statement of an answer, without its sizes."""

    mark: str
    """Mark that it gets, e.g. 'right'."""
    details: tuple[object, ...] = ()
    """Details that may change while the mark stays."""


@dataclass(frozen=True, kw_only=True)
class Answer:
    """Answer to a question, to be compared with the answer under other settings."""

    statements: Mapping[str, Statement] = field(default_factory=dict)
    """Statements by subject, e.g. 'single-3'."""
    sizes: Mapping[tuple[str, ...], float] = field(default_factory=dict)
    """Sizes of what is named or identified, by name."""
    is_right: bool = False
    """True if no answer could be better."""
    is_wrong: bool = False
    """True if something is named that is not there, or an interval misses."""
    error: str = ""
    """Reason why there is no answer."""


class StudyQuestion(Hashable, Protocol):
    """Question that can be asked again under other settings."""

    def ask(self, seed: int) -> Answer:
        """Ask the question as the seed draws it."""


@dataclass(frozen=True, kw_only=True)
class DiagnosisQuestion:
    """Question of the independent exam on a small arm."""

    row: Row
    number: int
    axes: int
    """Joints of the machine."""

    def ask(self, seed: int) -> Answer:
        """Diagnose the log of the question."""
        task = _draw_task(self.row, self.number, self.axes, seed)
        answer = IndependentExam().answer(task)
        mark = mark_of(task, answer)
        return Answer(
            statements={f"{self.row}-{self.number}": Statement(mark.outcome, _list_named(answer))},
            sizes={(one.effect, one.joint, size.name): size.value for one in answer.causes for size in one.parameters},
            is_right=_is_best(mark),
            is_wrong=mark.outcome.startswith("wrong") or mark.outcome == "surplus",
            error=answer.sentence if answer.verdict == "insufficient" else "",
        )


@cache
def _draw_task(row: Row, number: int, axes: int, seed: int) -> Task:
    return question.draw_task(row, number, seed=seed, n=axes)


def _list_named(answer: Diagnosis) -> tuple[object, ...]:
    """List what an answer names without its sizes."""
    causes = sorted((cause.effect, cause.joint) for cause in answer.causes)
    return answer.verdict, causes, sorted((rival.effect, rival.joint) for rival in answer.rivals if rival.tied)


def _is_best(mark: Mark) -> bool:
    """Tell whether no answer could be better."""
    return mark.outcome == {"clean": "none", "outside": "unknown"}.get(mark.row, "right")


@dataclass(frozen=True, kw_only=True)
class IdentificationQuestion:
    """Known friction of a robot with one joint, identified from its records with noise; coarse, to take seconds."""

    robot: str
    """Built-in robot."""
    number: int
    """Number of the noise, from the seed on."""
    resamples: int = 200
    """Resamples behind each interval."""
    physics_dt: float = 2.5e-4
    """Physics step of the records with reversals [s]."""
    record_dt: float = 5e-4
    """Sample time of the records [s]."""

    def ask(self, seed: int) -> Answer:
        """Measure and identify the joint, and compare the intervals with the truth."""
        robot = load_robot(self.robot)
        noise = seed + self.number
        repetition = Repetition(
            self.robot, robot.joints, noise, self.resamples, self.physics_dt, record_dt=self.record_dt
        )
        try:
            [joint] = identify_joints(repetition)
        except Exception as error:  # whatever it is, good records have an answer
            return Answer(error=f"{type(error).__name__}: {error}")
        marks, sizes = dict[str, str](), dict[tuple[str, ...], float]()
        for estimate, true in zip(joint.estimates, true_friction(robot, robot.joints)[0], strict=True):
            subject = f"identify {self.robot} {LETTERS[estimate.name]}"
            marks[subject] = estimate.status
            if estimate.is_identified:
                marks[subject] = "covered" if estimate.low <= true <= estimate.high else "missed"
                sizes[(subject,)] = estimate.value
        return Answer(
            statements={subject: Statement(mark) for subject, mark in marks.items()},
            sizes=sizes,
            is_right=set(marks.values()) == {"covered"},
            is_wrong="missed" in marks.values(),
        )
