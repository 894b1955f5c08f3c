"""The one page: parts of every kind, numbered figures, and where its numbers come from."""

import re
from dataclasses import replace

import pytest

from ffgym.report import Details, Items, Note, Page, ReportFigure, Section, Table, panels
from ffgym.report.page import Legend
from tests.report.html_pages import Page as Tree


def picture(name):
    with panels(size=(2.0, 1.0)) as (figure, grid):
        grid[0, 0].plot([0, 1], [0, 1], label="a line")
    return ReportFigure(name=name, title=f"Title of {name}", caption="A <caption>.", figure=figure)


@pytest.fixture
def page():
    pytest.importorskip("jinja2")
    parts = [
        "See `a < b`, **now**.",
        Section("First", [Note("Pale."), picture("one"), Section("Smaller", [Items(["x", "y"])])], headline=["Boxed."]),
        Section("Second", [picture("two"), Details("More", [Table.of_rows(["a"], [["b"]]), picture("three")])]),
        Legend("Colours:", {"red one": "#ff0000"}),
    ]
    return Page(
        title="A & B", subtitle="under", headline=["Short."], parts=parts, provenance={"seed": 7, "v": {"n": 1}}
    )


def test_every_part_is_there_and_closed(page):
    html = page.html()
    assert Tree(html).open == []
    for said in (
        "<p>See <code>a &lt; b</code>, <b>now</b>.</p>",
        "<h1>A &amp; B</h1>",
        "<h2>First</h2>",
        "<h3>Smaller</h3>",
        "<li>x</li>",
        '<p class="note">Pale.</p>',
        "<p>Boxed.</p>",
        "<details><summary>More</summary>",
        'style="background:#ff0000"></span>red one.',
        "A &lt;caption&gt;.",
        '<th class="l">seed</th><td class="wrap"><code>7</code>',
        '<th class="l">n</th>',
    ):
        assert said in html


def test_how_to_read_a_page_comes_before_everything_else(page):
    html = replace(page, reading=["First `this`."]).html()
    assert re.search(r"How to read this page</h2>\s*<p>First <code>this</code>", html)
    assert html.index("How to read this page") < html.index("Short.") < html.index("See <code>")
    assert "How to read" not in page.html()


def test_figures_are_numbered_through_all_sections(page):
    html = page.html()
    assert re.findall(r"<b>(Figure \d)\. Title of (\w+)\.", html) == [
        ("Figure 1", "one"),
        ("Figure 2", "two"),
        ("Figure 3", "three"),
    ]
    assert html.count("data:image/svg+xml") == 3


def test_a_page_without_a_date_is_the_same_each_time(page):
    undated = Page(title="t", parts=page.parts, provenance={}, is_dated=False)
    assert undated.html() == undated.html()
    assert "written" in page.html()
    assert "written" not in undated.html()


def test_the_legend_names_each_line_of_all_panels_once():
    with panels(1, 2, size=(4.0, 2.0)) as (figure, grid):
        for axes, labels in zip(grid[0], (("a", "b"), ("b", "c")), strict=True):
            for label in labels:
                axes.plot([0, 1], [0, 1], label=label)
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["a", "b", "c"]
