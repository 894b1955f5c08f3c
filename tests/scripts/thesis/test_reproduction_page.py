"""The page of the reproduction: every item once, and the numbers as data."""

import base64
import json
import re
from dataclasses import replace
from pathlib import Path

import pytest

from ffgym.core.errors import FFGymError
from ffgym.envs.machines import make_rig
from scripts.thesis import ITEMS, ThesisStudies, as_json, chosen, count, fingerprints, render_page, reproduce

FIGURES = ["figure-3.3"]
FIGURES += [f"figure-4.{n}" for n in range(2, 13)] + [f"figure-5.{n}" for n in (2, 3, *range(5, 21))]
FIGURES += [f"figure-6.{n}" for n in (*range(1, 8), 10, 11)]
TABLES = ["table-4.1", "table-4.2", "table-5.1", "table-5.2", "table-6.1"]


@pytest.fixture(scope="module")
def sines() -> ThesisStudies:
    """Studies that simulate; shared by tests that need the one axis only."""
    return ThesisStudies()


@pytest.fixture(scope="module")
def results(sines):
    return list(reproduce(chosen(ITEMS, ["figure-4.2", "figure-4.3"]), sines))


@pytest.fixture(scope="module")
def page(results) -> str:
    return render_page(results, {"seed": None, "versions": {"numpy": "9.9"}})


def test_every_figure_and_table_with_numbers_or_curves_is_an_item():
    thesis = [item.name for item in ITEMS if item.chapter != "beyond"]
    assert sorted(thesis) == sorted(FIGURES + TABLES)


def test_names_of_items_and_claims_are_unique():
    for names in ([item.name for item in ITEMS], [claim.name for item in ITEMS for claim in item.claims]):
        assert len(set(names)) == len(names)


@pytest.mark.slow
def test_the_whole_reproduction_shows_and_judges_everything():
    results = list(reproduce(ITEMS, ThesisStudies()))
    page = render_page(results, {})
    names = [figure.name for result in results for figure in result.figures]
    assert len(set(names)) == len(names)
    for result in results:
        assert page.count(f'<section id="{result.item.name}">') == 1
        assert result.figures or result.tables or result.numbers or result.item.counterpart
    for name in names:
        assert page.count(f'<figure id="{name}">') == 1
    verdicts = {j.claim.name: j.verdict for result in results for j in result.judgements}
    assert verdicts["agents-elastic"] == "holds"  # acceptance: 70 % of what dynamic LuGre leaves at 40 and 100 mm/s
    told = ("5.6-zero", "5.9-both", "5.9-less", "5.10-falls", "5.12-motors", "5.12-path", "5.13-less", "5.13-path")
    assert {verdicts[name] for name in told} == {"holds"}
    answers = ("reidentified-mean", "reidentified-circles", "narx-prediction", "narx-extension")
    assert verdicts["other-speeds-faster"] == "holds"
    assert verdicts["other-speeds-slower"] == "partly"  # thesis 5.5; a static network of 40 mm/s is as good at 10 mm/s
    assert {verdicts[name] for name in answers} == {"holds"}  # acceptance: 6.1.3 and 6.2.3 of the thesis, left open
    json.dumps(as_json(results, {}), allow_nan=False)
    sizes = [j for result in results for j in result.judgements if j.claim.name.endswith("-sizes")]
    counts = [f"{sum(check.true for check in part)} of {len(part)}" for j in sizes for part in (j.checks, j.fitted)]
    text = (Path(__file__).parents[3] / "docs" / "reproduction.md").read_text(encoding="utf-8")
    rows = [line.split(" | ")[1:3] for line in text.splitlines() if line.startswith(("| 4.", "| 5."))]
    assert [cell for row in rows for cell in row] == counts


def test_numbers_carry_the_fingerprint_of_every_machine(studies):
    assert list(fingerprints(studies)) == ["irb4600_60_205", "one_axis", "workcell:thesis"]
    assert fingerprints(studies)["workcell:thesis"] == make_rig("workcell:thesis").fingerprint


def test_every_item_of_the_thesis_has_something_to_say_and_to_show():
    for item in ITEMS:
        if item.chapter != "beyond":
            assert item.claims


def test_the_page_has_every_item_exactly_once(studies):
    blank = {"claims": (), "figures": lambda _: (), "tables": lambda _: (), "numbers": lambda _: ()}
    page = render_page(list(reproduce([replace(item, **blank) for item in ITEMS], studies)), {})
    for item in ITEMS:
        assert page.count(f'<section id="{item.name}">') == 1
        assert page.count(f"<h3>{item.heading}: ") == 1


def test_the_page_has_every_claim_with_its_verdict_and_numbers(page, results):
    for result in results:
        for judgement in result.judgements:
            row = re.search(rf'<tr id="{judgement.claim.name}">.*</tr>', page)[0]
            assert f">{judgement.verdict}</span>" in row
            assert judgement.claim.statement in row
            assert f"{judgement.checks[0].value:.3g}" in row


def test_the_page_has_every_picture_once_and_needs_no_other_file(page, results):
    figures = [figure for result in results for figure in result.figures]
    assert len(re.findall(r"svg\+xml;base64,", page)) == len(figures) == 2
    for figure in figures:
        assert page.count(f'<figure id="{figure.name}">') == 1
    assert "http" not in re.sub(r"base64,[\w+/=]+", "", page)
    assert b"<svg" in base64.b64decode(re.search(r"base64,([\w+/=]+)", page)[1])


def test_the_page_says_which_shares_decide_and_what_was_fitted(page):
    for words in ("every one: 100%", "most: 75%", "a majority: 50%", "fitted"):
        assert words in page


def test_what_holds_by_construction_or_was_fitted_says_so():
    criteria = {claim.name: claim.criterion for item in ITEMS for claim in item.claims}
    assert "by construction" in criteria["5.2-range"]
    for table in ("4.1", "4.2", "5.1", "5.2"):
        assert "fitted" in criteria[f"T{table}-sizes"]


def test_the_page_says_where_its_numbers_come_from(page):
    assert '<th class="l">numpy</th><td class="wrap"><code>9.9</code>' in page


def test_a_table_stands_on_the_page_beside_the_published_numbers(studies, made_up_circles):
    studies.lugre_circles = made_up_circles(("none", "lugre_static", "lugre_dynamic"), lambda *where: 0.125)
    page = render_page(list(reproduce(chosen(ITEMS, ["table-4.1"]), studies)), {})
    assert page.count('0.125 <span class="max">(0.250)</span>') == 36
    assert page.count('<td class="published">0.140 <span class="max">(0.31)</span>') == 1


def test_the_numbers_hold_every_claim_with_its_comparisons(results):
    found = json.loads(json.dumps(as_json(results, {"seed": None}), allow_nan=False))
    assert found["seed"] is None
    assert found["verdicts"] == count(results)
    assert sum(found["verdicts"].values()) == sum(len(result.judgements) for result in results)
    [first] = [item for item in found["items"] if item["name"] == "figure-4.2"]
    judgement = results[0].judgements[0]
    assert first["claims"][0]["verdict"] == judgement.verdict
    assert first["claims"][0]["checks"][0]["value"] == judgement.checks[0].value
    assert first["figures"].keys() == {"figure-4.2"}


def test_two_reproductions_find_the_same(results):
    again = list(reproduce([result.item for result in results], ThesisStudies(n_threads=2)))
    assert as_json(again, {}) == as_json(results, {})


def test_items_are_chosen_by_name_or_chapter_in_the_order_of_the_thesis():
    assert [item.name for item in chosen(ITEMS, ["figure-4.5", "figure-4.2"])] == ["figure-4.2", "figure-4.5"]
    assert chosen(ITEMS, ["chapter-4"]) == [item for item in ITEMS if item.chapter == "chapter-4"]
    assert chosen(ITEMS, []) == list(ITEMS)
    with pytest.raises(FFGymError, match=r"Unknown item 'figure-9.9'. Available: chapter-3, chapter-4, .*figure-4.2"):
        chosen(ITEMS, ["figure-9.9"])
