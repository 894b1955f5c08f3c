"""Blocks of a documentation page: paragraphs and tables, code, output, and parts that a script makes."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from ffgym.core.files import read_text

ROOT = Path(__file__).parents[2]
"""Folder of the project."""
WHOLE = "Written by `python -m scripts.tables`"
"""Sentence of pages that a script makes as a whole."""

Kind = Literal["text", "input", "output", "formula"]
"""What a block is: sentences and tables, code and commands, what a command printed, equations."""

_OUTPUT = ("", "text")
"""Languages of fences with output; all others are what a reader types or feeds in."""
_COMMAND = re.compile(r"\s*(?:\$ |ffgym |make |pip |python |ros2 |docker |git |gcc |cc |ray |tensorboard )")
MARK = re.compile(r"<!-- (claim|cited|tested|example): (.*?) -->", flags=re.DOTALL)
_COMMENT = re.compile(r"<!--.*-->")
_CODE = re.compile(r"```.*?```|`[^`\n]*`", flags=re.DOTALL)
_MADE = re.compile(r"<!-- ([^:\n]+) -->\n(.*?)<!-- end -->", flags=re.DOTALL)


@dataclass(frozen=True)
class Mark:
    """A comment beside a block, which names what makes its numbers."""

    kind: str
    """One of claim, cited, tested and example."""
    text: str
    start: int
    """Place in the page."""


@dataclass(frozen=True)
class Block:
    """Lines of a page that belong together."""

    kind: Kind
    start: int
    """Place of its first letter in the page."""
    text: str
    """Text of the page, with blanks in the place of marks."""
    marks: tuple[Mark, ...] = ()
    made: str | None = None
    """Name of the made part that it is in, empty for a page that is made as a whole."""


def pages() -> list[Path]:
    """List the README and all pages of the documentation."""
    return [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def name_of(page: Path) -> str:
    """Name a page by its place in the project."""
    return page.relative_to(ROOT).as_posix()


def read_blocks(page: Path) -> list[Block]:
    """Read the blocks of a page."""
    return list(split(read_text(page)))


def split(text: str) -> Iterator[Block]:
    """Split the text of a page into blocks; marks that stand alone belong to the block below them."""
    made = [(found.start(2), found.end(2), found[1]) for found in _MADE.finditer(text)]
    # marks that are shown as code are none
    code = [found.span() for found in _CODE.finditer(text)]
    every = [found for found in MARK.finditer(text) if not any(a <= found.start() < b for a, b in code)]
    marks = [Mark(kind=found[1], text=" ".join(found[2].split()), start=found.start()) for found in every]
    plain = text
    for found in every:
        plain = plain[: found.start()] + re.sub(r"[^\n]", " ", found[0]) + plain[found.end() :]
    waiting: list[Mark] = []
    kept, last = tuple[Mark, ...](), -1
    for start, end, kind in _spans(plain):
        # lines of a fence are one block to a reader: a mark above it, which names no numerals, is for all of them
        kept = (
            tuple(mark for mark in kept if mark.kind != "claim" and " for " not in mark.text) if start == last else ()
        )
        while marks and marks[0].start < end:
            waiting.append(marks.pop(0))
        part = next((name for begin, stop, name in made if begin <= start < stop), "" if WHOLE in text else None)
        kept = (*kept, *waiting)
        yield Block(kind=kind, start=start, text=plain[start:end], marks=kept, made=part)
        waiting.clear()
        last = -1 if kind == "text" else end
    if marks or waiting:
        yield Block(kind="text", start=len(text), text="", marks=(*waiting, *marks))


def _spans(text: str) -> Iterator[tuple[int, int, Kind]]:
    """Yield begin, end and kind of all blocks; a fence with output and commands falls into both."""
    place, begin, language = 0, None, None
    for line in text.splitlines(keepends=True):
        fence = re.match(r"\s*```(\w*)", line)
        if fence and language is None:
            if begin is not None:
                yield begin, place, "text"
            begin, language = None, fence[1]
        elif fence:
            language = None
        elif language is not None:
            yield place, place + len(line), _kind_of(line, language)
        elif begin is None and line.startswith("    ") and line.strip():
            yield place, place + len(line), "formula"
        elif line.strip() and not _COMMENT.fullmatch(line.strip()):
            begin = place if begin is None else begin
        elif begin is not None:
            yield begin, place, "text"
            begin = None
        place += len(line)
    if begin is not None:
        yield begin, place, "text"


def _kind_of(line: str, language: str) -> Kind:
    if language == "math":
        return "formula"
    return "output" if language in _OUTPUT and not _COMMAND.match(line) else "input"
