"""All errors of a program are told in one run, each once, with its place."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rapid_samples import GOLDEN, TARGET, program

from ffgym.core.errors import FFGymError
from ffgym.paths.motions.composition import rapid_motion
from ffgym.paths.rapid import parse_program


def errors(robot, text):
    with pytest.raises(FFGymError) as caught:
        parse_program(text, "cut.mod").execute(robot)
    return str(caught.value).split("\n")


def test_errors_of_grammar_names_and_types_are_told_together(irb4600):
    body = """MoveL p v10, fine, tRobot;
WaitTime nothing;
IF 1 = THEN
MoveL p, z10, fine, tRobot;
ENDIF
Unknown 5;
FOR i FROM 1 TO 3 DO
x := "text";
ENDFOR
"""
    lines = errors(irb4600, program(body, "VAR num x;"))
    assert [line.split(": ")[0] for line in lines] == [
        "cut.mod:6:9",
        "cut.mod:7:10",
        "cut.mod:8:8",
        "cut.mod:9:10",
        "cut.mod:11:1",
        "cut.mod:13:6",
    ]


def test_names_that_may_be_declared_where_nothing_could_be_read_are_no_news(irb4600):
    (line,) = errors(irb4600, program("WaitTime lost;", "VAR num lost := := 5;"))
    assert line.startswith("cut.mod:2:17: unexpected ':='")


def test_errors_in_procedures_that_nothing_reaches_do_not_stop_a_program(irb4600):
    text = program("", "VAR socketdev s;", "PROC never() Unknown 5; s := 1; ENDPROC")
    assert len(parse_program(text).execute(irb4600).moves) == 1
    with pytest.raises(FFGymError, match="Unknown is not supported"):
        parse_program(text).execute(irb4600, "never")


def test_moves_that_cannot_be_made_do_not_hide_each_other(irb4600):
    bad = "MoveL p, [0, 1, 1, 1], fine, tRobot;\n"
    lines = errors(irb4600, program(bad + "WaitTime 1;\n" + bad))
    assert [line.split(": ")[0] for line in lines] == ["cut.mod:6:1", "cut.mod:8:1"]


def test_an_error_in_a_loop_is_told_once(irb4600):
    (line,) = errors(irb4600, program("FOR i FROM 1 TO 50 DO MoveL p, [0, 1, 1, 1], fine, tRobot; ENDFOR"))
    assert line.startswith("cut.mod:6:23: speed = 0.0 m/s")


def test_all_targets_that_are_out_of_reach_are_told(arm, tmp_path):
    far = "MoveL Offs(p, 9000, 0, {}), v100, fine, tRobot;\n"
    path = tmp_path / "cut.mod"
    path.write_text(
        program(
            far.format(0)
            + "MoveL p, v100, fine, tRobot;\n"
            + far.format(1)
            + f"MoveJ {TARGET.replace('1300', '8000')}, v100, fine, tRobot;"
        )
    )
    with pytest.raises(FFGymError) as caught:
        rapid_motion(arm, path)
    places = [line.split(": ")[0] for line in str(caught.value).split("\n")]
    assert places == ["cut.mod:6:1", "cut.mod:8:1", "cut.mod:9:1"]


@given(
    st.sampled_from(sorted(GOLDEN)),
    st.integers(0, 10_000),
    st.sampled_from([";", "THEN", ")", "]", ":=", "ENDIF", "WHILE"]),
)
def test_one_slip_in_a_program_is_told_without_many_that_follow_from_it(irb4600, name, where, slip):
    """A sign too many between two statements."""
    text = GOLDEN[name]
    ends = [i + 1 for i, sign in enumerate(text) if sign == ";" and text[i + 1 :].lstrip(" ")[:1] == "\n"]
    at = ends[where % len(ends)]
    assert len(told(irb4600, f"{text[:at]} {slip} {text[at:]}")) <= 3


def told(robot, text):
    """Errors of a program, none if it runs."""
    try:
        parse_program(text, "cut.mod").execute(robot)
    except FFGymError as error:
        return str(error).split("\n")
    return []
