"""What an answer is worth: whether it names what is hidden, names what is not there, or says that it cannot tell."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, final

from ffgym.diagnosis.result import Diagnosis, Pattern
from ffgym.effects import EFFECTS
from scripts.exam.case import Row
from scripts.exam.equations import Clue
from scripts.exam.gain import Gain
from scripts.exam.secret import Asked, Secret
from scripts.exam.sizes import SizeMark, marked_cycles, marked_sizes

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


@final
@dataclass(frozen=True, kw_only=True)
class Said:
    """An effect in an answer."""

    effect: str
    joint: str
    held_out_gain: float


@final
@dataclass(frozen=True, kw_only=True)
class Truth:
    """What was hidden."""

    effect: str
    """As the exam calls it."""
    answer: str
    """As a diagnosis should; empty outside the library."""
    joint: str
    is_foreign: bool
    loudness: float
    numbers: dict[str, float]


@final
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
    """Whether the first cause is one that is hidden, in an answer that names at all."""
    sizes: tuple[SizeMark, ...] = ()
    cycles_off: float | None = None
    """Cycles per motor turn said less true, of a periodic effect that is named; None for others."""
    clue_found: bool | None = None
    """Whether the strongest pattern is the one that it must be, of an effect outside the library."""
    patterns: tuple[str, ...] = ()
    gain: Gain | None = None
    """What the extended model gains on motions that were not diagnosed; None if nothing is named."""
    conditions: str = ""
    """Of a log whose machine, controller and columns are drawn, too."""
    seconds: float = 0.0
    same_bytes: bool | None = None
    """Whether a second diagnosis of the same log gave the same bytes; None if none was made."""
    proposed: str | None = None
    """Protocol that was proposed to tell rivals apart."""
    then: Outcome | None = None
    """What the diagnosis of both logs came to, when the proposed protocol was recorded, too."""

    @property
    def loudness(self) -> float:
        """Of the quieter one of hidden effects; 1 if nothing is hidden."""
        return min((truth.loudness for truth in self.truth), default=1.0)

    @property
    def names_wrongly(self) -> bool:
        """Whether the answer is sure of something that is not there."""
        return self.verdict == "named" and self.outcome in ("wrong", "surplus")

    @property
    def name(self) -> str:
        """Of the question."""
        return f"{self.row}-{self.number}"


def marked(paper: Asked, answer: Diagnosis, **more: Any) -> Mark:
    """The mark of an answer; `more` are fields of it that others know."""
    robot, hidden = paper.robot, paper.hidden
    named = [(_family(cause.effect), cause.joint) for cause in answer.causes]
    truths = [(_family(one.answer), one.joint) for one in hidden]
    tells = answer.verdict in ("named", "partly", "ambiguous")
    clue = hidden[0].clue(robot) if hidden else None
    sizes = [size for one in hidden for size in marked_sizes(one, answer, robot)] if answer.verdict == "named" else []
    return Mark(
        row=paper.row,
        number=paper.number,
        truth=tuple(
            Truth(
                effect=one.name,
                answer=one.answer,
                joint=one.joint,
                is_foreign=one.is_foreign,
                loudness=loudness,
                numbers=one.numbers(robot),
            )
            for one, loudness in _with_loudness(paper)
        ),
        outcome=outcome(answer, hidden),
        verdict=answer.verdict,
        sentence=answer.sentence,
        causes=tuple(Said(effect=c.effect, joint=c.joint, held_out_gain=c.held_out_gain) for c in answer.causes),
        tied=tuple(
            Said(effect=r.effect, joint=r.joint, held_out_gain=r.held_out_gain) for r in answer.rivals if r.tied
        ),
        first_is_right=tells and bool(named) and named[0] in truths,
        sizes=tuple(sizes),
        cycles_off=marked_cycles(hidden[0], answer, robot) if hidden else None,
        clue_found=None if clue is None else finds(clue, answer.patterns, hidden[0].joint, robot.joints),
        patterns=tuple(pattern.message for pattern in answer.patterns[:3]),
        proposed=answer.separating_motion.protocol if answer.separating_motion else None,
        **more,
    )


def _with_loudness(paper: Asked) -> list[tuple[Secret, float]]:
    return list(zip(paper.hidden, paper.loudness, strict=True))


def outcome(answer: Diagnosis, hidden: Sequence[Secret]) -> Outcome:
    """What an answer comes to."""
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
    """Whether the strongest pattern in the residual of one of the `joints` is what a clue asks for."""
    own = [pattern for pattern in patterns if pattern.component == joint]
    if not own:
        return False
    pattern = own[0]
    if pattern.kind == "line":
        return _multiple(pattern.frequency, clue.frequency)
    what, _, last = pattern.variable.rpartition(" of ")
    what, whose = (what, last) if last in joints else (pattern.variable, joint)
    return (None if what == "time" else whose) == clue.joint and any(word in what for word in clue.words)


def _multiple(said: float | None, true: float | None) -> bool:
    if said is None or true is None:
        return False
    times = max(1, round(said / true))
    return times <= _HARMONICS and abs(said / (times * true) - 1) <= _TOLERANCE
