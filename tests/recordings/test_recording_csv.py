import io
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from recording_samples import header, read_or_refused, recording, refused

from ffgym.core.errors import FFGymError
from ffgym.recordings.csv import MAGIC, decode, encode

GOOD = encode(recording())
FIRST = GOOD.split(b"\n").index(b"# }") + 1
"""Index of the row of column names."""
FOREIGN = b"timestamp,user.x\n0.0,1.0\n0.5,2.0\n"
UNITS = header(units={"user.x": "1"})


def edited(line: int, text: bytes) -> bytes:
    """The good file with the line after the row of names replaced, `line` counted from there."""
    lines = GOOD.split(b"\n")
    lines[FIRST + line] = text
    return b"\n".join(lines)


@pytest.mark.parametrize("end", [b"\r\n", b"\r"])
@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"])
def test_line_ends_and_byte_order_mark_do_not_matter(end: bytes, mark: bytes) -> None:
    assert decode(mark + GOOD.replace(b"\n", end)).equals(recording())


def test_blank_lines_spaces_and_quotes_do_not_matter() -> None:
    assert decode(b'\n"timestamp", user.x \n\n 0.0,1 \n\n0.5, 2e0\n\n', UNITS).equals(decode(FOREIGN, UNITS))


def test_file_of_another_tool_needs_a_header() -> None:
    for data in (FOREIGN, b"# made by a tool\n" + FOREIGN):
        with refused(
            "Pass read_recording(path, header=Header(...)) with robot, joints, gear_ratio, and as far as known"
        ):
            decode(data)
        assert decode(data, UNITS)["user.x"].tolist() == [1.0, 2.0]


def test_file_of_another_tool_may_end_without_a_line_end() -> None:
    assert len(decode(FOREIGN[:-1], UNITS)) == 2


def test_other_readers_can_skip_the_header() -> None:
    table = np.genfromtxt(io.BytesIO(GOOD), delimiter=",", names=True, skip_header=FIRST, deletechars="")
    np.testing.assert_array_equal(table["tcp.position.z"], recording()["tcp.position.z"])


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (GOOD[:-1], f"Line {FIRST + 6} has no line end: the file is cut short"),
        (GOOD[: GOOD.index(b"# }")] + b"\n", "The header is not valid JSON"),
        (GOOD.replace(b'"schema_version": 1', b'"schema_version": 2'), "schema_version = 2 is not readable"),
        (b"\n".join(GOOD.split(b"\n")[:FIRST]) + b"\n", "has no row of column names"),
        (b"\n".join(GOOD.split(b"\n")[: FIRST + 1]) + b"\n", "at least 2 rows, got 0"),
        (edited(2, b"0.004,1,2,3,4"), f"Line {FIRST + 3} has 5 cells, must have 6, one per column"),
        (edited(1, b"0,1,2,3,4,5,6"), f"Line {FIRST + 2} has 7 cells, must have 6"),
        (edited(2, b"0.004,1,x,3,4,5"), f"Line {FIRST + 3}, column 'motor.position.j2': 'x' is not a number"),
        (edited(2, b"0.004,1,,3,4,5"), "column 'motor.position.j2': '' is not a number. Write nan"),
        (edited(2, b"0.004,1,1_0,3,4,5"), "'1_0' is not a number"),
        (
            edited(2, b'0.004,1,"2\n3",3,4,5'),
            f"Line {FIRST + 4}, column 'motor.position.j2': '2\\n3' is not a number",
        ),
        (edited(2, b"0.004,1,nan,3,4,5"), "Column 'motor.position.j2' row 1 is nan"),
        (edited(2, b"0.004,1,1e999,3,4,5"), "Column 'motor.position.j2' row 1 is inf"),
        (edited(1, b"0.004,1,2,3,4,5"), "row 1 is 0.004 s after 0.004 s"),
        (edited(3, b"# a comment"), f"Line {FIRST + 4} has 1 cells"),
        (edited(3, b'"0.008'), "is not CSV: unexpected end of data"),
        (edited(3, b"1" * 200_000), "is not CSV: field larger than field limit"),
        (GOOD.replace(b"motor.position.j2", b"motor.position.j1"), "names 'motor.position.j1' more than once"),
        (GOOD.replace(b"motor.position.j2", b"motor.position.j3"), "names joint 'j3'"),
        (GOOD.replace(b"0.004,", b"0.004\xff,"), "not UTF-8 text: byte"),
        (edited(0, b"timestamp;motor.position.j1"), "separated by semicolons or tabs"),
    ],
)
def test_damaged_file_is_refused(data: bytes, message: str) -> None:
    with refused(message):
        decode(data)


@given(st.binary())
def test_arbitrary_bytes_are_refused(data: bytes) -> None:
    for start in (b"", MAGIC.encode() + b"\n", GOOD):
        with pytest.raises(FFGymError):
            decode(start + data + b"!")


@given(st.text('0123456789.,-+eE_naif\n\r"#; ', max_size=60))
def test_arbitrary_tables_are_read_or_refused(text: str) -> None:
    with read_or_refused():
        decode(b"timestamp,user.x\n" + text.encode(), UNITS)


@given(st.integers(0, len(GOOD) - 1), st.binary(max_size=3), st.integers(0, 3))
def test_file_with_damaged_bytes_is_read_or_refused(place: int, insert: bytes, drop: int) -> None:
    with read_or_refused():
        decode(GOOD[:place] + insert + GOOD[place + drop :])


@given(st.integers(0, len(GOOD) - 1))
def test_file_cut_within_a_line_is_refused(length: int) -> None:
    cut: Any = GOOD[:length]
    rows_end = cut.endswith(b"\n") and cut.count(b"\n") >= FIRST + 3
    if not rows_end:
        with pytest.raises(FFGymError):
            decode(cut)
