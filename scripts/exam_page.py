"""Results of an exam of the diagnosis on its page: tables, picture and misses of docs/bench_diagnosis.md.

`python -m scripts.exam_page --seed 2035` reads what `ffgym bench-diagnosis --seed 2035 --out exam` has kept;
`make exam` runs both.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from ffgym.errors import FFGymError
from ffgym.exam.draw import COUNTS
from ffgym.exam.marks import Mark
from ffgym.exam.results import read_marks
from ffgym.exam.table import table
from ffgym.exam.text import figures_text, misses_text, outcomes_text
from ffgym.report import save_figure
from ffgym.report.exam import outcomes_figure
from scripts.convergence_table import renewed

PAGE = Path(__file__).parents[1] / "docs" / "bench_diagnosis.md"
DPI = 100
"""Pixels per inch of the picture."""


@dataclass(frozen=True)
class Config:
    """Which exam, and where it goes."""

    seed: int = 7
    """Of the exam."""
    out: Path = Path("exam")
    """Folder in which `ffgym bench-diagnosis` has kept its marks."""
    commit: str = "not told"
    """Commit of the diagnosis that was examined."""
    page: Path = PAGE
    """Markdown file whose marked part is replaced; the picture goes to pictures/exam.png beside it."""


def main(config: Config) -> str:
    """Write the results; returns them as Markdown."""
    place = config.out / f"seed_{config.seed}.jsonl"
    marks = read_marks(place, config.seed)
    if not marks:
        raise FFGymError(f"{place}: holds no marks; run ffgym bench-diagnosis --seed {config.seed} --out {config.out}.")
    day = datetime.fromtimestamp(place.stat().st_mtime, UTC).date().isoformat()
    save_figure(outcomes_figure(marks), config.page.parent / "pictures" / "exam.png", DPI)
    text = "\n\n".join(
        [
            f"`ffgym bench-diagnosis --seed {config.seed} --jobs 2 --out exam`, {day}, diagnosis at commit "
            f"{config.commit}: {_asked(marks)}.",
            figures_text(table(marks)),
            "![Each answer over loudness](pictures/exam.png)",
            outcomes_text(marks),
            "Answers that were not right, with what was hidden and how loud it was:",
            f"```text\n{misses_text(marks)}\n```",
        ]
    )
    config.page.write_text(renewed(config.page.read_text(encoding="utf-8"), {"exam": text}), encoding="utf-8")
    return text


def _asked(marks: Sequence[Mark]) -> str:
    """How much of a whole exam was asked."""
    counts, whole = Counter(mark.row for mark in marks), sum(COUNTS.values())
    if all(counts[row] >= count for row, count in COUNTS.items()):
        more = len(marks) - whole
        return f"all {whole} questions" + (f", and {more} more of some rows" if more else "")
    parts = ", ".join(f"{counts[row]} of {count} `{row}`" for row, count in COUNTS.items())
    return f"{len(marks)} of {whole} questions ({parts})"


if __name__ == "__main__":
    import tyro

    print(main(tyro.cli(Config)))
