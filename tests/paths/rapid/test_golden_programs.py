"""Realistic programs give the moves that a reader of RAPID expects."""

from importlib import resources

import numpy as np
import pytest
from rapid_samples import ARITHMETIC, EXPORTED, JOINTS, WORK_OBJECT, moves, moves_of, told

from ffgym.paths.moves import MoveArc, Pose
from ffgym.paths.rapid import parse_program


def test_an_exported_program(irb4600):
    assert [told(move) for move in moves(irb4600, EXPORTED)] == [
        ("MoveJoint", "Target_10", [1300, -200, 600], None, 1000, 0),
        ("MoveLinear", "Target_20", [1320, -200, 600], None, 10, 10),
        ("MoveLinear", "Target_30", [1320, -180, 600], None, 10, 0),
    ]


def test_own_data_and_arithmetic(irb4600):
    assert [told(move) for move in moves(irb4600, ARITHMETIC)] == [
        ("MoveJoint", "p", [1325, -187.5, 590], None, 100, 0),
        ("MoveLinear", "p", [1325, -187.5, 600], None, 10, 5),
        ("MoveArc", "offs(p, 0, 50, 0)", [1325, -137.5, 600], [1300, -200, 590], 7, 3),
        ("MoveLinear", "offs(p, 0, 50, 5)", [1325, -137.5, 605], None, 10, 1),
        ("MoveLinear", "p", [1300, -200, 600], None, 7000, 0),
        ("Wait", 0.25),
    ]


def test_joint_space(irb4600):
    out = np.deg2rad([[0, 10, 15, 0, 35, 0], [5, 10, 15, 0, 35, 0], [10, 10, 15, -20, 35, 90]]).round(6)
    assert [told(move) for move in moves(irb4600, JOINTS)] == [
        ("MoveJoint", "jHome", list(out[0]), None, 1000, 0),
        ("MoveJoint", "target", list(out[1]), None, 200, 50),
        ("MoveJoint", "jOut", list(out[2]), None, 200, 0),
    ]


def test_a_work_object_that_is_turned_by_a_quarter(irb4600):
    """Its x is the world's y, its y the world's -x."""
    side = [
        ("MoveLinear", "Offs(pCorner, 10, 0, 0)", [1400, 10, 520], None, 50, 0),
        ("MoveLinear", "Offs(pCorner, 10, 30, 0)", [1370, 10, 520], None, 50, 1),
    ]
    assert [told(move) for move in moves(irb4600, WORK_OBJECT)] == [
        ("MoveJoint", "Offs(pCorner, 10, 0, 50)", [1400, 10, 570], None, 100, 0),
        *side,
        *side,
    ]


def test_targets_turn_with_the_work_object_and_the_flange_with_the_tool(irb4600):
    """pCorner turns z down and x along y of the plate, which is -x of the world; the nozzle leans 30 deg."""
    turned = moves(irb4600, WORK_OBJECT)[0].to
    np.testing.assert_allclose(turned.rotation, np.diag([-1, 1, -1]), atol=1e-9)
    leaning = moves(irb4600, EXPORTED)[0].to
    np.testing.assert_allclose(leaning.rotation, irb4600.work_area.tool_rotation, atol=1e-9)


def test_each_move_says_where_it_stands(irb4600):
    assert [move.where for move in moves(irb4600, EXPORTED)] == ["cut.mod:17:9", "cut.mod:18:9", "cut.mod:19:9"]
    assert [move.where for move in moves(irb4600, WORK_OBJECT)][1:] == ["cut.mod:13:5", "cut.mod:14:5"] * 2


@pytest.mark.parametrize("name", ["thesis_circles", "cut_bracket"])
def test_shipped_examples_hold_the_tool_of_the_built_in_robot_down_on_one_plane(irb4600, name):
    text = (resources.files("ffgym.paths.rapid") / "examples" / f"{name}.mod").read_text(encoding="utf-8")
    execution = parse_program(text).execute(irb4600)
    assert execution.robot is irb4600
    cartesian = [move for move in execution.moves if isinstance(getattr(move, "to", None), Pose)]
    for move in cartesian:
        np.testing.assert_allclose(move.to.rotation, irb4600.work_area.tool_rotation, atol=1e-9)
    heights = [move.to.position[2] for move in cartesian if isinstance(move, MoveArc)]
    assert len(heights) >= 5
    np.testing.assert_allclose(heights, heights[0], atol=1e-12)


def test_displaced_targets_are_called_by_the_numbers_that_they_are_displaced_by(irb4600):
    data = "CONST num deep := 20;"
    body = r"MoveL RelTool(Offs(p, 5 - 7.5, deep / 2, 0), 0, -0.0, -deep\Rx:=5\rz:=-deep), v100, fine, tRobot;"
    (move,) = moves_of(irb4600, body, data)
    assert move.label == r"RelTool(Offs(p, -2.5, 10, 0), 0, 0, -20\Rx:=5\rz:=-20)"
