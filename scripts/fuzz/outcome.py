"""What came of one input: a valid result, a clear error, or a finding."""

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from traceback import extract_tb
from typing import Any

from ffgym.core.errors import LONGEST, FFGymError

VALID, ERROR = "valid", "error"
"""Outcomes that are right: a result, or one clear error."""
FINDINGS = ("exception", "warning", "output", "unclear", "memory", "hang", "crash")
"""Outcomes that are not: another exception; a warning; text on the terminal, or a file that was left; an error that is
empty or of more than LONGEST characters; 2 GB exceeded; 20 s exceeded; death of the process."""


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """Outcome of one input."""

    kind: str
    """VALID, ERROR or one of FINDINGS."""
    detail: str = ""
    """Message or reason."""
    place: str = ""
    """Line of the project at which an exception was raised, as file:line."""
    seconds: float = 0.0
    peak_mb: float = 0.0
    """Most memory that the process held [MB], with all that it had imported."""

    @property
    def is_right(self) -> bool:
        """True for a result or a clear error."""
        return self.kind in (VALID, ERROR)


def judge(use: Callable[[Path], Any], path: Path, errors: tuple[type[Exception], ...] = ()) -> Outcome:
    """Call a reader, and say what came of it; `errors` are right beside FFGymError."""
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        found = _call(use, path, errors)
    if found.is_right and warned:
        first = warned[0]
        where = f"{_short(first.filename)}:{first.lineno}"
        return Outcome(kind="warning", detail=f"{first.category.__name__}: {first.message}"[:500], place=where)
    return found


def _call(use: Callable[[Path], Any], path: Path, errors: tuple[type[Exception], ...]) -> Outcome:
    known: tuple[type[Exception], ...] = (FFGymError, *errors)
    try:
        use(path)
    except known as error:
        text = str(error)
        if not text.strip() or len(text) > LONGEST:
            return Outcome(kind="unclear", detail=f"{len(text)} characters: {text[:300]}", place=_place(error))
        return Outcome(kind=ERROR, detail=text[:300])
    except MemoryError as error:
        return Outcome(kind="memory", detail="MemoryError", place=_place(error))
    except Exception as error:
        return Outcome(kind="exception", detail=f"{type(error).__name__}: {error}"[:500], place=_place(error))
    return Outcome(kind=VALID)


def _place(error: BaseException) -> str:
    """Find the innermost line of the project that an exception passed."""
    lines = [frame for frame in extract_tb(error.__traceback__) if "/ffgym/" in frame.filename]
    return f"{_short(lines[-1].filename)}:{lines[-1].lineno}" if lines else ""


def _short(filename: str) -> str:
    """Name a file from the package on."""
    for package in ("/ffgym/", "/site-packages/"):
        if package in filename:
            return (
                package.strip("/").replace("site-packages", "")
                + "/" * (package == "/ffgym/")
                + filename.rpartition(package)[2]
            )
    return filename
