"""Statements, routines and expressions of RAPID do what the reference manual says."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rapid_samples import moves, moves_of, program

from ffgym.core.errors import FFGymError
from ffgym.paths.rapid import load_program, parse_program


def waits(robot, body, data="VAR num x := 0;", more=""):
    """Durations of the waits of some statements, which tell numbers."""
    return [move.duration for move in moves_of(robot, body, data, more)]


STATEMENTS = {
    "FOR i FROM 1 TO 3 DO WaitTime i; ENDFOR": [1, 2, 3],
    "FOR i FROM 3 TO 1 DO WaitTime i; ENDFOR": [3, 2, 1],
    "FOR i FROM 1 TO 6 STEP 2 DO WaitTime i; ENDFOR": [1, 3, 5],
    "FOR i FROM 3 TO 1 STEP 1 DO WaitTime i; ENDFOR WaitTime 9;": [9],
    "FOR i FROM 1 TO 2 DO FOR j FROM 1 TO i DO WaitTime 10 * i + j; ENDFOR ENDFOR": [11, 21, 22],
    "WHILE x < 2 DO x := x + 1; WaitTime x; ENDWHILE": [1, 2],
    "IF x = 0 WaitTime 1; IF x <> 0 WaitTime 2;": [1],
    "IF x > 0 THEN WaitTime 1; ELSEIF x = 0 THEN WaitTime 2; ELSE WaitTime 3; ENDIF": [2],
    "IF x > 0 THEN WaitTime 1; ELSEIF x < 0 THEN WaitTime 2; ELSE WaitTime 3; ENDIF": [3],
    "TEST x CASE 1, 2: WaitTime 1; CASE -1, 0: WaitTime 2; DEFAULT: WaitTime 3; ENDTEST": [2],
    'TEST "b" CASE "a": WaitTime 1; DEFAULT: WaitTime 3; ENDTEST': [3],
    "again: x := x + 1; WaitTime x; IF x < 3 GOTO again;": [1, 2, 3],
    "GOTO over; WaitTime 1; over: WaitTime 2;": [2],
    "WaitTime 1; RETURN; WaitTime 2;": [1],
    "WaitTime 1; EXIT; WaitTime 2;": [1],
    "Incr x; Incr x; Decr x; Add x, 5; WaitTime x; Clear x; WaitTime x + 1;": [6, 1],
    "IF NOT x = 1 AND x < 5 WaitTime 1;": [1],
    "IF x = 1 OR NOT x > 0 WaitTime 1;": [1],
    "IF x = 1 XOR x = 0 WaitTime 1;": [1],
    "WaitTime 17 DIV 5 + 17 MOD 5 * 10;": [23],
    "WaitTime 9 + (-7) DIV 2 + (-7) MOD 4;": [3],
    "WaitTime 0x1F - 0b11;": [28],
    "IF pi > 3 WaitTime high;": [1],
}


@pytest.mark.parametrize(("body", "told"), STATEMENTS.items())
def test_statements_run_in_their_order(irb4600, body, told):
    assert waits(irb4600, body) == told


ROUTINES = {
    "values are copied": ("raise5 x, 5; WaitTime x + 1;", "PROC raise5(num a, num b) a := a + b; ENDPROC", [1]),
    "INOUT changes": ("raise5 x, 5; WaitTime x;", "PROC raise5(INOUT num a, num b) a := a + b; ENDPROC", [5]),
    "VAR changes an element": (
        "more l{2}; WaitTime l{2}; WaitTime l{1};",
        "PROC more(VAR num a) a := a + 7; ENDPROC",
        [9, 1],
    ),
    "a switch": (
        "go\\Fast; go;",
        "PROC go(\\switch Fast) IF Present(Fast) THEN WaitTime 1; ELSE WaitTime 2; ENDIF ENDPROC",
        [1, 2],
    ),
    "an optional value": (
        "go\\T:=3; go;",
        "PROC go(\\num T) VAR num t := 9; IF Present(T) t := T; WaitTime 1; ENDPROC",
        None,
    ),
    "one of two switches": (
        "go 4\\Up; go 4\\Down;",
        "PROC go(num a\\switch Up|switch Down) IF Present(Up) WaitTime a; IF Present(Down) WaitTime 2 * a; ENDPROC",
        [4, 8],
    ),
    "options passed on": (
        "go\\T:=3; go;",
        "PROC go(\\num T) at\\T?T; ENDPROC PROC at(\\num T) WaitTime 8; IF Present(T) WaitTime T; ENDPROC",
        [8, 3, 8],
    ),
    "a function": ("WaitTime twice(4);", "FUNC num twice(num a) RETURN 2 * a; ENDFUNC", [8]),
    "arrays of any size": (
        "WaitTime total(l);",
        "FUNC num total(num a{*}) VAR num t := 0; FOR i FROM 1 TO Dim(a, 1) DO t := t + a{i}; ENDFOR RETURN t; ENDFUNC",
        [6],
    ),
    "a call by name": (
        '%"step" + NumToStr(2, 0)%; %"step1"%;',
        "PROC step1() WaitTime 1; ENDPROC PROC step2() WaitTime 2; ENDPROC",
        [2, 1],
    ),
    "an error handler is not run": ("go;", "PROC go() WaitTime 1; ERROR WaitTime 2; RETRY; ENDPROC", [1]),
}


@pytest.mark.parametrize("name", list(ROUTINES))
def test_routines_take_their_arguments_as_declared(irb4600, name):
    body, more, told = ROUTINES[name]
    if told is None:  # a name of its own beside a parameter, in another case
        with pytest.raises(FFGymError, match="t is declared twice in go"):
            waits(irb4600, body, more=more)
        return
    assert waits(irb4600, body, "VAR num x := 0; VAR num l{3} := [1, 2, 3];", more) == told


def test_arrays_of_three_dimensions_are_read_and_changed_by_their_indices(irb4600):
    data = "VAR num a{2,2,2} := [[[1,2],[3,4]],[[5,6],[7,8]]]; VAR pos p1{2}; CONST num n := 2;"
    body = "a{2,1,n} := 60; p1{2}.y := 9; WaitTime a{2,1,2}; WaitTime a{1,2,1}; WaitTime p1{2}.y; WaitTime Dim(a,3);"
    assert waits(irb4600, body, data) == [60, 3, 9, 2]
    with pytest.raises(FFGymError, match=r"^cut.mod:6:14: index 3 is out of range, must be a whole number from 1 to 2"):
        waits(irb4600, "WaitTime a{2,3,1};", data)
    with pytest.raises(FFGymError, match=r"^cut.mod:6:10: a has 3 dimensions, got 2 indices"):
        waits(irb4600, "WaitTime a{2,1};", data)


def test_records_and_other_names_of_types_are_types(irb4600):
    data = "RECORD cut num depth; pos at; ENDRECORD ALIAS num level; VAR cut c := [2, [0, 0, 7]]; VAR level l := 3;"
    assert waits(irb4600, "c.depth := c.depth + l; WaitTime c.depth; WaitTime c.at.z;", data) == [5, 7]


def test_data_may_be_declared_below_where_they_are_used(irb4600):
    assert waits(irb4600, "WaitTime a;", "CONST num a := 2 * b; CONST num b := 3;") == [6]


def test_local_names_of_two_modules_are_different_ones(irb4600):
    first = program("WaitTime x; other;", "LOCAL CONST num x := 1;")
    second = "MODULE n LOCAL CONST num x := 2; PROC other() WaitTime x; ENDPROC ENDMODULE"
    assert [move.duration for move in moves(irb4600, first + second)[1:]] == [1, 2]
    with pytest.raises(FFGymError, match=r"cut.mod:\d+:\d+: x is declared twice, first at cut.mod:2:11"):
        moves(irb4600, (first + second).replace("LOCAL ", ""))


def test_a_program_of_several_files_is_found_by_its_list(irb4600, tmp_path):
    (tmp_path / "p.pgf").write_text('<?xml version="1.0"?><Program><Module>a.mod</Module></Program>')
    (tmp_path / "a.mod").write_text(program("WaitTime t;"))
    with pytest.raises(FFGymError, match=r"^a.mod:6:10: t is not declared; declare it in this module or another one"):
        load_program(tmp_path / "p.pgf").execute(irb4600)
    (tmp_path / "user.sys").write_text("MODULE u(SYSMODULE) PERS num t := 4; ENDMODULE")
    assert load_program(tmp_path / "p.pgf").execute(irb4600).moves[-1].duration == 4
    (tmp_path / "bad.pgf").write_text("<Program>")
    with pytest.raises(FFGymError, match=r"bad\.pgf: is no list of modules in XML"):
        load_program(tmp_path / "bad.pgf")


angles = st.floats(-179, 179)


@given(angles, st.floats(-89, 89), angles)
def test_euler_angles_and_orientations_turn_back(irb4600, z, y, x):
    body = f"o := OrientZYX({z}, {y}, {x}); WaitTime 200 + EulerZYX(\\Z, o); WaitTime 200 + EulerZYX(\\Y, o);"
    found = waits(irb4600, body + "WaitTime 200 + EulerZYX(\\X, o);", "VAR orient o;")
    np.testing.assert_allclose(np.array(found) - 200, [z, y, x], atol=1e-6)


@given(st.tuples(*(st.floats(-500, 500),) * 3), angles)
def test_a_pose_times_its_inverse_is_no_displacement(irb4600, shift, angle):
    place = f"[[{', '.join(f'{x:.6f}' for x in shift)}], OrientZYX({angle}, 20, 10)]"
    body = "m := PoseMult(m, PoseInv(m)); WaitTime 1 + VectMagn(m.trans); WaitTime m.rot.q1;"
    found = waits(irb4600, body, f"VAR pose m := {place};")
    np.testing.assert_allclose(found, [1, 1], atol=1e-9)


FUNCTIONS = {
    "Abs(-2)": 2,
    "Sqrt(9)": 3,
    "Pow(2, 10)": 1024,
    "100 * Sin(30)": 50,
    "Tan(45)": 1,
    "ATan2(1, 1)": 45,
    "ACos(0.5)": 60,
    "Trunc(3.789 \\Dec:=2)": 3.78,
    "Round(2.5)": 3,
    "Round(3.14159 \\Dec:=3)": 3.142,
    "StrLen(NumToStr(3.14159, 2))": 4,
    'StrLen(ValToStr([1, 2.5, 3]) + "ab")': 11,
    'StrLen(StrPart("Robotics", 1, 5))': 5,
    "Distance([0, 3, 0], [4, 0, 0])": 5,
    "DotProd([1, 2, 3], [4, 5, 6])": 32,
    "VectMagn(ex * ey * 2 + ez * 3 - ez / 2)": 4.5,
    "Max(2, Min(5, 4))": 4,
}


@pytest.mark.parametrize(("expression", "value"), FUNCTIONS.items())
def test_functions_give_what_the_manual_says(irb4600, expression, value):
    axes = "CONST pos ex := [1, 0, 0]; CONST pos ey := [0, 1, 0]; CONST pos ez := [0, 0, 1];"
    (found,) = waits(irb4600, f"WaitTime {expression};", axes)
    assert found == pytest.approx(value)


@pytest.mark.parametrize("expression", ["Sqrt(-1)", "ACos(2)", "Pow(-1, 0.5)"])
def test_functions_without_a_value_are_one_error_with_its_place(irb4600, expression):
    with pytest.raises(FFGymError, match=r"^cut.mod:6:10: there is no value for \("):
        waits(irb4600, f"WaitTime {expression};")


WRONG_STATEMENTS = {
    "WaitTime a{0};": "index 0 is out of range, must be a whole number from 1 to 2",
    "WaitTime a{3};": "index 3 is out of range",
    "WaitTime a{1.5};": "index 1.5 is out of range",
    "a := b;": "num{2} is wanted here, this is num{3}",
    "FOR i FROM 1 TO 3 DO i := 2; ENDFOR": "i is the counter of a loop; use other data",
    "FOR i FROM 1 TO 3 STEP 0 DO WaitTime 1; ENDFOR": "STEP is 0, so the loop would never end",
}


@pytest.mark.parametrize(("body", "said"), WRONG_STATEMENTS.items())
def test_indices_sizes_and_counters_that_are_wrong_are_refused(irb4600, body, said):
    with pytest.raises(FFGymError, match=re.escape(said)):
        waits(irb4600, body, "VAR num a{2} := [1, 2]; VAR num b{3};")


WRONG_NUMBERS = {
    "Round(2.5 \\Dec:=400)": r"\Dec = 400.0 is out of range, must be in [0, 15]",
    "Trunc(2.5 \\Dec:=0.5)": r"\Dec = 0.5 must be a whole number",
    "StrLen(NumToStr(2, 1E9))": "Dec = 1000000000.0 is out of range, must be in [0, 15]",
    "Dim([1, 2], 1E30)": "dimension = 1e+30 is out of range, must be in [1, 3]",
    "Dim([1, 2], 2)": "the array has no dimension 2",
}


@pytest.mark.parametrize(("expression", "said"), WRONG_NUMBERS.items())
def test_functions_refuse_digits_and_dimensions_that_are_none(irb4600, expression, said):
    with pytest.raises(FFGymError, match=re.escape(said)):
        waits(irb4600, f"a := [1, 2]; WaitTime {expression.replace('[1, 2]', 'a')};", "VAR num a{2};")


def test_functions_know_where_the_last_move_led(irb4600, arm):
    joints = "[[10, 10, 15, 20, 35, -30], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]]"
    text = program(
        "MoveL Offs(CRobT(), 0, 0, 10), v10, fine, tRobot; MoveAbsJ j, v100, fine, tRobot;"
        "MoveL CRobT(), v10, fine, tRobot; MoveAbsJ CJointT(), v100, fine, tRobot;"
        "MoveAbsJ CalcJointT(CalcRobT(j, tRobot), tRobot), v100, fine, tRobot;",
        f"CONST jointtarget j := {joints};",
    )
    first, _, second, third, fourth = parse_program(text).execute(irb4600).moves[1:]
    np.testing.assert_allclose(first.to.position, [1.3, -0.2, 0.61], atol=1e-9)
    q = np.deg2rad([10, 10, 15, 20, 35, -30])
    position, rotation = (part[0] for part in arm.tcp_pose(q[None]))
    np.testing.assert_allclose(second.to.position, position, atol=1e-9)
    np.testing.assert_allclose(second.to.rotation, rotation, atol=1e-9)
    for move in (third, fourth):
        np.testing.assert_allclose(arm.tcp_position(move.to[None])[0], position, atol=1e-8)
