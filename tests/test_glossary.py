"""The glossary: each term has one sentence, and a name that exists in the code."""

import dataclasses
import importlib
import re
from pathlib import Path

import pytest

PAGE = Path(__file__).parent.parent / "docs" / "glossary.md"
ROWS = [
    [cell.strip() for cell in line.strip("|").split("|")]
    for line in PAGE.read_text(encoding="utf-8").splitlines()
    if line.startswith("| ") and not line.startswith("| term ")
]
NAMES = [name for row in ROWS for name in re.findall(r"`([^`]+)`", row[2])]


def find(name):
    """Import the longest module that a dotted name begins with; look the rest up as attributes or fields."""
    parts = name.split(".")
    for length in range(len(parts), 0, -1):
        module = ".".join(parts[:length])
        try:
            found = importlib.import_module(module)
        except ModuleNotFoundError as error:
            if error.name is None or not module.startswith(error.name):
                raise
            continue
        for attribute in parts[length:]:
            fields = {field.name for field in dataclasses.fields(found)} if dataclasses.is_dataclass(found) else set()
            found = None if attribute in fields else getattr(found, attribute)
        return True
    raise AttributeError(name)


@pytest.mark.parametrize("name", NAMES)
def test_every_name_in_the_glossary_exists(name):
    assert find(name)


@pytest.mark.parametrize(
    "name",
    ["ffgym.diagnosis.result.Vanished", "ffgym.nowhere", "ffgym.diagnosis.result.Size.weight", "nothing.at.all"],
)
def test_a_name_that_vanishes_is_noticed(name):
    with pytest.raises(AttributeError):
        find(name)


def test_every_term_stands_once_with_a_sentence_and_a_name():
    assert len(ROWS) >= 60
    assert len({row[0] for row in ROWS}) == len(ROWS)
    for term, meaning, name in ROWS:
        assert term
        assert meaning[0].isupper()
        assert meaning.endswith(".")
        assert re.fullmatch(r"`ffgym[\w.]+`", name), term
