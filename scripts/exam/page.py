"""Results of an exam of the diagnosis on its page: tables, picture and misses of docs/bench_diagnosis.md.

`python -m scripts.exam.page --seed 2035` reads what `python -m scripts.exam --seed 2035 --out exam` has kept, and with
`--exam independent` the same of the second exam; `make exam` runs all of them.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from ffgym.core.errors import FFGymError
from ffgym.report import save_figure
from scripts.exam.exams import EXAMS, ExamName
from scripts.exam.marks import Mark, read_marks
from scripts.exam.report import figures_text, misses_text, outcomes_figure, outcomes_text
from scripts.exam.tasks import Row
from scripts.tables.page import renew

PAGE = Path(__file__).parents[2] / "docs" / "bench_diagnosis.md"

DPI = 100
"""Pixels per inch of the picture."""


@dataclass(frozen=True)
class Config:
    """Exam whose results are written, and their page."""

    seed: int = 7
    """Seed of the exam."""
    exam: ExamName = "own"
    """Name of the exam, see `python -m scripts.exam`; the part of the page is marked `exam`, or `independent`."""
    out: Path = Path("exam")
    """Folder in which `python -m scripts.exam` has kept its marks."""
    commit: str = "not told"
    """Commit of the diagnosis that was examined."""
    page: Path = PAGE
    """Markdown file whose marked part is replaced; the picture goes to pictures/ beside it."""


def main(config: Config) -> str:
    """Write the results; returns them as Markdown."""
    exam = EXAMS[config.exam]
    part = exam.part
    place = config.out / exam.file_of(config.seed)
    marks = read_marks(place, exam.head(config.seed))
    which = "" if config.exam == "own" else f"--exam {config.exam} "
    if not marks:
        raise FFGymError(
            f"{place}: holds no marks; run python -m scripts.exam {which}--seed {config.seed} --out {config.out}."
        )
    day = datetime.fromtimestamp(place.stat().st_mtime, UTC).date().isoformat()
    save_figure(outcomes_figure(marks), config.page.parent / "pictures" / f"{part}.png", DPI)
    text = "\n\n".join(
        [
            f"`python -m scripts.exam {which}--seed {config.seed} --jobs 2 --out exam`, {day}, diagnosis at commit "
            f"{config.commit}: {_count_asked(marks, exam.counts)}.",
            figures_text(exam.table(marks)),
            f"![Each answer over loudness](pictures/{part}.png)",
            outcomes_text(marks),
            "Answers that were not right, with what was hidden and how loud it was:",
            f"```text\n{misses_text(marks)}\n```",
        ]
    )
    config.page.write_text(renew(config.page.read_text(encoding="utf-8"), {part: text}), encoding="utf-8")
    return text


def _count_asked(marks: Sequence[Mark], whole_exam: Mapping[Row, int]) -> str:
    """Say how much of a whole exam was asked."""
    counts, whole = Counter(mark.row for mark in marks), sum(whole_exam.values())
    if all(counts[row] >= count for row, count in whole_exam.items()):
        more = len(marks) - whole
        return f"all {whole} questions" + (f", and {more} more of some rows" if more else "")
    parts = ", ".join(f"{counts[row]} of {count} `{row}`" for row, count in whole_exam.items())
    return f"{len(marks)} of {whole} questions ({parts})"


if __name__ == "__main__":
    import tyro

    print(main(tyro.cli(Config)))
