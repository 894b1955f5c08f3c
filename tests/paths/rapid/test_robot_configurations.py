"""robconf chooses the branch of a joint move where it can, and a note says where it cannot."""

from itertools import product

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ffgym.core.errors import FFGymError
from ffgym.paths.moves import MoveJoint, Pose
from ffgym.paths.rapid import on_branches, parse_program
from ffgym.robot import RigidArm, pose_solutions


def target(position, rotation, quarters):
    """A robtarget of the described tool as a program writes it."""
    x, y, z, w = Rotation.from_matrix(rotation).as_quat().round(12).tolist()
    place = (np.asarray(position) * 1e3).round(9).tolist()
    return f"[{place}, {[w, x, y, z]}, {[*quarters, 0]}, [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]]"


def joint_move(position, rotation, quarters):
    return f"MoveJ {target(position, rotation, quarters)}, v100, fine, tRobot;\n"


def settled(arm, body):
    """Moves on their branches, and notes."""
    execution = parse_program(f"PROC main()\n{body}ENDPROC", "cut.mod").execute(arm.robot)
    return on_branches(arm, execution)


@pytest.fixture(scope="module")
def p1(irb4600):
    """Position and orientation of a point of the work area."""
    return irb4600.position("p1"), irb4600.work_area.tool_rotation


def quarter_turns(q):
    return np.floor(q[[0, 3, 5]] / (np.pi / 2)).astype(int).tolist()


def test_every_solution_is_reached_by_its_own_quarter_turns(irb4600, arm, p1):
    solutions = pose_solutions(arm, *p1, irb4600.work_area.home)
    assert len({tuple(quarter_turns(q)) for q in solutions}) >= 8
    for q in solutions[::5]:
        same = [other for other in solutions if quarter_turns(other) == quarter_turns(q)]
        (move,), notes = settled(arm, joint_move(*p1, quarter_turns(q)))
        assert notes == ()
        assert isinstance(move, MoveJoint)
        assert min(np.abs(move.to - other).max() for other in same) < 1e-6


def test_quarter_turns_that_no_solution_has_leave_the_pose_and_a_note(arm, p1):
    (move,), notes = settled(arm, joint_move(*p1, [3, 0, 0]))
    assert isinstance(move.to, Pose)
    assert notes == ("cut.mod:2:1: no solution for target has robconf cf1, cf4, cf6 = 3, 0, 0; the nearest is taken",)


def test_conf_j_off_leaves_the_pose_without_a_note(arm, p1):
    body = "ConfJ \\Off;\n" + joint_move(*p1, [3, 0, 0]) + "ConfJ \\On;\n" + joint_move(*p1, [-1, 0, -1])
    (first, second), notes = settled(arm, body)
    assert isinstance(first.to, Pose)
    assert not isinstance(second.to, Pose)
    assert notes == ()


@pytest.mark.parametrize("quarters", list(product((0, -1), repeat=3)))
def test_axes_on_the_edge_between_two_quarters_have_both(irb4600, arm, quarters):
    """At home axes 1, 4 and 6 stand at 0 deg: rounding decides on which side, and a program may say either."""
    home = irb4600.work_area.home
    position, rotation = (part[0] for part in arm.tcp_pose(home[None]))
    (move,), notes = settled(arm, joint_move(position, rotation, quarters))
    assert notes == ()
    np.testing.assert_allclose(move.to, home, atol=1e-9)


def test_whole_turns_count(arm, p1):
    (near,), _ = settled(arm, joint_move(*p1, [-1, 0, -1]))
    (far,), _ = settled(arm, joint_move(*p1, [-1, 0, 3]))
    np.testing.assert_allclose(far.to - near.to, [0, 0, 0, 0, 0, 2 * np.pi], atol=1e-6)


def test_a_target_out_of_reach_is_one_error_with_its_place(arm, p1):
    with pytest.raises(FFGymError, match=r"^cut.mod:2:1: .*not reachable"):
        settled(arm, joint_move([9, 0, 0], p1[1], [0, 0, 0]))


def test_arms_that_have_not_six_hinges_take_the_nearest_branch(one_axis):
    external = "[9E9, 9E9, 9E9, 9E9, 9E9, 9E9]"
    text = f"PROC main() MoveAbsJ [[10, 0, 0, 0, 0, 0], {external}], v100, fine, tool0; ENDPROC"
    execution = parse_program(text).execute(one_axis)
    moves, notes = on_branches(RigidArm(one_axis), execution)
    assert moves is execution.moves
    assert notes == ()
