"""Marks as a file, one line for each question, which an interrupted exam goes on with."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ffgym.core.errors import FFGymError
from ffgym.core.files import read_text, write_text
from ffgym.core.provenance import versions
from ffgym.core.typed_json import from_json, to_json
from scripts.exam.case import ROWS
from scripts.exam.exams import ExamName
from scripts.exam.marks import Mark

FORMAT = "ffgym-exam"
"""What the first line says."""


def head(seed: int, exam: ExamName = "own") -> dict[str, Any]:
    """First line: what all marks depend on beside the question."""
    which = {} if exam == "own" else {"exam": exam}
    return {"format": FORMAT, **which, "seed": seed, "versions": versions()}


def write_marks(path: Path, seed: int, marks: Sequence[Mark], exam: ExamName = "own") -> None:
    """Write all marks, whole or not at all, in the order of the exam."""
    ordered = sorted(marks, key=lambda mark: (ROWS.index(mark.row), mark.number))
    lines = [head(seed, exam), *(to_json(mark) for mark in ordered)]
    write_text(path, "".join(json.dumps(line) + "\n" for line in lines))


def read_marks(path: Path, seed: int, exam: ExamName = "own") -> list[Mark]:
    """Marks of an exam that was begun; none if there is no file.

    Raises:
        FFGymError: if the file is damaged, or of another exam or other versions.
    """
    if not path.exists():
        return []
    try:
        first, *lines = [json.loads(line) for line in read_text(path).splitlines()]
        found = [from_json(Mark, line, "mark") for line in lines]
    except (ValueError, RecursionError) as error:
        raise FFGymError(f"{path}: is damaged: {error}. Remove it to begin again.") from error
    if first != head(seed, exam):
        raise FFGymError(
            f"{path}: holds marks of another seed or exam, or of other versions ({first}). Choose another folder, or "
            "remove it."
        )
    return found
