"""What each numeral of a page is traced by: a script, a test, a claim, a published work, or nothing."""

import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from ffgym.core.files import read_text
from scripts.claims import told  # noqa: F401  (its modules register claims)
from scripts.claims.claim import CLAIMS, Found, find_passage
from scripts.claims.numerals import Numeral, find_names, find_numerals
from scripts.claims.page import MARK, ROOT, Block, Mark, name_of, read_blocks, split

HOW: Mapping[str, str] = MappingProxyType(
    {
        "made": "in a part that a script makes from the code, a stored result or a simulation",
        "claim": "in a passage that is written again from a stored result or the code",
        "tested": "in a block that a test compares with what makes it",
        "printed": "in output that a test compares with what a command prints",
        "cited": "published by somebody else, with its source",
        "example": "chosen in the text as an example or a convention",
        "input": "in code, commands and files that a reader types, or in a formula",
        "name": "no claim: part of a name, a date, a version, an equation, a place in a work",
        "untraced": "traced by nothing",
    }
)
"""Ways to trace a numeral, with their meaning."""

_TUTORIALS = "tests/test_tutorial_with_commands.py"
PRINTED: Mapping[str, str] = MappingProxyType(
    {
        **dict.fromkeys(
            [
                f"docs/tutorials/{name}.md"
                for name in ("your_robot", "identify", "diagnose", "real_machine", "onto_the_machine")
            ],
            _TUTORIALS,
        ),
        "docs/deployment/trial.md": "tests/deployment/trial/test_trial_page.py",
    }
)
"""Tests that compare the output on a page with what its commands print, to 5 %."""

SOURCES: Mapping[str, str] = MappingProxyType(tomllib.loads(read_text(Path(__file__).with_name("sources.toml"))))
"""Published works by the name in marks."""


@dataclass(frozen=True)
class Traced:
    """A numeral of a page, and what it is traced by."""

    line: int
    text: str
    how: str
    """One of `HOW`."""
    by: str = ""
    """Part, claim, test, work or rule."""


@dataclass(frozen=True)
class Fault:
    """A number that does not hold, or a mark that leads nowhere."""

    page: str
    line: int
    message: str

    def __str__(self) -> str:
        return f"{self.page}:{self.line}: {self.message}"


@dataclass(frozen=True)
class Trace:
    """All numerals of a page, and what is wrong with them."""

    page: str
    numerals: tuple[Traced, ...]
    faults: tuple[Fault, ...]

    @property
    def untraced(self) -> tuple[Traced, ...]:
        """Numerals that nothing traces."""
        return tuple(each for each in self.numerals if each.how == "untraced")


def trace_page(page: Path) -> Trace:
    """Trace all numerals of a page."""
    text, blocks, name = read_text(page), read_blocks(page), name_of(page)
    found, faults = _find_claims(name, text, blocks)
    faults += [
        Fault(name, line, "a mark splits the lines around it; put it at the end of one") for line in _splitting(text)
    ]
    numerals = [
        Traced(line=_line(text, block.start + numeral.start), text=numeral.text, how=how, by=by)
        for block in blocks
        for numeral, how, by in _trace_block(block, name, found)
    ]
    faults += [fault for block in blocks for fault in _check_marks(name, text, block)]
    return Trace(page=name, numerals=tuple(numerals), faults=tuple(sorted(faults, key=lambda fault: fault.line)))


def _splitting(text: str) -> Iterator[int]:
    """Yield lines with nothing but a mark, below one with text: Markdown would end a paragraph or list there."""
    lines, is_code = ["", *text.splitlines()], False
    for k, line in enumerate(lines[1:], start=1):
        is_code ^= line.lstrip().startswith("```")
        alone = [each.strip().startswith("<!-- ") and each.strip().endswith("-->") for each in (lines[k - 1], line)]
        if not is_code and alone[1] and MARK.match(line.strip()) and lines[k - 1].strip() and not alone[0]:
            yield k


def _trace_block(block: Block, page: str, found: Sequence[tuple[str, Found]]) -> Iterator[tuple[Numeral, str, str]]:
    """Yield the numerals of a block, each with how and by what it is traced."""
    names = find_names(block.text)
    kept = {mark.kind: _words(mark) for mark in block.marks if mark.kind != "claim"}
    for numeral in find_numerals(block.text):
        place = block.start + numeral.start
        claims = [name for name, each in found if each.start <= place < each.end]
        rules = [rule for start, end, rule in names if start <= numeral.start < end]
        by_marks = [(kind, by) for kind, (by, only) in kept.items() if not only or numeral.text in only]
        if block.made is not None:
            yield numeral, "made", block.made
        elif block.kind in ("input", "formula"):
            yield numeral, "input", block.kind
        elif claims:
            yield numeral, "claim", claims[0]
        elif rules and block.kind == "text":
            yield numeral, "name", rules[0]
        elif by_marks:
            yield numeral, *by_marks[0]
        elif block.kind == "output" and page in PRINTED:
            yield numeral, "printed", PRINTED[page]
        else:
            yield numeral, "untraced", ""


def _words(mark: Mark) -> tuple[str, frozenset[str]]:
    """Split a mark into what it names and the numerals that it is for, all of the block if it lists none."""
    by, _, only = mark.text.partition(" for ")
    return by, frozenset(numeral.text for numeral in find_numerals(only))


def _find_claims(page: str, text: str, blocks: Sequence[Block]) -> tuple[list[tuple[str, Found]], list[Fault]]:
    """Find the passages of all claims that a page names, and say which do not hold."""
    marked: dict[str, list[Block]] = {}
    for block in blocks:
        for mark in (mark for mark in block.marks if mark.kind == "claim"):
            for name in mark.text.split(", "):
                marked.setdefault(name, []).append(block)
    found, faults = list[tuple[str, Found]](), list[Fault]()
    for name, own in marked.items():
        if name not in CLAIMS:
            faults.append(Fault(page, _line(text, own[0].start), f"unknown claim {name!r}"))
            continue
        texts = [(block.start, block.text) for block in own]
        places = [each for passage in CLAIMS[name].passages for each in find_passage(passage, texts)]
        found += [(name, each) for each in places]
        faults += [
            Fault(page, _line(text, place), f"says {says}, is {value} ({name}: {CLAIMS[name].command})")
            for each in places
            for place, says, value in each.differences
        ]
        faults += [
            Fault(page, _line(text, each.start), f"claim {name!r} tells of no passage of this block")
            for each in own
            if not any(each.start <= place.start < each.start + len(each.text) for place in places)
        ]
    return found, faults


def check_pages(pages: Sequence[Path]) -> tuple[list[Trace], list[Fault]]:
    """Trace all numbers of pages, and list what does not hold on any of them."""
    traces = [trace_page(page) for page in pages]
    return traces, [fault for trace in traces for fault in trace.faults] + _find_lost(pages)


def _find_lost(pages: Sequence[Path]) -> list[Fault]:
    """List passages of claims that stand on no page, and claims that no page names."""
    texts: dict[str, list[tuple[int, str]]] = {}
    where: dict[str, tuple[str, int]] = {}
    for page in pages:
        text = read_text(page)
        for block in split(text):
            for name in (each for mark in block.marks if mark.kind == "claim" for each in mark.text.split(", ")):
                texts.setdefault(name, []).append((block.start, block.text))
                where.setdefault(name, (name_of(page), _line(text, block.start)))
    faults = [Fault("scripts/claims", 0, f"no page names the claim {name!r}") for name in CLAIMS if name not in texts]
    return faults + [
        Fault(*where[name], f"{name!r} tells, in other words than the page: {passage}")
        for name, each in texts.items()
        for passage in (CLAIMS[name].passages if name in CLAIMS else ())
        if not find_passage(passage, each)
    ]


def _check_marks(page: str, text: str, block: Block) -> Iterator[Fault]:
    """Yield marks whose test, work or numerals do not exist."""
    for mark in block.marks:
        by, only = _words(mark)
        if mark.kind == "tested" and not test_exists(by):
            yield Fault(page, _line(text, mark.start), f"there is no test {by!r}")
        if mark.kind == "cited" and by not in SOURCES:
            yield Fault(page, _line(text, mark.start), f"unknown work {by!r}; scripts/claims/sources.toml lists them")
        if mark.kind != "claim" and (missing := only - {numeral.text for numeral in find_numerals(block.text)}):
            yield Fault(page, _line(text, mark.start), f"the block lacks {', '.join(sorted(missing))}")


def test_exists(name: str) -> bool:
    """Check that a test exists, as 'tests/test_file.py::test_name'."""
    file, _, function = name.partition("::")
    place, line = ROOT / file, rf"^\s*def {re.escape(function)}\("
    return place.is_file() and re.search(line, read_text(place), re.MULTILINE) is not None


def _line(text: str, place: int) -> int:
    return text.count("\n", 0, place) + 1
