"""The sheet of what is validated: its tests exist, and its numbers are theirs or those of stored results."""

import re
from pathlib import Path
from string import Formatter

import pytest

from scripts.claims.numerals import find_names, find_numerals
from scripts.claims.records import RECORDS
from scripts.claims.trace import test_exists as exists
from scripts.tables import validation
from scripts.tables.validation import KINDS, Validated, numbers, rows

ROOT = Path(__file__).parents[2]


def source_of(test):
    """Source of a test with its decorators, and of the module that it stands in."""
    file, _, name = test.partition("::")
    module = (ROOT / file).read_text(encoding="utf-8")
    begin = module.index(f"def {name}(")
    decorators = module[module.rfind("\n\n\n", 0, begin) : begin]
    body = module[begin:].split("\n\n\n")[0]
    return decorators + body, module


def value_of(words, test):
    """Number that words of a test stand for: a literal in it, or a constant of its module or of one that it imports."""
    body, module = source_of(test)
    if words not in body and words not in module:
        return None
    if not words.isidentifier():
        return float(re.findall(r"\d+(?:\.\d+)?(?:e-?\d+)?", words)[0])
    imported = re.findall(rf"^from (\S+) import .*\b{words}\b", module, flags=re.MULTILINE)
    files = [ROOT / f"{each.replace('.', '/')}.py" for each in imported]
    places = [module, *(file.read_text(encoding="utf-8") for file in files)]
    values = [value for text in places for value in re.findall(rf"^{words} = (\S+)", text, flags=re.MULTILINE)]
    return float(values[0]) if values else None


def says_the_same(printed, value):
    """Check that a printed number, perhaps in per cent or thousandths, or as what is left of 1, is a value."""
    number = float(printed.split()[0])
    return any(number == pytest.approx(each) for each in (value, 100 * value, 1000 * value, 100 * (1 - value)))


def missing(row):
    """What a row names that is not there."""
    found = [test for test in (row.by if isinstance(row.by, list) else []) if not exists(test)]
    for printed, words in row.bounds.items():
        values = [value_of(words, test) for test in row.by if exists(test)]
        if not any(value is not None and says_the_same(printed, value) for value in values):
            found.append(f"{printed} as {words}")
    return found


@pytest.mark.parametrize("row", rows(), ids=lambda row: row.what[:40])
def test_tests_and_bounds_of_a_row_exist(row):
    assert missing(row) == []
    assert row.kind in KINDS


@pytest.mark.parametrize("row", rows(), ids=lambda row: row.what[:40])
def test_every_number_of_an_error_is_a_bound_of_a_test_or_of_a_stored_result(row):
    plain = "".join(before for before, *_ in Formatter().parse(row.error))
    names = find_names(row.error)
    told = {
        numeral.text
        for numeral in find_numerals(row.error)
        if numeral.text in plain and not any(start <= numeral.start < end for start, end, _ in names)
    }
    placeholders = {text for _, name, *_ in Formatter().parse(row.error) if name for text in re.findall(r"\d+", name)}
    assert told - placeholders <= {numeral.text for printed in row.bounds for numeral in find_numerals(printed)}
    assert {name for text in (row.error, row.data) for _, name, *_ in Formatter().parse(text) if name} <= set(numbers())


def test_commands_of_rows_are_those_of_the_project():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for command in (row.by for row in rows() if isinstance(row.by, str)):
        if command.startswith("make "):
            assert f"\n{command.removeprefix('make ')}: " in makefile
        else:
            module, *options = command.removeprefix("python -m ").split()
            assert (ROOT / f"{module.replace('.', '/')}.py").exists() or (ROOT / module.replace(".", "/")).is_dir()
            assert not options or options[1] in RECORDS


def test_a_row_that_names_no_test_or_another_bound_is_noticed():
    row = Validated(
        group="", what="", kind="ours", data="", error="within 3 %", by=["tests/test_package.py::test_none"]
    )
    assert missing(row) == ["tests/test_package.py::test_none"]
    (good, *_) = [each for each in rows() if each.bounds and not next(iter(each.bounds.values())).isidentifier()]
    printed, words = next(iter(good.bounds.items()))
    wrong = Validated(group="", what="", kind="ours", data="", error="", by=good.by, bounds={"7 %": words})
    assert missing(wrong) == [f"7 % as {words}"]
    assert says_the_same(printed, value_of(words, good.by[0]))


def test_what_is_not_validated_comes_first_and_is_not_empty():
    parts = validation.validation().parts
    page = (ROOT / "docs" / "validation.md").read_text(encoding="utf-8")
    assert page.index("<!-- not validated -->") < page.index("<!-- validated -->")
    assert parts["not validated"].count("\n") > 5
