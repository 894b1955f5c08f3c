"""Verdicts follow from comparisons, by the share of them that is true."""

from inspect import getmembers, isfunction, signature

import pytest

from scripts.thesis import measures
from scripts.thesis.catalogue import TABLE
from scripts.thesis.claims import EVERY, MOST, RULES, Check, Claim, compare, judge, verdict_of


def checks(*truths: bool) -> list[Check]:
    return [Check(where=f"case {i}", value=0.0 if true else 2.0, limit=1.0) for i, true in enumerate(truths)]


@pytest.mark.parametrize(
    ("truths", "share", "verdict"),
    [
        ([True, True], EVERY, "holds"),
        ([True, True, True, False], EVERY, "partly"),
        ([True, True, True, False], MOST, "holds"),
        ([True, False], MOST, "partly"),
        ([True, False, False], MOST, "does not hold"),
        ([False], EVERY, "does not hold"),
        ([], EVERY, "not comparable"),
    ],
)
def test_a_verdict_is_a_matter_of_counting(truths, share, verdict):
    assert verdict_of(checks(*truths), share) == verdict


def test_equal_numbers_decide_against_a_claim():
    assert not Check(where="the same", value=1.0, limit=1.0).true


def claim_of(*truths: bool) -> Claim:
    return Claim(name="c", statement="s", criterion="Because.", checks=lambda studies: checks(*truths))


def test_a_judgement_lists_its_numbers(studies):
    text = judge(claim_of(True, False), studies).text
    assert text == "1 of 2 true: case 0: 0 < 1; case 1: 2 is not < 1."


def test_of_many_comparisons_a_judgement_lists_those_that_are_not_true(studies):
    assert judge(claim_of(*[True] * 9, False), studies).text == "9 of 10 true; not case 9: 2 is not < 1."
    assert judge(claim_of(*[False] * 9), studies).text.endswith("and 6 more.")


def test_of_many_true_comparisons_a_judgement_shows_the_closest(studies):
    many = [Check(where=f"case {i}", value=i / 10, limit=1.0) for i in range(9)]
    claim = Claim(name="c", statement="s", criterion="Because.", checks=lambda studies: many)
    assert judge(claim, studies).text == "9 of 9 true, the closest case 8: 0.8 < 1."


def test_where_nothing_is_comparable_the_judgement_says_why(studies):
    assert judge(claim_of(), studies).text == "Because."


CELLS = {name for _, each in getmembers(measures, isfunction) for name in signature(each).parameters}
ABOUT = {"name", "statement", "criterion", "share", "published"}
ENTRIES = CELLS | ABOUT | {"measure", "times", "apart", *RULES, "than", "by", "smaller"}


def entries(row) -> set[str]:
    """Every key of a row and of what is in it."""
    if isinstance(row, list):
        return {name for part in row for name in entries(part)}
    if not isinstance(row, dict):
        return set()
    inner = {name for value in row.values() for name in entries(value)}
    return inner | {part for name in row for part in name.split(", ")}


def test_every_entry_of_the_table_is_a_cell_that_some_measure_asks_for_or_a_rule():
    rows = [row for item in TABLE["item"] for row in item.get("claim", [])]
    assert rows
    assert entries([*rows, *TABLE["kind"].values()]) <= ENTRIES


def test_a_cell_of_a_row_counts_for_more_than_that_of_its_item(studies, made_up_circles):
    studies.lugre_circles = made_up_circles(("none", "lugre_static"), lambda law, speed, *where: speed)
    row = {"where": "{law}, {mm_s:g} mm/s", "value": {"measure": "path"}, "limit": "1 - CLEAR", "speed": 0.04}
    cells = {"of": "lugre_circles", "law": "lugre_static", "position": "p1", "speed": 0.01}
    [check] = compare(row, cells, TABLE, studies)
    assert (check.where, check.value, check.limit) == ("static LuGre, 40 mm/s", pytest.approx(0.04), 0.75)
