"""`python -m scripts.exam.settings_study`: a short exam with settings of the diagnosis at half and twice their values.

A setting that changes no answer at either value decides nothing and should go; one that changes many deserves its
reason. Questions are those of the independent exam on small arms, and one of friction that is known and identified
again; they take a few seconds each.
"""

import json
import multiprocessing
import signal
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path

from ffgym.cli.main import run_command
from ffgym.cli.progress import progress_bar
from ffgym.core.errors import check_choice, check_whole
from ffgym.core.files import write_text
from ffgym.diagnosis.settings import record_reads, setting_values, use_settings
from scripts.exam.study_questions import Answer, DiagnosisQuestion, IdentificationQuestion, StudyQuestion
from scripts.tables.page import Contents, markdown

FACTORS = (0.5, 2.0)
"""Factors by which each setting is changed."""

QUESTIONS: tuple[StudyQuestion, ...] = (
    DiagnosisQuestion(row="clean", number=2, axes=1),
    DiagnosisQuestion(row="single", number=10, axes=1),
    DiagnosisQuestion(row="single", number=16, axes=1),
    DiagnosisQuestion(row="single", number=20, axes=1),
    DiagnosisQuestion(row="single", number=24, axes=1),
    DiagnosisQuestion(row="outside", number=1, axes=1),
    DiagnosisQuestion(row="single", number=2, axes=2),
    DiagnosisQuestion(row="single", number=3, axes=2),
    DiagnosisQuestion(row="single", number=5, axes=2),
    IdentificationQuestion(robot="one_axis", number=3),
)
"""Questions that are asked; chosen: fast ones, most of them of quiet effects, and friction that lies well within its
intervals with the usual seed."""

_PROBABILITIES = ("screening.level", "sampling.motion_power", "blocks.top_speed", "friction.near_bound")
"""Settings near 1, of which the distance to 1 is halved and doubled."""

_VISIBLE = 0.01
"""Relative change of a size from which on it is told."""


@dataclass(frozen=True, kw_only=True)
class Varied:
    """The short exam with one setting changed."""

    setting: str
    factor: float
    value: float
    changed: tuple[str, ...]
    """Subjects of which something else is said, as 'single-3: right -> none': verdict, causes or rivals that tie,
    status or interval of a parameter."""
    largest_change: float
    """Largest relative change of a size of a cause that is named, or of a parameter that is identified, both times."""
    right: int
    """Questions with the best possible answer."""
    wrong: int
    """Questions in which something is named that is not there, or an interval misses."""
    seconds: float
    """Time of all answers [s]."""
    error: str = ""
    """Message of an answer that failed; the questions after it were not asked."""
    n_read: int
    """Questions that read the setting; the others keep their answers."""

    @property
    def has_effect(self) -> bool:
        """True if an answer is another one, or a size is, by a per cent or more."""
        return bool(self.changed or self.error) or self.largest_change >= _VISIBLE


@dataclass(frozen=True)
class StudySettings:
    """Ask a short exam with each setting of the diagnosis at half and at twice its value."""

    settings: tuple[str, ...] = ()
    """Settings to vary, e.g. search.near_best; none given is all."""
    seed: int = 28
    """Seed of the questions."""
    out: Path = Path("out/settings")
    """Folder of the results, one line for each variation; those in it are not computed again."""
    jobs: int = 1
    """Variations that are computed at the same time."""
    page: Path | None = None
    """Markdown file whose marked part is replaced by the results, e.g. docs/diagnosis_settings.md."""

    def run(self) -> None:
        """Compute the variations that are not there yet, one line of a file for each."""
        check_whole("--seed", self.seed, low=0)
        check_whole("--jobs", self.jobs, low=1, high=1024)
        known = setting_values()
        for name in self.settings:
            check_choice("setting", name, list(known))
        place = self.out / f"seed_{self.seed}.jsonl"
        done = read_variations(place)
        asked = [(name, factor) for name in self.settings or known for factor in FACTORS]
        missing = [one for one in asked if one not in {(varied.setting, varied.factor) for varied in done}]
        self.out.mkdir(parents=True, exist_ok=True)
        with progress_bar("varying settings", "exams") as progress:
            for varied in _variations(missing, self.seed, self.jobs):
                done.append(varied)
                write_text(place, "".join(json.dumps(asdict(one)) + "\n" for one in done))
                progress(len(done), len(asked))
        text = describe_study(done, self.seed)
        print(text)
        if self.page is not None:
            Contents(parts={"settings": text}).write(self.page)


def read_variations(place: Path) -> list[Varied]:
    """Read the results of an earlier run; an empty list if there is no file."""
    if not place.exists():
        return []
    rows = [json.loads(line) for line in place.read_text(encoding="utf-8").splitlines()]
    return [Varied(**{**row, "changed": tuple(row["changed"])}) for row in rows]


def describe_study(variations: Sequence[Varied], seed: int) -> str:
    """Describe the results in Markdown: how many settings matter, and a table for each group."""
    found = {(one.setting, one.factor): one for one in variations}
    pairs = {name: [found.get((name, factor)) for factor in FACTORS] for name in setting_values()}
    asked = [[one for one in pair if one is not None] for pair in pairs.values() if any(pair)]
    read = [pair for pair in asked if any(one.n_read for one in pair)]
    moving = [pair for pair in read if any(one.has_effect for one in pair)]
    turning = [pair for pair in read if any(one.changed or one.error for one in pair)]
    parts = [
        f"Of {len(pairs)} settings {len(asked)} were varied (seed {seed}); the {len(QUESTIONS)} questions read "
        f"{len(read)} of them. At half or twice its value {len(moving)} move a size by 1 % or change an answer; "
        f"{len(turning)} change an answer."
    ]
    groups: dict[str, list[tuple[str, ...]]] = {}
    for name, value in setting_values().items():
        group, own = name.split(".")
        n_read = max((one.n_read for one in pairs[name] if one is not None), default=0)
        row = (f"`{own}`", f"{value:g}", str(n_read), *map(_cell, pairs[name]))
        groups.setdefault(group, []).append(row)
    head = ("setting", "value", "read by", "at half", "at twice")
    parts += [f"### {group}\n\n{markdown(head, rows)}" for group, rows in groups.items()]
    return "\n\n".join(parts)


def _cell(varied: Varied | None) -> str:
    if varied is None:
        return "not asked"
    if varied.error:
        return "no answer"
    if not varied.n_read:
        return ""
    answers = "the same" if not varied.changed else "; ".join(varied.changed)
    size = f", sizes up to {varied.largest_change:.0%}" if varied.largest_change >= _VISIBLE else ""
    return answers + size


def vary(setting: str, factor: float, seed: int) -> Varied:
    """Ask the short exam with one setting changed, and compare the answers with those of the defaults."""
    before = setting_values()[setting]
    value = _change(setting, before, factor)
    changed, largest, answers, n_read = list[str](), 0.0, list[Answer](), 0
    began, error = time.perf_counter(), ""
    for question in QUESTIONS:
        usual, read = _usual(question, seed)
        answer = usual
        if setting in read:
            n_read += 1
            with use_settings({setting: value}):
                answer = question.ask(seed)
        if answer.error and not usual.error:
            error = answer.error
            break
        answers.append(answer)
        changed += _list_changes(usual, answer)
        largest = max(largest, _size_change(usual, answer))
    return Varied(
        setting=setting,
        factor=factor,
        value=value,
        changed=tuple(changed),
        largest_change=largest,
        right=sum(answer.is_right for answer in answers),
        wrong=sum(answer.is_wrong for answer in answers),
        seconds=time.perf_counter() - began,
        error=error,
        n_read=n_read,
    )


def _change(setting: str, before: float, factor: float) -> float:
    """Value of a setting times a factor; whole numbers stay whole, and at least 1."""
    if isinstance(before, int):
        return max(1, round(before * factor))
    if setting in _PROBABILITIES:
        return 1 - (1 - before) * factor
    return before * factor


def _list_changes(usual: Answer, other: Answer) -> list[str]:
    """List the subjects of which another answer says something else."""
    both = [(subject, said, other.statements[subject]) for subject, said in usual.statements.items()]
    return [f"{subject}: {before.mark} -> {after.mark}" for subject, before, after in both if before != after]


def _size_change(one: Answer, other: Answer) -> float:
    """Compute the largest relative change of a size that both answers have."""
    common = [(one.sizes[name], other.sizes[name]) for name in one.sizes.keys() & other.sizes.keys()]
    return max((abs(a - b) / max(abs(a), abs(b)) for a, b in common if a != b), default=0.0)


@cache
def _usual(question: StudyQuestion, seed: int) -> tuple[Answer, frozenset[str]]:
    """Ask a question with the defaults, once in each process; return the answer and the settings that it reads."""
    with record_reads() as read:
        answer = question.ask(seed)
    return answer, frozenset(read)


def _variations(asked: Sequence[tuple[str, float]], seed: int, jobs: int) -> Iterator[Varied]:
    """Compute variations in processes of their own, in order."""
    rows = [(name, factor, seed) for name, factor in asked]
    if jobs == 1:
        yield from (vary(*row) for row in rows)
        return
    context = multiprocessing.get_context("spawn")
    with context.Pool(jobs, initializer=signal.signal, initargs=(signal.SIGINT, signal.SIG_IGN)) as pool:
        yield from pool.imap(_vary_row, rows)


def _vary_row(row: tuple[str, float, int]) -> Varied:
    return vary(*row)


def main(arguments: Sequence[str] | None = None) -> int:
    """Vary settings as the arguments say; those of the process if none are given."""
    return run_command(StudySettings, "python -m scripts.exam.settings_study", arguments)


if __name__ == "__main__":
    sys.exit(main())
