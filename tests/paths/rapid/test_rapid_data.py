"""Data change as assignments say, each procedure has its own, and each run starts from the declarations."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rapid_samples import moves, moves_of, program, told
from scipy.spatial.transform import Rotation

from ffgym.core.errors import FFGymError
from ffgym.paths.rapid import parse_program

GO = "MoveL {}, v10, fine, tRobot;"
millimetres = st.floats(-500, 500).map(lambda x: round(x, 3))
degrees = st.floats(-180, 180).map(lambda x: round(x, 3))


def target(robot, body, data=""):
    """Position of the last target, relative to p [mm]."""
    to = moves_of(robot, body, data)[-1].to
    return (to.position - [1.3, -0.2, 0.6]) * 1e3


@given(st.tuples(millimetres, millimetres, millimetres))
def test_offs_displaces_in_the_axes_of_the_world(irb4600, offset):
    x, y, z = offset
    np.testing.assert_allclose(target(irb4600, GO.format(f"Offs(p, {x}, {y}, {z})")), offset, atol=1e-9)


@given(st.tuples(millimetres, millimetres, millimetres), st.tuples(degrees, degrees, degrees))
def test_rel_tool_displaces_and_turns_in_the_axes_of_the_tool(irb4600, offset, angles):
    text = ", ".join(map(str, offset)) + "".join(f" \\R{axis}:={a}" for axis, a in zip("xyz", angles, strict=True))
    (move,) = moves_of(irb4600, GO.format(f"RelTool(p, {text})"))
    down = np.diag([-1.0, 1.0, -1.0])
    np.testing.assert_allclose((move.to.position - [1.3, -0.2, 0.6]) * 1e3, down @ offset, atol=1e-9)
    about = [Rotation.from_euler(axis, a, degrees=True).as_matrix() for axis, a in zip("xyz", angles, strict=True)]
    np.testing.assert_allclose(move.to.rotation, down @ about[0] @ about[1] @ about[2], atol=1e-12)


def test_components_change_alone(irb4600):
    body = "a := p; a.trans.y := a.trans.y + 5; a.rot := [1, 0, 0, 0]; " + GO.format("a")
    (move,) = moves_of(irb4600, body, "VAR robtarget a;")
    np.testing.assert_allclose(move.to.position, [1.3, -0.195, 0.6])
    np.testing.assert_array_equal(move.to.rotation, np.eye(3))


def test_a_value_is_copied_not_shared(irb4600):
    body = "a := p; b := a; b.trans.x := 0; " + GO.format("a")
    np.testing.assert_allclose(target(irb4600, body, "VAR robtarget a; PERS robtarget b := " + "a;"), 0, atol=1e-9)


def test_a_var_without_value_is_zero(irb4600):
    (wait,) = moves_of(irb4600, "WaitTime x + 1;", "VAR num x;")
    assert wait.duration == 1
    with pytest.raises(FFGymError, match=r"a.rot = \[0.0, 0.0, 0.0, 0.0\] has norm 0"):
        moves_of(irb4600, "a.extax := p.extax; " + GO.format("a"), "VAR robtarget a;")


def test_data_of_a_procedure_hide_those_of_the_module_and_begin_anew_with_every_call(irb4600):
    more = "PROC once()\n VAR num x := 1;\n x := x + 1;\n WaitTime x;\n y := y + x;\nENDPROC"
    waits = moves_of(irb4600, "once; once; WaitTime x; WaitTime y;", "VAR num x := 10; VAR num y := 0;", more)
    assert [wait.duration for wait in waits] == [2, 2, 10, 4]


def test_data_of_the_caller_are_unknown_to_the_called(irb4600):
    text = program("").replace("PROC main()\n", "PROC main()\nVAR num mine := 1;\n", 1)
    text = text.replace("ENDPROC", "once;\nENDPROC\nPROC once() WaitTime mine; ENDPROC", 1)
    with pytest.raises(FFGymError, match="mine is not declared"):
        moves(irb4600, text)


def test_a_declaration_hides_what_is_predefined(irb4600):
    (move,) = moves_of(irb4600, GO.format("p"), "CONST speeddata v10 := [11, 500, 5000, 1000];")
    assert told(move)[4] == 11


def test_every_run_starts_from_the_declarations(irb4600):
    text = parse_program(program("x := x + 1; WaitTime x;", "PERS num x := 1;"))
    first, second = (text.execute(irb4600).moves[-1].duration for _ in range(2))
    assert first == second == 2


def test_turning_speed_comes_from_v_ori(irb4600):
    (move,) = moves_of(irb4600, "MoveL p, [30, 90, 0, 0], fine, tRobot;")
    assert move.speed.turn == pytest.approx(np.pi / 2)
    assert move.speed.tcp == pytest.approx(0.03)


def test_quaternions_of_few_digits_are_normalised(irb4600):
    (move,) = moves_of(irb4600, "a := p; a.rot := [0.966, 0, 0.259, 0]; " + GO.format("a"), "VAR robtarget a;")
    np.testing.assert_allclose(move.to.rotation @ move.to.rotation.T, np.eye(3), atol=1e-14)
