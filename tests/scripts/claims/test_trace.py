"""Numbers of the pages are traced, and those that no longer hold are named with place, value and command."""

import json

import pytest

from ffgym.core.errors import FFGymError
from scripts.claims import trace
from scripts.claims.__main__ import CheckClaims
from scripts.claims.claim import CLAIMS, Claim, find_passage
from scripts.claims.page import pages, split
from scripts.claims.report import count, describe, list_untraced
from scripts.claims.steps import Step, compare_text, run_steps
from scripts.claims.trace import Fault, check_pages, trace_page

TABLES = "python -m scripts.tables --page page.md"


@pytest.fixture
def write_page(tmp_path, monkeypatch):
    """Write a page of a project of its own, whose only claim says that 24.1 % are left."""
    monkeypatch.setattr("scripts.claims.page.ROOT", tmp_path)
    monkeypatch.setattr("scripts.claims.trace.CLAIMS", {"left": Claim("left", lambda: ["leaves 24.1 % here"], "again")})

    def write(text):
        page = tmp_path / "page.md"
        page.write_text(text, encoding="utf-8")
        return page

    return write


def traced(page):
    return {each.text: each.how for each in trace_page(page).numerals}


@pytest.fixture(scope="module")
def checked():
    return check_pages(pages())


def test_the_numbers_of_all_pages_hold_and_each_is_traced(checked):
    traces, faults = checked
    assert [*map(str, faults)] == []
    assert [*map(str, list_untraced(traces))] == []


def test_the_command_fails_where_a_number_is_traced_by_nothing(write_page, monkeypatch, capsys):
    monkeypatch.setattr("scripts.claims.__main__.pages", lambda: [write_page("Two: 5, 6.")])
    monkeypatch.setattr("scripts.claims.__main__.check_pages", lambda pages: ([trace_page(page) for page in pages], []))
    with pytest.raises(FFGymError, match="do not hold"):
        CheckClaims(short=True).run()
    assert "page.md:1: 5, 6: traced by nothing" in capsys.readouterr().out


def test_a_number_is_traced_by_its_claim_and_its_neighbour_by_nothing(write_page):
    page = write_page("<!-- claim: left -->\nIt leaves\n24.1 % here, 7 there.\n")
    assert traced(page) == {"24.1": "claim", "7": "untraced"}
    assert check_pages([page])[1] == []


def test_a_number_that_is_another_one_is_told_with_its_place_and_command(write_page):
    page = write_page("Words.\n\nIt leaves 23.6 % here. <!-- claim: left -->\n")
    assert [*map(str, check_pages([page])[1])] == ["page.md:3: says 23.6, is 24.1 (left: again)"]


def test_a_sentence_in_other_words_and_a_claim_on_no_page_are_faults(write_page):
    assert "tells, in other words" in str(check_pages([write_page("<!-- claim: left -->\nIt keeps 24.1 % here.\n")])[1])
    assert "no page names the claim 'left'" in str(check_pages([write_page("It leaves 24.1 % here.\n")])[1])
    assert "unknown claim 'right'" in str(check_pages([write_page("<!-- claim: right -->\nIt leaves 1.\n")])[1])


def test_a_passage_does_not_begin_within_a_number():
    (found,) = find_passage("4 % here", [(0, "24 % here")])
    assert found.differences == ((0, "24", "4"),)
    assert find_passage("4 % here", [(0, "of 4 %\nhere")])


def test_parts_that_are_made_code_and_names_are_traced(write_page):
    page = write_page(
        "<!-- laws -->\n| a | 1 |\n<!-- end -->\n\n"
        "```bash\nffgym demo --seeds 2\n```\n\nOn p3, `x=4`, 5 mm.\n\n```text\n6\n```\n"
    )
    assert traced(page) == {"1": "made", "2": "input", "3": "name", "4": "name", "5": "untraced", "6": "untraced"}


def test_a_mark_may_list_the_numbers_that_it_is_for(write_page):
    page = write_page("<!-- cited: thesis for 0.85 -->\nPublished 0.85, ours 1.31.\n")
    assert traced(page) == {"0.85": "cited", "1.31": "untraced"}


@pytest.mark.parametrize(
    ("mark", "message"),
    [
        ("tested: tests/test_package.py::test_of_nothing", "there is no test"),
        ("cited: somebody", "unknown work 'somebody'"),
        ("cited: thesis for 7", "the block lacks 7"),
    ],
)
def test_a_mark_that_leads_nowhere_is_a_fault(mark, message, write_page):
    assert message in str(check_pages([write_page(f"<!-- {mark} -->\nIt is 5.\n")])[1])


def test_a_mark_between_the_lines_of_a_block_is_a_fault(write_page):
    assert "splits the lines" in str(check_pages([write_page("It leaves\n<!-- claim: left -->\n24.1 % here.\n")])[1])
    assert check_pages([write_page("It leaves <!-- claim: left -->\n24.1 % here.\n")])[1] == []


def test_tests_that_pages_name_exist():
    assert trace.test_exists("tests/scripts/claims/test_trace.py::test_tests_that_pages_name_exist")
    assert not trace.test_exists("tests/scripts/claims/test_trace.py::test_of_something_else")


def test_numbers_that_nothing_traces_are_faults_a_line_each(write_page):
    found = [trace_page(write_page("It is 5 or 6.\n\nNot 7.\n"))]
    assert [str(fault) for fault in list_untraced(found)] == [
        "page.md:1: 5, 6: traced by nothing; name what makes it (docs/claims.md)",
        "page.md:3: 7: traced by nothing; name what makes it (docs/claims.md)",
    ]
    assert count(found)["page.md"]["untraced"] == 3
    assert "| page.md" in describe(found)


def test_numbers_of_a_part_that_was_made_again_are_compared_one_by_one():
    old, new = "a\n| x | 1.0 | 2.0 |\n", "a\n| x | 1.0 | 2.5 |\n"
    assert [*map(str, compare_text("page.md", old, new, TABLES))] == [f"page.md:2: says 2.0, is 2.5 ({TABLES})"]
    (fault,) = compare_text("page.md", "words", "other", TABLES)
    assert "is 'other'" in fault.message


def test_an_interrupted_call_goes_on_where_it_was_and_makes_again_what_did_not_hold(tmp_path):
    calls = []

    def make(name, found=(), fails=False):
        calls.append(name)
        if fails:
            raise KeyboardInterrupt
        return [*found]

    wrong = Fault("page.md", 1, "wrong")
    steps = [Step("one", "", lambda: make("one")), Step("two", "", lambda: make("two", [wrong]))]
    broken = Step("three", "", lambda: make("three", fails=True))
    with pytest.raises(KeyboardInterrupt):
        list(run_steps([*steps, broken], tmp_path, "state"))
    made = list(run_steps([*steps, Step("three", "", lambda: make("three"))], tmp_path, "state"))
    assert calls == ["one", "two", "three", "two", "three"]
    assert [str(fault) for one in made for fault in one.faults] == ["page.md:1: wrong"]
    list(run_steps(steps[:1], tmp_path, "another state"))
    assert calls[-1] == "one"


def test_a_step_that_lacks_its_data_is_told_as_not_made(tmp_path):
    def make():
        raise FFGymError("FFGYM_DATA is not set")

    (made,) = run_steps([Step("one", "", make)], tmp_path, "state")
    assert (made.faults, made.skipped) == ((), "FFGYM_DATA is not set")


def test_every_claim_has_a_command():
    assert all(each.command for each in CLAIMS.values())


def test_the_command_prints_what_does_not_hold_and_fails(write_page, monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(
        "scripts.claims.__main__.pages", lambda: [write_page("It leaves 23.6 % here. <!-- claim: left -->\n")]
    )
    with pytest.raises(FFGymError, match="1 numbers of the documentation do not hold"):
        CheckClaims(short=True, json=tmp_path / "claims.json").run()
    assert "page.md:1: says 23.6, is 24.1" in capsys.readouterr().out
    written = json.loads((tmp_path / "claims.json").read_text())
    assert written["pages"]["page.md"]["claim"] == 1
    assert written["faults"][0]["line"] == 1


def test_a_mark_that_is_shown_as_code_is_none():
    assert [
        block.marks for block in split("```markdown\n<!-- claim: a -->\n```\n\nSo `<!-- cited: b -->` here.\n")
    ] == [()] * 2


def test_a_mark_above_a_block_belongs_to_it():
    blocks = list(split("<!-- claim: a -->\n\nOne.\n\nTwo. <!-- cited: b -->\nMore.\n"))
    assert [[mark.text for mark in block.marks] for block in blocks] == [["a"], ["b"]]


def test_a_mark_above_output_is_for_all_of_its_lines_but_not_what_tells_or_lists_numbers():
    output = "```text\n1 one\n2 two\n```\n"
    whole, listed, told = (
        [len(block.marks) for block in split(f"<!-- {mark} -->\n{output}\nThree.\n")]
        for mark in ("tested: a", "tested: a for 1", "claim: a")
    )
    assert whole == [1, 1, 0]
    assert listed == told == [1, 0, 0]
