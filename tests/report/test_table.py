"""The one table: the same rows in a terminal, in Markdown and on a page."""

import pytest

from ffgym.report import Cell, Column, Page, Table
from ffgym.report.table import WIDTH, pair


@pytest.fixture
def table() -> Table:
    return Table(
        columns=[
            Column("joint", ["j1", "j2", "a joint with a name of forty letters xxxx"], kind="name"),
            Column("error", [0.1234, None, 2.0], ".2f", unit="mm"),
            Column("RMS", [pair(0.5, 1.0, ".1f"), None, pair(0.25, None, ".2f")], group="law", colour="#123456"),
            Column("note", ["a | b", "", "<b>"], group="law", kind="text"),
        ],
        name="errors",
        note="Of `code`.",
        ruled_by=0,
        strong=[-1],
    )


def test_a_terminal_gets_numbers_in_their_format_and_cut_names(table):
    assert table.text().splitlines() == [
        "                               |            | law",
        "joint                          | error [mm] | RMS        note",
        "j1                             | 0.12       | 0.5 (1.0)  a | b",
        "j2                             | -          | -",
        "a joint with a name of forty … | 2.00       | 0.25 (-)   <b>",
    ]


def test_columns_that_do_not_fit_a_terminal_go_below_beside_the_fixed_ones():
    columns = [Column(f"c{i}", [f"value {i} of a row"], kind="text") for i in range(12)]
    text = Table(columns=columns).text()
    assert max(map(len, text.splitlines())) <= WIDTH
    first, second, *_ = text.split("\n\n")
    assert first.startswith("c0")
    assert second.startswith("c0")
    assert all(f"value {i} of a row" in text for i in range(12))


def test_markdown_has_the_same_cells_and_bars_that_do_not_end_them(table):
    assert table.markdown().splitlines() == [
        "| joint | error [mm] | RMS | note |",
        "|---|---|---|---|",
        r"| j1 | 0.12 | 0.5 (1.0) | a \| b |",
        "| j2 | - | - |  |",
        "| a joint with a name of forty letters xxxx | 2.00 | 0.25 (-) | <b> |",
    ]


def test_a_page_has_the_same_cells_under_their_groups(table):
    pytest.importorskip("jinja2")
    html = Page(title="t", parts=[table], provenance={}).html()
    assert '<table id="errors">' in html
    assert '<th class="group edge" colspan="2"><span class="swatch" style="background:#123456"></span>law</th>' in html
    assert '<td class="l">j1</td><td>0.12</td><td class="edge">0.5 <span class="max">(1.0)</span></td>' in html
    assert '<td class="l">j2</td><td>–</td><td class="edge">–</td>' in html
    assert "a joint with a name of forty letters xxxx" in html
    assert "&lt;b&gt;" in html
    assert html.count('<tr class="first">') == 2
    assert html.count('<tr class="mean first">') == 1
    assert '<p class="note">Of <code>code</code>.</p>' in html


def test_a_table_comes_from_rows_too():
    table = Table.of_rows(["a", "b"], [["1", "2"], ["3", Cell("4", "five")]])
    assert table.markdown().splitlines()[2:] == ["| 1 | 2 |", "| 3 | 4 five |"]
    assert table.markdown(aligned=True).splitlines()[2:] == ["| 1 | 2      |", "| 3 | 4 five |"]


def test_a_table_without_rows_is_its_heading():
    table = Table.of_rows(["a", "b"], [])
    assert table.rows == ()
    assert table.text() == "a | b"
