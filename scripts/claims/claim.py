"""Claims: passages of the documentation that are written again from a result, each with the command that makes it.

A claim is a function that yields passages as they should stand on a page, numbers at the precision that the page
prints. The page names it beside the passage, `<!-- claim: name -->`. Numerals of the passages are traced by it.
"""

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

from ffgym.core.errors import FFGymError
from scripts.claims.numerals import NUMERAL

Tell = Callable[[], Iterable[str]]
"""Function that yields passages of a page."""


@dataclass(frozen=True)
class Claim:
    """Passages with numbers, and what makes them."""

    name: str
    tell: Tell
    command: str
    """Command that makes the numbers again."""

    @cached_property
    def passages(self) -> tuple[str, ...]:
        """Passages as they should stand on a page, each word apart by one blank."""
        return tuple(" ".join(passage.split()) for passage in self.tell())


CLAIMS: dict[str, Claim] = {}
"""All claims by name."""


def claim(command: str) -> Callable[[Tell], Tell]:
    """Register a function as a claim under its name; `command` makes its numbers again.

    Raises:
        FFGymError: if there is a claim of that name.
    """

    def register(tell: Tell) -> Tell:
        name = tell.__name__
        if name in CLAIMS:
            raise FFGymError(f"Two claims have the name {name!r}; choose another one.")
        CLAIMS[name] = Claim(name=name, tell=tell, command=command)
        return tell

    return register


@dataclass(frozen=True)
class Found:
    """Place of a passage in a text."""

    start: int
    end: int
    differences: tuple[tuple[int, str, str], ...]
    """Place, what the text says, and what it should say, of each numeral that differs."""


def find_passage(passage: str, texts: Sequence[tuple[int, str]]) -> list[Found]:
    """Find a passage in texts that begin at some places of a page; words must be the same, numerals may differ.

    Places where all numerals are the same come alone if there are any.
    """
    numbers = NUMERAL.findall(passage)
    words = [re.sub(r"\s+", r"\\s+", re.escape(part).replace(r"\ ", " ")) for part in NUMERAL.split(passage)]
    pattern = re.compile(r"(?<![\d.,])" + f"({NUMERAL.pattern})".join(words))
    found = []
    for begin, text in texts:
        for match in pattern.finditer(text):
            differences = tuple(
                (begin + match.start(k), match[k], number)
                for k, number in enumerate(numbers, start=1)
                if match[k] != number
            )
            found.append(Found(start=begin + match.start(), end=begin + match.end(), differences=differences))
    return [each for each in found if not each.differences] or found
