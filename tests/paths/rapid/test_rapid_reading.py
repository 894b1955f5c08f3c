"""Programs are read whatever their case, line ends, encoding and layout."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rapid_samples import ARITHMETIC, EXPORTED, GOLDEN, WORK_OBJECT, moves, moves_of, program, told

from ffgym.core.errors import FFGymError
from ffgym.paths.rapid import load_program, parse_program
from ffgym.paths.rapid.predefined import PREDEFINED


def same(a, b):
    return [told(move)[2:] for move in a] == [told(move)[2:] for move in b]


@pytest.mark.parametrize("text", GOLDEN.values(), ids=list(GOLDEN))
@pytest.mark.parametrize("change", [str.upper, str.lower, str.swapcase])
def test_case_means_nothing(irb4600, text, change):
    assert same(moves(irb4600, change(text)), moves(irb4600, text))


@pytest.mark.parametrize("text", GOLDEN.values(), ids=list(GOLDEN))
def test_blanks_and_comments_mean_nothing(irb4600, text):
    body = text.split("%%%")[-1]
    airy = re.sub(r"([,;\[\]()])", " \\1 ! MoveL \"[ don't\n\t", re.sub(r"!.*", "", body))
    assert same(moves(irb4600, airy), moves(irb4600, text))


@pytest.mark.parametrize(
    "encoded",
    [
        lambda text: text.encode(),
        lambda text: b"\xef\xbb\xbf" + text.encode(),
        lambda text: text.replace("\n", "\r\n").encode(),
        lambda text: text.replace("\n", "\r").encode(),
        lambda text: ("! gr\u00f6\u00dfer\n" + text).encode("latin-1"),
        lambda text: ("! gr\u00f6\u00dfer \u2264\n" + text).encode(),
    ],
    ids=["plain", "byte order mark", "CRLF", "CR", "Latin-1", "UTF-8"],
)
def test_files_of_any_encoding_and_line_end_are_read(irb4600, tmp_path, encoded):
    path = tmp_path / "cut.mod"
    path.write_bytes(encoded(EXPORTED))
    assert same(load_program(path).execute(irb4600).moves, moves(irb4600, EXPORTED))


@pytest.mark.parametrize("encoding", ["latin-1", "utf-8"])
def test_names_may_have_the_letters_of_a_controller_in_either_case(irb4600, tmp_path, encoding):
    path = tmp_path / "cut.mod"
    path.write_bytes(
        program("MoveL OFFS(p, gr\u00d6\u00dfe, 0, 0), v10, fine, tRobot;", "CONST num Gr\u00f6\u00dfe := 7;").encode(
            encoding
        )
    )
    assert told(load_program(path).execute(irb4600).moves[1])[2] == [1307, -200, 600]


def test_places_count_lines_the_same_with_every_line_end(irb4600):
    for end in ("\n", "\r\n", "\r"):
        with pytest.raises(FFGymError, match=r"^cut.mod:6:1: PDispOff is not supported"):
            moves(irb4600, program("PDispOff;").replace("\n", end))


def test_a_file_that_is_not_there_is_one_error(tmp_path):
    with pytest.raises(FFGymError, match=r"Cannot read RAPID program .*gone.mod: no such file"):
        load_program(tmp_path / "gone.mod")


def test_main_is_run_unless_another_procedure_is_named_or_there_is_only_one(irb4600):
    assert [told(m)[2] for m in moves(irb4600, EXPORTED, "path_10")] == [told(m)[2] for m in moves(irb4600, EXPORTED)]
    assert len(moves(irb4600, ARITHMETIC)) == 6
    with pytest.raises(FFGymError, match=r"cut.mod: has no procedure cut; choose one as entry: main, side"):
        moves(irb4600, WORK_OBJECT, "cut")


def test_predefined_speeds_and_zones_have_the_values_of_the_manual():
    assert PREDEFINED["v10"][1] == (10, 500, 5000, 1000)
    assert PREDEFINED["z10"][1] == (False, 10, 15, 15, 1.5, 15, 1.5)
    assert PREDEFINED["fine"][1] == (True, 0, 0, 0, 0, 0, 0)
    speeds = [v for name, (_, v) in PREDEFINED.items() if re.fullmatch(r"v\d+", name)]
    assert len(speeds) == 25
    assert all(PREDEFINED[f"v{v[0]:g}"][1] == v for v in speeds)
    zones = {int(name[1:]): z for name, (_, z) in PREDEFINED.items() if re.fullmatch(r"z\d+", name)}
    assert sorted(zones) == [0, 1, 5, 10, 15, 20, 30, 40, 50, 60, 80, 100, 150, 200]
    assert all(z[1] == size for size, z in zones.items() if size)
    assert zones[0][1] == 0.3
    assert all(z[5] == z[3] == z[2] and z[4] == z[6] == pytest.approx(z[2] / 10, rel=0.03) for z in zones.values())


numbers = st.floats(-1e4, 1e4).map(lambda x: round(x, 3))


def written(draw, depth):
    """An expression as text, and its value in Python."""
    if depth == 0 or draw(st.booleans()):
        value = abs(draw(numbers))
        return str(value), value
    kind = draw(st.sampled_from(["group", "signed", "chain"]))
    if kind == "group":
        text, value = written(draw, depth - 1)
        return f"({text})", value
    if kind == "signed":
        text, value = written(draw, depth - 1)
        return f"-({text})", -value
    signs = draw(st.lists(st.sampled_from("+-*"), min_size=1, max_size=4))
    parts = [f"({written(draw, depth - 1)[0]})" for _ in range(len(signs) + 1)]
    text = parts[0] + "".join(sign + part for sign, part in zip(signs, parts[1:], strict=True))
    return text, eval(text)


@st.composite
def expressions(draw):
    return written(draw, 3)


@given(expressions())
def test_arithmetic_is_that_of_python(irb4600, expression):
    text, value = expression
    if abs(value) < 1e14:  # positions beyond 1000 m are refused
        (move,) = moves_of(irb4600, f"MoveL Offs(p, ({text}) * 1E-9, 0, 0), v10, fine, tRobot;")
        assert move.to.position[0] - 1.3 == pytest.approx(value * 1e-12, rel=1e-9, abs=1e-15 + 1e-15 * abs(value))


@pytest.mark.parametrize("count", [500, pytest.param(10_000, marks=pytest.mark.slow)])
def test_long_programs_are_read_and_run_in_seconds(irb4600, count):
    line = "MoveL Offs(p, 1, 2.5, -3), v100, z10, tRobot\\WObj:=wobj0;\n"
    assert len(moves_of(irb4600, line * count)) == count


def test_an_empty_program_is_one_error(irb4600):
    for text in ("", "  \n", "! nothing\n", "MODULE m ENDMODULE"):
        with pytest.raises(FFGymError, match=r"^cut.mod: has no procedure; a program needs PROC main"):
            moves(irb4600, text)
    with pytest.raises(FFGymError, match=r"^cut.mod:1:6: the program makes no move"):
        moves(irb4600, "PROC main() ENDPROC")


def test_positions_and_turns_are_those_of_plain_geometry(irb4600):
    (move,) = moves_of(irb4600, "MoveL RelTool(p, 10, 20, 30 \\Rz := 90), v10, fine, tRobot;")
    down = np.diag([-1.0, 1, -1])
    np.testing.assert_allclose(move.to.position, np.array([1.3, -0.2, 0.6]) + down @ [0.01, 0.02, 0.03], atol=1e-12)
    np.testing.assert_allclose(move.to.rotation, down @ [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-12)
    assert parse_program(program("")).name == "program"
