"""Marks of answers: right names, names of effects that are not there, and answers that it cannot be told."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.files import read_text, write_text
from ffgym.core.typed_json import from_json, to_json
from ffgym.diagnosis.result import Cause, Diagnosis, Pattern
from ffgym.effects import EFFECTS
from scripts.exam.equations import Clue
from scripts.exam.tasks import ROWS, Row, Task, Truth

Outcome = Literal[
    "right", "surplus", "part", "tie", "none", "unknown", "insufficient", "wrong", "wrong_partly", "wrong_tie"
]
"""`right`: all that is hidden is named, and nothing else; `surplus`: and something else, too; `part`: some of it, for
sure or in a tie, and nothing else; `tie`: what is hidden is among what the log cannot tell apart; `wrong`: something is
named that is not there, and what is hidden comes later or not at all; `wrong_partly`: the same, said to explain only a
part; `wrong_tie`: only what is not there is in the tie. Of nothing hidden, `none` is right."""

_TOLERANCE = 0.02
"""Relative error of a frequency in time that is right; chosen: lines of a motion of ten seconds are as wide."""

_HARMONICS = 7
"""Multiples of a frequency that count for it: pulses and switches have many, the first need not be the largest."""


_SHAPE = 0.1
"""Relative error of a shape that is chosen beside the size beyond which sizes mean different things."""


@dataclass(frozen=True, kw_only=True)
class SizeMark:
    """A size in an answer, and the true one, in the unit of the parameter."""

    name: str
    said: float
    true: float
    interval: tuple[float, float]
    scale: float
    """Distance of the true size from null; of a vector its length."""

    @property
    def error(self) -> float:
        """Relative."""
        return abs(self.said - self.true) / self.scale

    @property
    def is_covered(self) -> bool:
        """Tell whether the interval holds the true size."""
        return self.interval[0] <= self.true <= self.interval[1]


@dataclass(frozen=True, kw_only=True)
class Said:
    """An effect in an answer."""

    effect: str
    joint: str
    held_out_gain: float


@dataclass(frozen=True, kw_only=True)
class Gain:
    """Difference of simulation and machine, in full closed loop, on two motions that were not diagnosed."""

    leftover: float
    """Energy with the causes, over that of noise and calibration without anything hidden; worst joint or axis."""
    before: float
    """RMS distance of the tool between the machine and its nominal model [m]."""
    after: float
    """The same with the causes."""


@dataclass(frozen=True, kw_only=True)
class Mark:
    """An answer beside the truth, as a line of the results."""

    row: Row
    number: int
    truth: tuple[Truth, ...]
    outcome: Outcome
    verdict: str
    sentence: str
    causes: tuple[Said, ...]
    tied: tuple[Said, ...]
    first_is_right: bool
    """True if the first cause is one that is hidden, in an answer that names at all."""
    sizes: tuple[SizeMark, ...] = ()
    cycles_off: float | None = None
    """Cycles per motor turn said less true, of a periodic effect that is named; None for others."""
    clue_found: bool | None = None
    """True if the strongest pattern is the one that it must be, of an effect outside the library."""
    patterns: tuple[str, ...] = ()
    gain: Gain | None = None
    """Gain of the extended model on motions that were not diagnosed; None if nothing is named."""
    conditions: str = ""
    """Conditions of a log whose machine, controller and columns are drawn, too."""
    seconds: float = 0.0
    same_bytes: bool | None = None
    """True if a second diagnosis of the same log gave the same bytes; None if none was made."""
    proposed: str | None = None
    """Protocol that was proposed to tell rivals apart."""
    then: Outcome | None = None
    """Outcome of the diagnosis of both logs, when the proposed protocol was recorded, too."""

    @property
    def loudness(self) -> float:
        """Loudness of the quieter one of hidden effects; 1 if nothing is hidden."""
        return min((truth.loudness for truth in self.truth), default=1.0)

    @property
    def names_wrongly(self) -> bool:
        """Tell whether the answer is sure of an effect that is not there."""
        return self.verdict == "named" and self.outcome in ("wrong", "surplus")

    @property
    def name(self) -> str:
        """Name of the question."""
        return f"{self.row}-{self.number}"


def mark_of(task: Task, answer: Diagnosis, **more: Any) -> Mark:
    """The mark of an answer; `more` are fields of it that others know."""
    named = [(_family(cause.effect), cause.joint) for cause in answer.causes]
    truths = [(_family(one.answer), one.joint) for one in task.truth]
    tells = answer.verdict in ("named", "partly", "ambiguous")
    sized = task.truth if answer.verdict == "named" else ()
    joints, clue = task.robot.joints, task.clue
    return Mark(
        row=task.row,
        number=task.number,
        truth=task.truth,
        outcome=outcome(answer, task.truth),
        verdict=answer.verdict,
        sentence=answer.sentence,
        causes=tuple(Said(effect=c.effect, joint=c.joint, held_out_gain=c.held_out_gain) for c in answer.causes),
        tied=tuple(
            Said(effect=r.effect, joint=r.joint, held_out_gain=r.held_out_gain) for r in answer.rivals if r.tied
        ),
        first_is_right=tells and bool(named) and named[0] in truths,
        sizes=tuple(size for one in sized for size in _sizes(one, answer)),
        cycles_off=_cycles_off(task.truth[0], answer) if task.truth else None,
        clue_found=None if clue is None else finds(clue, answer.patterns, task.truth[0].joint, joints),
        patterns=tuple(pattern.message for pattern in answer.patterns[:3]),
        conditions=task.conditions,
        proposed=answer.separating_motion.protocol if answer.separating_motion else None,
        **more,
    )


def outcome(answer: Diagnosis, hidden: Sequence[Truth]) -> Outcome:
    """Compare an answer with the hidden effects."""
    if answer.verdict in ("none", "unknown", "insufficient"):
        return answer.verdict
    named = [(_family(cause.effect), cause.joint) for cause in answer.causes]
    truths = {(_family(one.answer), one.joint) for one in hidden if one.answer}
    if answer.verdict == "ambiguous":
        tied = {*named, *((_family(rival.effect), rival.joint) for rival in answer.rivals if rival.tied)}
        if not truths & tied:
            return "wrong_tie"
        return "tie" if truths <= tied else "part"
    false = [one for one in named if one not in truths]
    if not false and named:
        return "right" if truths <= set(named) else "part"
    if named and truths <= set(named) and named[0] in truths:
        return "surplus"
    return "wrong" if answer.verdict == "named" else "wrong_partly"


def _family(effect: str) -> str:
    """The simplest effect that an effect is a form of; itself where there is none."""
    simpler = EFFECTS[effect].generalises if effect in EFFECTS else ()
    return simpler[0] if simpler else effect


def finds(clue: Clue, patterns: Sequence[Pattern], joint: str, joints: Sequence[str]) -> bool:
    """Tell whether the strongest pattern in the residual of one of the `joints` is the one that a clue asks for."""
    own = [pattern for pattern in patterns if pattern.component == joint]
    if not own:
        return False
    pattern = own[0]
    if pattern.kind == "line":
        said, true = pattern.frequency, clue.frequency
        if said is None or true is None:
            return False
        times = max(1, round(said / true))
        return times <= _HARMONICS and abs(said / (times * true) - 1) <= _TOLERANCE
    what, _, last = pattern.variable.rpartition(" of ")
    what, whose = (what, last) if last in joints else (pattern.variable, joint)
    return (None if what == "time" else whose) == clue.joint and any(word in what for word in clue.words)


def _causes(hidden: Truth, answer: Diagnosis) -> list[Cause]:
    """Causes that name what is hidden: one, or one for each wave."""
    return [c for c in answer.causes if (c.effect, c.joint) == (hidden.answer, hidden.joint)]


def _sizes(hidden: Truth, answer: Diagnosis) -> list[SizeMark]:
    """Sizes of an effect of the library that is named; none where another shape was chosen, or the equation differs."""
    cause = next(iter(_causes(hidden, answer)), None)
    if cause is None or hidden.is_foreign or not _same_shape(hidden, cause):
        return []
    numbers, found = hidden.numbers, []
    for said in cause.parameters:
        known = EFFECTS[hidden.answer].parameters().get(said.name.partition(".")[0])
        if known is None or known.null is None or said.name not in numbers:
            continue
        true = numbers[said.name]
        parts = [f"{known.name}.{axis}" for axis in "xyz"] if known.per == "vector" else [said.name]
        scale = float(np.linalg.norm([numbers[part] - known.null for part in parts]))
        if scale > 0:
            found.append(SizeMark(name=said.name, said=said.value, true=true, interval=said.interval, scale=scale))
    return found


def _same_shape(hidden: Truth, cause: Cause) -> bool:
    known, numbers = EFFECTS[hidden.answer].parameters(), hidden.numbers
    for name, value in cause.fixed.items():
        parameter = known.get(name.partition(".")[0])
        told = name in numbers  # an equation of its own may have no such number
        if parameter is None or not told or parameter.null is not None or parameter.role in ("phase", "cycles"):
            continue
        if not np.allclose(value, numbers[name], rtol=_SHAPE, atol=0):
            return False
    return True


def _cycles_off(hidden: Truth, answer: Diagnosis) -> float | None:
    """Cycles per motor turn in an answer less the true ones, of the wave of the cause that is nearest to the main one.

    None where nothing is periodic, or it is not named.
    """
    known = EFFECTS[hidden.answer].parameters() if hidden.answer else {}
    name = next((p.name for p in known.values() if p.role == "cycles" and p.unit == "1"), None)
    if name is None or name not in (true := hidden.numbers):
        return None
    said = [{p.name: p.value for p in cause.parameters} | cause.fixed for cause in _causes(hidden, answer)]
    off = [float(numbers[name] - true[name]) for numbers in said if name in numbers]
    return min(off, key=abs, default=None)


def write_marks(path: Path, head: Mapping[str, Any], marks: Sequence[Mark]) -> None:
    """Write all marks, one line for each question, whole or not at all, in the order of the exam.

    The first line is `head`, which says what all marks depend on beside the question.
    """
    ordered = sorted(marks, key=lambda mark: (ROWS.index(mark.row), mark.number))
    write_text(path, "".join(json.dumps(line) + "\n" for line in (head, *(to_json(mark) for mark in ordered))))


def read_marks(path: Path, head: Mapping[str, Any]) -> list[Mark]:
    """Marks of an exam that was begun; none if there is no file.

    Raises:
        FFGymError: if the file is damaged, or has another head: that of another exam or of other versions.
    """
    if not path.exists():
        return []
    try:
        first, *lines = [json.loads(line) for line in read_text(path).splitlines()]
        found = [from_json(Mark, line, "mark") for line in lines]
    except (ValueError, RecursionError) as error:
        raise FFGymError(f"{path}: is damaged: {error}. Remove it to begin again.") from error
    if first != head:
        raise FFGymError(
            f"{path}: holds marks of another seed or exam, or of other versions ({first}). Choose another folder, or "
            "remove it."
        )
    return found
