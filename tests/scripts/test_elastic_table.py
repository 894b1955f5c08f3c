"""The tables of docs/agents/elastic.md on a small budget, and that the page says what they say."""

import re

from scripts.elastic_table import PAGE, Config, main


def numbers(table):
    rows = [row.strip("| ").split(" | ") for row in table.splitlines()[2:]]
    return {name: [float(value) for value in values] for name, *values in rows}


def test_the_tables_are_computed_and_written_between_their_marks(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("a\n<!-- laws -->\nold\n<!-- end -->\nb\n<!-- machines -->\n<!-- end -->\n", encoding="utf-8")
    tables = main(Config(positions=("p1",), speeds=(0.1,), radii=(0.003,), write=page))
    text = page.read_text(encoding="utf-8")
    marks = "a\n<!-- laws -->", "<!-- end -->\nb\n<!-- machines -->", "<!-- end -->\n"
    assert text == "\n".join((marks[0], tables["laws"], marks[1], tables["machines"], marks[2]))
    laws, machines = numbers(tables["laws"]), numbers(tables["machines"])
    assert laws["elastic"] == machines["as it is"]
    assert all(error > laws["elastic"] for name, error in laws.items() if "%" in name)  # each wrong model is worse
    assert len(machines) == 5


def test_the_page_says_what_its_table_says():
    text = PAGE.read_text(encoding="utf-8")
    (table,) = re.findall(r"<!-- laws -->\n(.*?)\n<!-- end -->", text, flags=re.S)
    rows = numbers(table)
    gains = [1 - rest / lugre for rest, lugre in zip(rows["elastic"], rows["lugre_dynamic"], strict=True)]
    shares = [f"{100 * gain:.1f} %" for gain in gains[1:]]
    assert f"{shares[0]} at 40 mm/s and {shares[1]} at 100 mm/s" in text
