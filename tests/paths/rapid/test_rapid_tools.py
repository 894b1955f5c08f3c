"""A program's tool is held by the robot, and its targets are those of its TCP."""

import mujoco
import numpy as np
import pytest
from rapid_samples import TARGET, WORK_OBJECT

from ffgym.core.errors import FFGymError
from ffgym.paths.rapid import parse_program
from ffgym.robot import RigidArm, compile_model, solve_pose

SAME = "[TRUE, [[100, 0, 273.2], [0.9659258, 0, 0.2588190, 0]], [8, [45, 0, 122.9], [1, 0, 0, 0], 0.05, 0.05, 0.02]]"
PEN = "[TRUE, [[10, 20, 200], [1, 0, 0, 0]], [2, [0, 0, 60], [{}], {}]]"
THIRTY_ABOUT_Z = "0.965925826289, 0, 0, 0.258819045103"


def held(robot, tool, name="tA"):
    """Robot after a program that moves a tool."""
    text = f"PERS tooldata tA := {tool};\nPROC main()\nMoveJ {TARGET}, v100, fine, {name};\nENDPROC"
    return parse_program(text, "cut.mod").execute(robot).robot


def test_the_described_tool_leaves_the_robot_as_it_is_by_name_and_by_value(irb4600):
    assert held(irb4600, SAME) is irb4600
    assert held(irb4600, SAME, "tRobot") is irb4600


def test_another_tool_replaces_tcp_mass_and_inertia_and_nothing_else(irb4600):
    robot = held(irb4600, PEN.format("1, 0, 0, 0", "0.01, 0.02, 0.025"))
    np.testing.assert_allclose(robot.tool.tcp, [0.01, 0.02, 0.2])
    np.testing.assert_allclose(robot.tool.com, [0, 0, 0.06])
    np.testing.assert_allclose(robot.tool.inertia, [0.01, 0.02, 0.025, 0, 0, 0], atol=1e-15)
    assert robot.tool.mass == 2
    assert robot.tool.rotation is irb4600.tool.rotation
    assert robot.bodies is irb4600.bodies
    assert robot.quantities["tool.mass"].value == 2
    assert robot.quantities["tool.mass"].source == "tooldata in cut.mod:3:102"
    assert robot.quantities["links.mass"] is irb4600.quantities["links.mass"]
    assert {geom.body for geom in irb4600.geoms} - {geom.body for geom in robot.geoms} == {"tool"}
    assert mujoco.mj_getTotalmass(compile_model(robot)) == pytest.approx(
        mujoco.mj_getTotalmass(compile_model(irb4600)) - 6
    )


def test_moments_are_about_the_axes_that_aom_turns(irb4600):
    """A turn of 30 deg about z mixes xx and yy."""
    robot = held(irb4600, PEN.format(THIRTY_ABOUT_Z, "0.01, 0.02, 0.025"))
    cos2, sin2, product = 0.75, 0.25, np.sqrt(0.75) / 2
    mixed = [0.01 * cos2 + 0.02 * sin2, 0.01 * sin2 + 0.02 * cos2, 0.025, (0.01 - 0.02) * product, 0, 0]
    np.testing.assert_allclose(robot.tool.inertia, mixed, atol=1e-9)


def test_a_point_mass_is_a_small_ball(irb4600):
    robot = held(irb4600, PEN.format("1, 0, 0, 0", "0, 0, 0"))
    np.testing.assert_allclose(robot.tool.inertia, np.array([1, 1, 1, 0, 0, 0]) * 0.4 * 2 * 0.01**2)
    compile_model(robot)


def test_tool0_is_the_flange_and_weighs_nothing(irb4600):
    robot = held(irb4600, SAME, "tool0")
    assert robot.tool.mass == 0
    np.testing.assert_array_equal(robot.tool.tcp, 0)
    compile_model(robot)


def test_the_tcp_stands_on_the_target_and_turned_with_it_whatever_the_tool(irb4600):
    """Forward kinematics of the robot with its new tool, and the tool's own turn."""
    text = WORK_OBJECT.replace("[[0, 0, 200], [1, 0, 0, 0]]", "[[50, 0, 200], [0.965925826289, 0.258819045103, 0, 0]]")
    execution = parse_program(text).execute(irb4600)
    arm, to = RigidArm(execution.robot), execution.moves[0].to
    q = solve_pose(arm, to.position, to.rotation, irb4600.work_area.home)
    position, rotation = (part[0] for part in arm.tcp_pose(q[None]))
    np.testing.assert_allclose(position, [1.4, 0.01, 0.57], atol=1e-9)
    lean = np.deg2rad(30)
    tool = np.array([[1, 0, 0], [0, np.cos(lean), -np.sin(lean)], [0, np.sin(lean), np.cos(lean)]])
    np.testing.assert_allclose(rotation @ tool, np.diag([-1, 1, -1]), atol=1e-9)


def test_joint_moves_may_name_tool0_beside_another_tool(irb4600):
    joints = "MoveAbsJ [[0, 10, 15, 0, 35, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]], v100, fine, tool0;"
    move = f"MoveJ {TARGET}, v100, fine, tRobot;"
    assert parse_program(f"PROC main() {joints} {move} {joints} ENDPROC").execute(irb4600).robot is irb4600
    alone = parse_program(f"PROC main() {joints} ENDPROC").execute(irb4600)
    assert alone.robot.tool.mass == 0


@pytest.mark.parametrize(
    ("tool", "message"),
    [
        (SAME.replace("TRUE", "FALSE"), r"the tool stands still \(robhold is FALSE\)"),
        (PEN.format("1, 0, 0, 0", "0, 0, 0").replace("[2,", "[0,"), "tload has mass 0 kg"),
        (PEN.format("1, 0, 0, 0", "0, 0, 0").replace("[2,", "[-1,"), "tload has mass -1 kg"),
        (PEN.format("1, 0, 0, 0", "-1, 1, 1"), r"moments \[-1.0, 1.0, 1.0\] kg m\^2; mass must be > 0, moments >= 0"),
        (PEN.format("1, 0, 0, 0", "0.1, 0.1, 0.9"), "belongs to no body"),
        (PEN.format("2, 0, 0, 0", "0.1, 0.1, 0.1"), r"aom = \[2.0, 0.0, 0.0, 0.0\] has norm 2"),
    ],
)
def test_loads_that_belong_to_no_tool_are_refused(irb4600, tool, message):
    with pytest.raises(FFGymError, match=rf"^cut.mod:3:\d+: .*{message}"):
        held(irb4600, tool)


def test_a_robot_without_flange_holds_no_tool(one_axis):
    with pytest.raises(FFGymError, match="robot 'one_axis' has no flange to hold a tool"):
        held(one_axis, SAME)
