"""What an arm's build rules out is said in one line: planes, fixed orientations, missing motions, units of joints."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ffgym.paths import cartesian_reference, circle_test
from ffgym.robot import RigidArm, pose_solutions, solve_path, solve_pose
from tests.robot.arm_samples import ARMS, make_arm
from tests.robot.inverse_kinematics.refusals import refused
from tests.robot.tool_motions import joint_motion, tool_path

X, Y, Z = np.eye(3)
TILT = Rotation.from_euler("x", 10, degrees=True).as_matrix()


@pytest.fixture
def at_home():
    """Function that returns an arm, its home and the pose of its tool there."""

    def build(name):
        arm = RigidArm(ARMS[name]())
        home = arm.robot.work_area.home
        position, rotation = arm.tcp_pose(home[None])
        return arm, home, position[0], rotation[0]

    return build


def line(start, along, count=50):
    return start + np.linspace(0, 1, count)[:, None] * np.asarray(along)


def test_a_path_that_leaves_the_plane_of_a_planar_arm_names_the_plane_and_the_miss(at_home):
    arm, home, position, _ = at_home("two_link")
    refused(r"The TCP of 'two_link' moves in the plane with normal \(0, 1, 0\) through .* leave it by 0\.003 m for "
            r"sample 49", lambda: solve_path(arm, line(position, [0.0, 0.003, 0.0]), None, home))  # fmt: skip
    refused("plane", lambda: solve_pose(arm, position + 0.001 * Y, None, home))
    refused("plane", lambda: pose_solutions(arm, position + 0.001 * Y, None, home))
    solve_path(arm, line(position, [0.0, 3e-6, 0.0]), None, home)  # as far as numbers are rounded


def test_a_path_off_the_line_of_a_single_slide_names_the_line(at_home):
    screw = RigidArm(make_arm("screw", "P", [Z], [X], home=[0.0]))
    refused(r"moves along the line with direction \(1, 0, 0\)",
            lambda: solve_pose(screw, [0.1, 0.01, 1.1], None, np.zeros(1)))  # fmt: skip
    np.testing.assert_allclose(solve_pose(screw, [0.1, 0.0, 1.1], None, np.zeros(1)), [0.1])


def test_an_orientation_that_the_tool_cannot_have_is_named_with_its_angle(at_home):
    arm, home, position, rotation = at_home("scara")
    tilted = TILT @ rotation
    refused(r"'scara' turns its tool about \(0, 0, 1\) only; the orientation of sample 0 is 10 deg away",
            lambda: solve_pose(arm, position, tilted, home))  # fmt: skip
    tilting = np.stack([rotation, rotation, tilted])
    refused("orientation of sample 2 is 10 deg", lambda: solve_path(arm, np.tile(position, (3, 1)), tilting, home))
    arm, home, position, rotation = at_home("gantry")
    refused("'gantry' does not turn its tool; .* 10 deg away",
            lambda: solve_pose(arm, position, TILT @ rotation, home))  # fmt: skip
    solve_pose(arm, position, rotation, home)


def test_a_pose_that_five_axes_miss_tells_how_many_motions_they_have(at_home):
    arm, home, position, rotation = at_home("five_axis")
    path = line(position, [0, 0.1, 0])
    refused(r"is not reachable with the given tool orientation by 'five_axis': .* misses it by .* m and .* deg\. The "
            r"arm has 5 of the 6 motions", lambda: solve_path(arm, path, rotation, home))  # fmt: skip
    solve_path(arm, path, None, home)


def test_slides_are_refused_in_metres(at_home):
    arm, home, position, rotation = at_home("scara")
    refused(r"Joint j3 would be at 1\.0\d\d\d m at sample \d+, must be within \[-1\.0000, 1\.0000\] m",
            lambda: solve_path(arm, line(position, [0, 0, -1.2], 400), rotation, home))  # fmt: skip
    refused(r"joint j3 would move 0\.5\d m in one sample",
            lambda: solve_path(arm, line(position, [0, 0, -0.52], 2), rotation, home))  # fmt: skip
    refused(r"j3 moves at .* m/s at .* must stay below 0\.100 m/s", lambda: slow(arm, path_of(arm)))
    refused(r"j3 is at .* m at .* must be within \[0\.0, 0\.11\] m", lambda: narrow(arm, path_of(arm)))


def path_of(arm):
    return tool_path(arm, joint_motion(arm.robot.work_area.home), turning=True)


def slow(arm, path):
    speed = np.array([3.0, 3.0, 0.1, 3.0])
    robot = replace(arm.robot, kinematics=replace(arm.robot.kinematics, max_speed=speed))
    return cartesian_reference(RigidArm(robot), path)


def narrow(arm, path):
    """The reference itself is checked too, where it is built by hand."""
    reference = cartesian_reference(arm, path)
    limits = arm.robot.kinematics.range.copy()
    limits[2] = [0.0, 0.11]
    return replace(reference, robot=replace(arm.robot, kinematics=replace(arm.robot.kinematics, range=limits)))


def test_a_point_beyond_reach_says_how_near_the_arm_comes(at_home):
    arm, home, *_ = at_home("two_link")
    refused(r"\(2\.0000, 0\.0000, 1\.0000\) m is not reachable by 'two_link': the nearest position found misses it by "
            r"1\.1 m", lambda: solve_pose(arm, [2.0, 0.0, 1.0], None, home))  # fmt: skip
    gantry, home, *_ = at_home("gantry")
    refused("reachable only beyond the joint limits", lambda: solve_pose(gantry, [5.0, 0.0, 1.0], None, home))


def test_the_end_of_reach_is_a_singularity_for_every_arm(at_home):
    for name, reach in (("two_link", [0.8999999, 0, 1.0]), ("three_link", [1.1999999, 0, 1.0])):
        arm = at_home(name)[0]
        refused("too near a singularity", lambda arm=arm, reach=reach: solve_path(
            arm, np.array([reach]), None, np.full(arm.robot.n_joints, 0.01)))  # fmt: skip


@pytest.mark.parametrize("turning", [True, False])
def test_an_arm_that_has_to_jump_is_refused_whatever_its_axes(at_home, turning):
    arm, home, position, rotation = at_home("seven_axis")
    far = line(position, [0.0, 0.35, -0.1], 2)
    refused(r"jumps at sample 1: joint j\d would move \d\.\d\d rad",
            lambda: solve_path(arm, far, rotation if turning else None, home))  # fmt: skip


def test_rotations_must_fit_their_positions(at_home):
    arm, home, position, rotation = at_home("ur_like")
    points = line(position, [0.01, 0, 0])
    refused(r"rotation has shape \(49, 3, 3\), must be \(50, 3, 3\)",
            lambda: solve_path(arm, points, np.stack([rotation] * 49), home))  # fmt: skip
    broken = np.stack([rotation] * 50)
    broken[7, 0] *= 1.1
    refused(r"rotation\[7\] = .* is not a rotation matrix", lambda: solve_path(arm, points, broken, home))


def test_a_turning_path_leaves_no_room_for_another_orientation(at_home):
    arm, _, _, rotation = at_home("ur_like")
    path = path_of(arm)
    refused("says how the tool turns; rotation must be None", lambda: cartesian_reference(arm, path, rotation))


def test_an_arm_without_work_area_takes_a_seed(at_home):
    arm, home, *_ = at_home("scara")
    bare, path = RigidArm(replace(arm.robot, work_area=None)), path_of(arm)
    refused("has no work area; give its motions in joint space, or a seed", lambda: cartesian_reference(bare, path))
    seeded = cartesian_reference(bare, path, seed=home)
    np.testing.assert_array_equal(seeded.q, cartesian_reference(arm, path).q)


def test_without_a_wanted_orientation_it_is_free(at_home):
    arm, home, position, rotation = at_home("two_link")
    path = circle_test(position, 0.1, radii=(0.01,), normal=Y)
    reference = cartesian_reference(arm, path)
    np.testing.assert_allclose(arm.tcp_position(reference.q), path.position, rtol=0, atol=1e-9)
    np.testing.assert_allclose(reference.q[[0, -1]], [home, home], atol=1e-8)
    refused("not reachable with the given tool orientation", lambda: cartesian_reference(arm, path, rotation))
