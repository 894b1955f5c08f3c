"""Whatever is wrong or unsupported is one error that begins with file, line and column."""

import pytest
from rapid_samples import TARGET, moves, moves_of, program

from ffgym.core.errors import FFGymError
from ffgym.paths.rapid.tokens import MAX_NESTING

LINE = "MoveL {}, v10, fine, tRobot;"
BAD_TARGET = "[[1300, -200, 600], {}, [0, 0, 0, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]]"

STATEMENTS = {
    # what is not run
    "PDispOn p, tRobot;": "6:1: PDispOn is not supported, and no procedure of this program. Comment it out",
    "MoveL p, v10\\T:=5, fine, tRobot;": r"6:13: \T is not supported with MoveL. Available: \v, \z",
    "MoveL p{1}, v10, fine, tRobot;": "6:7: p has 0 dimensions, got 1 indices",
    "a" * 33 + ";": "6:1: 'aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa' is too long, names have 32 characters",
    "a" * 32 + ";": "6:1: aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa is not supported",
    "MoveL *, v10, fine, tRobot;": "6:7: unexpected '*'; expected",
    "MoveL CRobT(p), v10, fine, tRobot;": "6:7: the arguments of CRobT are (), got 1 of 0",
    "MoveL Near(p), v10, fine, tRobot;": "6:7: function Near is not supported, and none of this program",
    "ConfL \\Far;": r"6:7: \Far is not supported with ConfL. Available: \on, \off",
    "ConfJ;": r"6:1: ConfJ wants one switch, ConfJ \On or \Off",
    "ConfJ \\On:=1;": r"6:7: \On takes no value",
    "VelSet 0, 500;": "6:1: VelSet 0, 500 must be in (0, 100] % and > 0 mm/s",
    "RAISE;": "6:1: the program comes to RAISE, an error of its own",
    # grammar
    "MoveL p, v10, fine, tRobot": "7:1: unexpected 'ENDPROC'; expected",
    "MoveL p v10;": "6:9: unexpected 'v10'; expected ',', ';' or '\\'.",
    "MoveL p,, v10;": r"6:9: unexpected ','; expected '\', NOT or a value",
    "p1 = 3;": "6:4: unexpected character '=': ':=' assigns, '=' compares",
    'WaitTime "open;': "6:10: unexpected character '\"': text must end on the line",
    "<SMT>": "6:1: unexpected character '<': placeholders such as <SMT> are no program",
    "\u2264;": "6:1: unexpected character '\u2264': it begins nothing in RAPID",
    "IF TRUE THEN": "7:1: unexpected 'ENDPROC'; expected ELSE, ELSEIF, ENDIF or a statement.",
    "FOR i FROM 1 DO ENDFOR": "6:14: unexpected 'DO'; expected TO.",
    "GOTO nowhere;": "6:1: label nowhere is not in sight; it must stand in a block around GOTO",
    "again: again: WaitTime 1;": "6:8: label again is declared twice",
    # arguments
    "MoveL p, v10, fine;": r"6:1: the arguments of MoveL are (target, speed, zone, tool), got 3 of 4",
    "MoveC p, v10, fine, tRobot;": "6:1: the arguments of MoveC are (point on the arc, target, speed, zone, tool)",
    "MoveL p, v10, fine, tRobot, wobj0;": "6:1: the arguments of MoveL are (target, speed, zone, tool), got 5 of 4",
    "MoveL p, v10, fine, tRobot\\WObj;": r"6:27: \WObj needs a value",
    "MoveL p, v10, fine, tRobot\\WObj:=wobj0\\WObj:=wobj0;": r"6:39: \WObj is given twice",
    "MoveAbsJ p\\NoEOffs:=1, v10, fine, tRobot;": r"6:11: \NoEOffs takes no value",
    "MoveAbsJ \\NoEOffs, v10, fine, tRobot;": "6:1: the arguments of MoveAbsJ are (target, speed, zone, tool), got",
    "MoveL Offs(p, 1, 2), v10, fine, tRobot;": "6:7: the arguments of Offs are (target, XOffset, YOffset, ZOffset)",
    "main;": "6:1: main calls itself more than 40 deep, it must come to an end",
    "side 5;": "6:1: the arguments of side are (), got 1 of 0",
    "x := side();": "6:1: x is not declared",
    "WaitTime side();": "6:10: side is a PROC, which has no value",
    "RETURN 1;": "6:1: PROC main returns no value",
    "WaitTime;": "6:1: the arguments of WaitTime are (time), got 0 of 1",
    # names, types and values
    "MoveL q, v10, fine, tRobot;": "6:7: q is not declared; declare it in this module or another one",
    "MoveL p, v11, fine, tRobot;": "6:10: v11 is not declared",
    "MoveL p, z10, fine, tRobot;": "6:10: speeddata is wanted here, this is zonedata",
    "MoveAbsJ p, v10, fine, tRobot;": "6:10: jointtarget is wanted here, this is robtarget",
    "MoveL p.trans, v10, fine, tRobot;": "6:7: robtarget is wanted here, this is pos",
    "MoveL p.trans.w, v10, fine, tRobot;": "6:7: pos has no component w, it is [x, y, z]",
    "MoveL p, 10, fine, tRobot;": "6:10: speeddata is wanted here, this is num",
    "WaitTime [1];": "6:10: num is wanted here, this is an aggregate",
    'WaitTime "1";': "6:10: num is wanted here, this is string",
    "WaitTime 1 + TRUE;": "6:14: num is wanted here, this is bool",
    "WaitTime 1 / (2 - 2);": "6:15: division by zero",
    "WaitTime 1E999;": "6:10: inf is too large, numbers go to 1e+38",
    "WaitTime 1E30 * 1E30;": "6:17: 1e+60 is too large",
    "WaitTime -1;": "6:1: WaitTime -1 s must be >= 0",
    "p.trans.x := 5;": "6:1: p is constant; declare it as VAR or PERS",
    "v10.v_tcp := 5;": "6:1: v10 is constant",
    "x := 5;": "6:1: x is not declared",
    # moves
    "MoveL p, [0, 500, 5000, 1000], fine, tRobot;": "6:1: speed = 0.0 m/s is out of range",
    "MoveL p, v10\\V:=-5, fine, tRobot;": "6:1: speed = -0.005 m/s is out of range",
    "MoveL p, v10, [FALSE, 0, 0, 0, 0, 0, 0], tRobot;": "6:1: a fly-by point needs a zone > 0 mm, got 0",
    "MoveL p, v10, fine, tool0;": "6:21: this tool is not the one of cut.mod:5:22; a program moves with one tool",
    LINE.format(BAD_TARGET.format("[1, 0, 0]")): "6:27: orient has 4 components, [q1, q2, q3, q4], got 3",
    LINE.format(BAD_TARGET.format("[1, 1, 0, 0]")): "6:1: target.rot = [1.0, 1.0, 0.0, 0.0] has norm 1.41421",
    LINE.format(BAD_TARGET.format("[0, 0, 0, 0]")): "6:1: target.rot = [0.0, 0.0, 0.0, 0.0] has norm 0",
    LINE.format(TARGET.replace("9E9]", "100]")): "6:1: target uses external axes (eax_f), which are not supported",
    "MoveJ " + TARGET.replace("[-1,", "[0.5,") + ", v10, fine, tRobot;": "6:1: robconf of target = 0.5 must be a whole",
}


@pytest.mark.parametrize(("statement", "message"), STATEMENTS.items())
def test_a_wrong_statement_is_one_error_with_its_place(irb4600, statement, message):
    with pytest.raises(FFGymError) as caught:
        moves_of(irb4600, statement, more="PROC side() ENDPROC")
    assert str(caught.value).startswith(f"cut.mod:{message}")


DATA = {
    "VAR num x;\nVAR num X;": "3:9: X is declared twice, first at cut.mod:2:9",
    "VAR num main;": "4:6: main is declared twice, first at cut.mod:2:9",
    "CONST num x;": "2:11: CONST x needs a value",
    "PERS tooldata tA;": "2:15: PERS tA needs a value",
    "CONST num a := b;\nCONST num b := a;": "2:11: the value of a depends on itself",
    "CONST num a := c;": "2:16: c is not declared",
    "CONST num a := [1, 2];": "2:16: num is wanted here, this is an aggregate",
    "CONST pos a := [1, 2];": "2:16: pos has 3 components, [x, y, z], got 2",
    "CONST pos a := [1, 2, [3]];": "2:23: num is wanted here, this is an aggregate",
    "CONST pos a := [1, TRUE, 3];": "2:20: num is wanted here, this is bool",
    "CONST zonedata z := [0, 1, 1, 1, 1, 1, 1];": "2:22: bool is wanted here, this is num",
    "CONST num a{2} := [1, 2, 3];": "2:19: num{2} has 2 elements, got 3",
    "CONST num a{2, 2} := [1, [1, 2]];": "2:23: num{2} is wanted here, this is num",
    "VAR num a{0};": "2:11: size 0 of an array must be a whole number >= 1",
    "VAR num n := 3; VAR num a{n};": "2:27: the size of an array must be a constant",
    "VAR num a{100, 100, 100};": "2:9: a has 3 dimensions and 1000000 elements",
    "RECORD r r a; ENDRECORD VAR r x;": "2:8: record r contains itself",
    "RECORD r": "3:1: unexpected 'CONST'; expected ENDRECORD or a name",
    "PROC cut(num depth, num depth) ENDPROC PROC go() cut 1, 2; ENDPROC": "2:25: depth is declared twice",
    "PROC waittime() ENDPROC": "2:6: waittime is an instruction of RAPID; choose another name",
    "CONST num FOR := 1;": "2:11: unexpected 'FOR'; expected a name",
    "CONST num x := 1": "3:1: unexpected 'CONST'; expected",
    "ENDMODULE": "3:1: unexpected 'CONST'; expected MODULE or the end of the file",
}


@pytest.mark.parametrize(("data", "message"), DATA.items())
def test_a_wrong_declaration_is_one_error_with_its_place(irb4600, data, message):
    text = program("").replace("\n\n", f"\n{data}\n", 1)
    with pytest.raises(FFGymError) as caught:
        moves(irb4600, text, "go" if "go()" in data else None)
    assert str(caught.value).startswith(f"cut.mod:{message}")


@pytest.mark.parametrize(
    ("text", "message"),
    {
        "MODULE m": "1:9: the program ends too early; expected '(', ALIAS, CONST, ENDMODULE",
        "PROC main()\nMoveL p": "2:8: the program ends too early; expected",
        "PROC main() PERS num x := 1; ENDPROC": "1:22: x is PERS in a routine",
        "PROC main() VAR num x; VAR num x; ENDPROC": "1:32: x is declared twice",
        "PROC main() WaitTime 1; ENDPROC": "1:6: the program makes no move",
        f"PROC main() MoveC {TARGET}, {TARGET}, v10, fine, tRobot; ENDPROC": "1:13: the first move is MoveC",
        "5": "1:1: unexpected '5'; expected",
        "\x00": "1:1: unexpected character '\\x00'",
        "x" * 1000: "1:1: 'xxxx",
        "1" * 1000: "1:1: unexpected '1111",
    }.items(),
)
def test_a_wrong_program_is_one_error_with_its_place(irb4600, text, message):
    with pytest.raises(FFGymError) as caught:
        moves(irb4600, text)
    assert str(caught.value).startswith(f"cut.mod:{message}")
    assert len(str(caught.value)) < 400


@pytest.mark.parametrize("brackets", ["()", "[]"])
def test_nesting_is_bounded(irb4600, brackets):
    left, right = brackets
    deep = left * (MAX_NESTING + 1) + "1" + right * (MAX_NESTING + 1)
    with pytest.raises(FFGymError, match=rf"^cut.mod:6:{10 + MAX_NESTING}: brackets or blocks are nested deeper than"):
        moves_of(irb4600, f"WaitTime {deep};")
    with pytest.raises(FFGymError, match="nested deeper"):
        moves_of(irb4600, "WaitTime " + left * 100_000)
    blocks = "IF TRUE THEN " * (MAX_NESTING + 1) + "ENDIF " * (MAX_NESTING + 1)
    with pytest.raises(FFGymError, match="blocks are nested deeper"):
        moves_of(irb4600, blocks)


def test_nesting_up_to_the_bound_is_run(irb4600):
    (wait,) = moves_of(irb4600, f"WaitTime {'(' * MAX_NESTING}1{')' * MAX_NESTING};")
    assert wait.duration == 1
    branches = "IF FALSE THEN ELSEIF TRUE THEN " * (MAX_NESTING - 1) + "WaitTime 2;" + " ENDIF" * (MAX_NESTING - 1)
    (wait,) = moves_of(irb4600, branches)
    assert wait.duration == 2


def test_a_long_sum_is_not_deep(irb4600):
    (wait,) = moves_of(irb4600, "WaitTime " + "1+" * 20_000 + "1;")
    assert wait.duration == 20_001


def test_routines_that_call_each_other_too_deep_or_too_often_come_to_an_end(irb4600, monkeypatch):
    circle = "PROC a() b; ENDPROC PROC b() a; ENDPROC"
    with pytest.raises(FFGymError, match=r"^cut.mod:8:\d+: . calls itself more than 40 deep"):
        moves_of(irb4600, "a;", more=circle)
    monkeypatch.setattr("ffgym.paths.rapid.controller.MAX_STATEMENTS", 1000)
    doubling = "".join(f"PROC d{i}() d{i + 1}; d{i + 1}; ENDPROC\n" for i in range(30)) + "PROC d30() ENDPROC"
    with pytest.raises(FFGymError, match="the program repeats more than 1000 statements, and makes 1 moves"):
        moves_of(irb4600, "d0;", more=doubling)
    with pytest.raises(FFGymError, match="the program repeats more than 1000 statements"):
        moves_of(irb4600, "WHILE TRUE DO x := x + 1; IF x < 0 RETURN; ENDWHILE", "VAR num x;")


def test_a_long_program_without_loops_is_run(irb4600, monkeypatch):
    monkeypatch.setattr("ffgym.paths.rapid.controller.MAX_STATEMENTS", 10)
    moves = moves_of(irb4600, "WaitTime 1; " * 100)
    assert len(moves) == 100


def test_a_program_is_run_no_further_after_many_errors(irb4600):
    far = "FOR i FROM 1 TO 20000 DO MoveJ Offs(p, 9E9 * i, 0, 0), v10, fine, tRobot; ENDFOR"
    with pytest.raises(FFGymError, match="run no further after 1000 errors") as told:
        moves_of(irb4600, far)
    assert len(str(told.value).splitlines()) < 40


def test_a_recursion_that_ends_is_run(irb4600):
    more = "FUNC num sum(num n) IF n <= 0 RETURN 0; RETURN n + sum(n - 1); ENDFUNC"
    (wait,) = moves_of(irb4600, "WaitTime sum(20);", more=more)
    assert wait.duration == 210


@pytest.mark.parametrize(
    ("work_object", "message"),
    [
        ('[TRUE, TRUE, "", [[0,0,0],[1,0,0,0]], [[0,0,0],[1,0,0,0]]]', "the work object moves"),
        ('[FALSE, FALSE, "", [[0,0,0],[1,0,0,0]], [[0,0,0],[1,0,0,0]]]', "the work object moves"),
        ('[FALSE, TRUE, "STN1", [[0,0,0],[1,0,0,0]], [[0,0,0],[1,0,0,0]]]', "the work object moves"),
        (
            '[FALSE, TRUE, "", [[0,0,0],[1,0,0,0]], [[0,0,0],[2,0,0,0]]]',
            r"oframe.rot = \[2.0, 0.0, 0.0, 0.0\] has norm 2",
        ),
    ],
)
def test_work_objects_that_move_or_are_none_are_refused(irb4600, work_object, message):
    with pytest.raises(FFGymError, match=rf"^cut.mod:6:1: {message}"):
        moves_of(irb4600, "MoveL p, v10, fine, tRobot\\WObj:=w;", f"PERS wobjdata w := {work_object};")


def test_joints_that_the_robot_lacks_must_not_be_asked_for(one_axis, irb4600):
    external = "[9E9, 9E9, 9E9, 9E9, 9E9, 9E9]"
    text = f"PROC main() MoveAbsJ [[10, {{}}, 0, 0, 9E9, 0], {external}], v100, fine, tool0; ENDPROC"
    (move,) = moves(one_axis, text.format(0))
    assert move.to.tolist() == pytest.approx([0.17453292519943295])
    with pytest.raises(FFGymError, match=r"^cut.mod:1:13: target moves 6 joints, the robot has 1; write 0 or 9E9"):
        moves(one_axis, text.format(5))
    assert len(moves(irb4600, text.format(5).replace("0, 9E9, 0]", "0, 1, 0]"))) == 1


def test_lark_is_named_where_it_is_missing(monkeypatch):
    import sys

    from ffgym.paths.rapid import parse_program

    monkeypatch.delitem(sys.modules, "ffgym.paths.rapid.reader", raising=False)
    monkeypatch.setitem(sys.modules, "lark", None)
    with pytest.raises(FFGymError, match=r"RAPID programs need lark; pip install 'ffgym\[paths\]'"):
        parse_program("")
