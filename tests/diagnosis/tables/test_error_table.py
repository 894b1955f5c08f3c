"""Tables are read as they were written, and a mistake in one is told with its place."""

from pathlib import Path

import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.tables.published import thesis_table
from ffgym.diagnosis.tables.table_file import load_table, write_table

HEAD = 'robot = "irb4600_60_205"\nrows = "rows.csv"\n'
COLUMNS = "use,motion,position,speed_mm_s,radius_mm,law,statistic,value_mm"
ROW = "fitted,,p1,40,1,none,rms,0.14"


def load(tmp_path, rows, head=HEAD):
    (tmp_path / "table.toml").write_text(head)
    (tmp_path / "rows.csv").write_text("\n".join(rows) + "\n")
    return load_table(tmp_path / "table.toml")


def test_the_table_of_the_thesis_has_its_240_numbers():
    table = thesis_table()
    assert len(table.rows) == 240
    assert table.fitted.sum() == 144
    assert (table.is_rms & ~table.fitted).sum() == 48
    row = next(r for r in table.rows if (r.law, r.statistic, r.cell) == ("none", "rms", "p1, 10 mm/s, r = 1 mm"))
    assert row.value_mm == 0.14
    assert row.table == "4.1"
    assert len(table.sign_pairs()) == 4


def test_a_table_is_read_as_it_was_written(tmp_path):
    table = thesis_table()
    write_table(tmp_path / "thesis.toml", table)
    read = load_table(tmp_path / "thesis.toml")
    assert read.rows == table.rows
    assert (read.alike, read.sign_of, read.title) == (table.alike, table.sign_of, table.title)


def test_a_small_table_has_its_row(tmp_path):
    table = load(tmp_path, [COLUMNS, ROW])
    assert table.values.tolist() == [0.14]
    assert table.places == ("p1",)


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ([COLUMNS], "has no rows"),
        ([COLUMNS + ",colour", ROW + ",red"], "Unknown column 'colour'"),
        ([COLUMNS.replace(",law", ""), ROW.replace(",none", "")], "columns law are missing"),
        ([COLUMNS, ROW.replace("0.14", "many")], "row 2: value_mm must be a number in mm, got 'many'"),
        ([COLUMNS, ROW.replace("0.14", "-1")], "value_mm = -1.0 mm is out of range"),
        ([COLUMNS, ROW.replace("rms", "mean")], "Unknown statistic 'mean'"),
        ([COLUMNS, ROW.replace("fitted", "seen")], "Unknown use 'seen'"),
        ([COLUMNS, ROW, ROW], "Two rows of 'table' are of one measurement"),
        ([COLUMNS, ROW.replace("fitted", "held_out")], "has no row to fit to"),
        ([COLUMNS, ROW.replace("p1", "")], "give one of them"),
        ([COLUMNS, ROW + ",7"], "row 2: has 9 cells, must have 8"),
    ],
)
def test_a_mistake_is_told_with_its_place(tmp_path, rows, words):
    with pytest.raises(FFGymError) as caught:
        load(tmp_path, rows)
    assert words in str(caught.value)


def test_an_unknown_entry_of_the_head_is_told(tmp_path):
    with pytest.raises(FFGymError, match="Unknown entry 'robots'"):
        load(tmp_path, [COLUMNS, ROW], HEAD + 'robots = "two"\n')


def test_a_question_of_the_sign_that_no_rows_answer_is_told(tmp_path):
    question = 'sign_of = { law = "lugre_dynamic", speed_mm_s = 40, radius_mm = 1 }\n'
    with pytest.raises(FFGymError, match="no two RMS rows of one position"):
        load(tmp_path, [COLUMNS, ROW], HEAD + question)


def test_a_twin_is_a_circle_that_the_table_has(tmp_path):
    head = HEAD + 'alike = [["p1", "p4"]]\n'
    table = load(tmp_path, [COLUMNS, ROW, *(ROW.replace("p1,40,1", cell) for cell in ("p4,40,1", "p4,40,3"))], head)
    twins = [table.twin(row).cell for row in table.rows]
    assert twins == ["p1, 40 mm/s, r = 1 mm", "p1, 40 mm/s, r = 1 mm", "p4, 40 mm/s, r = 3 mm"]


def test_paths_count_from_the_folder_of_the_table(tmp_path):
    (tmp_path / "table.toml").write_text('robot = "arm.toml"\nrows = "rows.csv"\n')
    (tmp_path / "rows.csv").write_text("use,motion,law,statistic,value_mm\nfitted,corner.toml,none,rms,0.1\n")
    table = load_table(tmp_path / "table.toml")
    (tmp_path / "out").mkdir()
    write_table(tmp_path / "out" / "table.toml", table)
    read = load_table(tmp_path / "out" / "table.toml")
    for each in (table, read):
        assert Path(each.robot).resolve() == tmp_path / "arm.toml"
        assert each.motion_file(each.motions[0]).resolve() == tmp_path / "corner.toml"
