"""Tables in text, as spreadsheets, oscilloscopes and controllers write them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from log_samples import refused

from ffgym.core.errors import FFGymError
from ffgym.logs import TextLayout
from ffgym.logs.formats.text import Text

NAMES = ("t", "q1", "q2")
ROWS = np.array([[0.0, 1.5, -2.25], [0.004, 1e-7, 3e22], [0.008, 0.1, 1 / 3]])


def table(delimiter=",", decimal=".", end="\n", names=NAMES, before="", after=""):
    rows = [delimiter.join(map(repr, row)).replace(".", decimal) for row in ROWS.tolist()]
    return end.join([*before.splitlines(), *([delimiter.join(names)] if names else []), *after.splitlines(), *rows, ""])


def read(text, layout=None, encoding="utf-8"):
    return Text().decode(text.encode(encoding), "log.csv", layout)


def check(contents, names=NAMES):
    assert tuple(contents) == names
    for i, name in enumerate(names):
        assert contents[name].tobytes() == ROWS[:, i].tobytes()


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize(
    ("delimiter", "decimal"), [(",", "."), (";", "."), ("\t", "."), (" ", "."), (";", ","), ("\t", ",")]
)
def test_delimiters_decimals_and_line_ends_are_read_to_the_bit(delimiter, decimal, end):
    check(read(table(delimiter, decimal, end), TextLayout(decimal=decimal)))


@given(
    numbers=st.lists(st.lists(st.floats(allow_infinity=False), min_size=2, max_size=2), min_size=1, max_size=5),
    delimiter=st.sampled_from(list(",;\t ")),
)
def test_any_numbers_come_back_to_the_bit(numbers, delimiter):
    text = "\n".join(["a" + delimiter + "b", *(delimiter.join(map(repr, row)) for row in numbers), ""])
    contents = read(text)
    for i, name in enumerate("ab"):
        np.testing.assert_array_equal(contents[name], np.array(numbers)[:, i])


def test_lines_before_the_table_and_a_row_of_units_are_skipped():
    text = table(before="Recorder 7\nDate; 12.03.2021\n", after="s, deg, deg")
    check(read(text, TextLayout(names_row=3, units_row=4)))
    check(read(table(before="# Recorder 7\n\n# Date\n")))
    check(read(table(before="% Recorder\n"), TextLayout(comment="%")))


def test_a_table_without_names_has_numbered_columns():
    check(read(table(names=())), ("1", "2", "3"))
    check(read(table(names=(), before="Recorder 7"), TextLayout(names_row=0, first_row=2)), ("1", "2", "3"))


@pytest.mark.parametrize("encoding", ["utf-8-sig", "latin-1", "utf-16"])
def test_other_encodings_are_read_if_they_are_named(encoding):
    names = ("t", "Position [°]", "q2")
    text = table(names=names)
    layout = TextLayout() if encoding == "utf-8-sig" else TextLayout(encoding=encoding)
    check(read(text, layout, encoding), names)
    if encoding != "utf-8-sig":
        with refused("The file is not utf-8-sig text", 'e.g. "latin-1"'):
            read(text, encoding=encoding)


def test_quotes_and_names_that_come_twice_and_delimiters_at_the_end_are_read():
    contents = read('"t, s","q","q",\n0,"1.5",2,\n1,2.5,3,\n')
    assert list(contents) == ["t, s", "q", "q#2"]
    np.testing.assert_array_equal(contents["q#2"], [2.0, 3.0])
    assert list(read("a,b\n0,1,\n1,2,\n")) == ["a", "b"]
    assert list(read(",b\n0,1\n1,2\n")) == ["#1", "b"]


def test_empty_cells_are_missing_samples_and_words_make_text():
    contents = read("t,x,state\n0,,RUN\n1,nan,STOP\n2,4,RUN\n")
    np.testing.assert_array_equal(contents.numbers("x"), [np.nan, np.nan, 4.0])
    with refused("'state' is not numbers: row 0 is 'RUN'"):
        contents.numbers("state")


@pytest.mark.parametrize("cell", ["1_000", "1,5", "0x10", "1.2.3", "12:03:04", "1e"])
def test_a_cell_that_is_almost_a_number_is_none(cell):
    with refused("'x' is not numbers: row 1"):
        read(f"t;x\n0;1\n1;{cell}\n2;3\n").numbers("x")


def test_a_thousands_separator_is_no_decimal_point():
    with refused("row 0 is '1.234 with a decimal point'"):
        read("t;x\n0;1.234\n1;2,5\n", TextLayout(decimal=",")).numbers("x")


def test_the_last_line_may_lack_its_end():
    assert read("a,b\n1,2\n3,4").numbers("b").tolist() == [2, 4]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a,b\n1,2\n3\n", "Line 3 has 1 cells, but there are 2 columns: a, b"),
        ("a,b\n1,2\n3,4,5\n", "Line 3 has 3 cells"),
        ("a,b\n1,2\n3", "Line 3 has 1 cells, but there are 2 columns: a, b. Damaged or cut short there"),
        ("a,b\n", "There are no rows from line 2 on"),
        ("\n\n# nothing\n", "The file has no lines but blank ones and comments"),
        (",\n1,2\n", "Line 1 holds no names of columns"),
        ('a,b\n1,"2\n', "Line 2 is not a row of cells"),
    ],
)
def test_a_damaged_table_names_the_line(text, message):
    with refused(message):
        read(text)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"delimeter": ";"}, "Unknown key 'delimeter' in [file]. Closest: delimiter"),
        ({"delimiter": "::"}, "delimiter = '::' must be one character"),
        ({"decimal": ";"}, "decimal = ';' must be '.' or ','."),
        ({"encoding": "klingon"}, "encoding = 'klingon' is no encoding of text"),
        ({"encoding": "base64"}, "encoding = 'base64' is no encoding of text"),
        ({"encoding": "utf\0"}, "is no encoding of text"),
        ({"names_row": -1}, "names_row = -1.0 is out of range"),
        ({"names_row": 1.5}, "names_row = 1.5 must be a whole number"),
        ({"comment": ""}, "comment = '' must be text"),
    ],
)
def test_a_layout_that_cannot_be_is_refused(keys, message):
    with refused(message):
        TextLayout.of(keys)


@pytest.mark.parametrize("row", [1, 2, 5, 99])
def test_a_row_of_units_that_does_not_follow_the_names_is_refused_as_rows_would_be_lost(row):
    with refused(f"units_row = {row} must be the line after the names, which are in line 2"):
        read("Trace 7\nt;x\n\n0;1\n1;2\n2;3\n", TextLayout(names_row=2, units_row=row))


def test_blank_lines_and_comments_may_come_between_names_and_units():
    contents = read("t;x\n\n# of the motor\ns;rad\n0;1\n1;2\n", TextLayout(units_row=4))
    assert contents.numbers("x").tolist() == [1.0, 2.0]


def test_a_names_row_beyond_the_file_is_refused():
    with pytest.raises(FFGymError, match="names_row = 9, but the file has only 4 lines"):
        read(table(), TextLayout(names_row=9))
