"""A motion that the robot cannot make is refused in one line that says what is wrong and where."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.paths import Reference, cartesian_reference, circle_test, constant_velocity, joint_reference, joint_sine
from ffgym.robot import RigidArm, solve_path
from tests.robot.inverse_kinematics.refusals import refused


def leaning(degrees):
    """Orientation of tool0 with the flange axis forward and so many degrees below the horizontal."""
    dip = np.radians(degrees)
    z, y = np.array([np.cos(dip), 0, -np.sin(dip)]), np.array([0.0, 1, 0])
    return np.stack([np.cross(y, z), y, z], axis=1)


def circle(arm, centre, speed=0.1, radius=0.2, rotation=None, **changes):
    return cartesian_reference(arm, circle_test(centre, speed, radii=(radius,), dt=0.004, **changes), rotation)


def test_a_point_out_of_reach_is_named(arm):
    refused(r"\(3\.5000, 0\.0000, 0\.6000\) m \(sample 0\) is not reachable", lambda: circle(arm, (3.5, 0, 0.6)))


def test_a_circle_that_leaves_the_reach_names_the_sample_and_the_point(arm):
    refused(r"\(2\.\d+, .*\) m \(sample [1-9]\d*\) is not reachable", lambda: circle(arm, (1.95, 0, 0.6), 0.3))


@pytest.mark.parametrize("point", [(0.1, 0, 0.3), (0.0, 0, 0.0), (0, 0, 0.5)])
def test_a_point_inside_the_base_is_refused(arm, point):
    refused(r"beyond the joint limits|not reachable", lambda: circle(arm, point))


def test_a_path_beyond_a_joint_limit_names_joint_angle_and_range(irb4600):
    limits = irb4600.kinematics.range.copy()
    limits[0] = [-0.1, 0.1]
    arm = RigidArm(replace(irb4600, kinematics=replace(irb4600.kinematics, range=limits)))
    refused(r"Joint j1 would be at -?5\.\d deg at sample \d+, must be within \[-5\.7, 5\.7\] deg",
            lambda: circle(arm, (1.5, 0, 0.6)))  # fmt: skip


def test_a_stretched_wrist_is_a_singularity(arm):
    upright = {"radius": 0.1, "rotation": leaning(24.26), "normal": (0, 1, 0)}
    refused(r"singularity at sample \d+: Jacobian condition \d+, must be below 1000",
            lambda: circle(arm, (1.5, 0, 0.9), 0.3, **upright))  # fmt: skip


def test_a_wrist_that_has_to_flip_is_refused(arm):
    refused(r"jumps at sample \d+: joint j[46] would move 0\.3\d rad",
            lambda: circle(arm, (1.5, 0.0, 0.9), 0.1, 0.02, leaning(24.26)))  # fmt: skip


@pytest.mark.parametrize("speed", [3.0, 5.0])
def test_a_path_that_is_too_fast_names_joint_speed_and_limit(arm, speed):
    refused(r"joint j3 moves at -?\d\.\d+ rad/s at \d\.\d+ s, must stay below 3\.054 rad/s",
            lambda: circle(arm, (1.5, 0, 0.6), speed))  # fmt: skip


def test_the_fastest_circle_within_the_limits_is_accepted_and_a_faster_one_is_not(arm):
    slow = circle(arm, (1.5, 0, 0.6), 1.0)
    share = np.max(np.abs(slow.dq) / arm.robot.kinematics.max_speed)
    circle(arm, (1.5, 0, 0.6), 0.98 / share)
    refused("Slow the motion down", lambda: circle(arm, (1.5, 0, 0.6), 1.05 / share))


def test_a_tool_upside_down_is_no_solution(arm):
    """Half a turn from the seed has no sine: it must not look like no turn at all."""
    home = arm.robot.work_area.home
    position, rotation = arm.tcp_pose(home[None])
    refused("joint limits|not reachable", lambda: solve_path(arm, position, rotation[0] @ np.diag([-1, 1, -1]), home))


@pytest.mark.parametrize(
    "rotation", [2 * np.eye(3), -np.eye(3), np.ones((3, 3)), np.eye(2), np.full((3, 3), np.nan), "up"]
)
def test_what_is_no_rotation_is_refused(arm, rotation):
    refused("rotation", lambda: circle(arm, (1.5, 0, 0.6), rotation=rotation))


@pytest.mark.parametrize("positions", [np.zeros((0, 3)), np.zeros(3), np.full((4, 3), np.nan)])
def test_positions_of_the_wrong_shape_are_refused(arm, positions):
    refused("positions", lambda: solve_path(arm, positions, np.eye(3), np.zeros(6)))


@pytest.mark.parametrize("seed", [np.zeros(5), [np.nan] * 6])
def test_a_bad_seed_is_refused(arm, seed):
    refused("seed", lambda: solve_path(arm, np.ones((1, 3)), np.eye(3), seed))


@pytest.mark.parametrize("dt", [0.002, 0.008, 0.0040001])
def test_a_path_sampled_at_another_step_is_refused(arm, dt):
    path = circle_test((1.5, 0, 0.6), 0.1, radii=(0.01,), dt=dt)
    refused(r"every control_dt = 0\.004 s", lambda: cartesian_reference(arm, path))
    refused(r"every control_dt = 0\.004 s", lambda: joint_reference(arm.robot, joint_sine([0.1] * 6, 1.0, 1.0, dt=dt)))


def test_a_robot_without_work_area_or_tool_has_no_cartesian_motion(irb4600, one_axis):
    path = circle_test((1.5, 0, 0.6), 0.1)
    refused("has no work area; give its motions in joint space", lambda: cartesian_reference(RigidArm(one_axis), path))
    bare = RigidArm(replace(irb4600, tool=None))
    refused("has no tool, so it has no TCP", lambda: cartesian_reference(bare, path))
    for question in (bare.tcp_position, bare.tcp_pose, bare.jacobian, lambda q: bare.bias_acceleration(q, q)):
        refused("has no tool", lambda question=question: question(np.zeros((1, 6))))


def test_joint_motions_are_checked_against_number_range_and_speed_of_the_joints(irb4600):
    refused(r"\(251, 1\), must be \(251, 6\)", lambda: joint_reference(irb4600, joint_sine([0.1], 1.0, 1.0)))
    refused(r"joint j3 is at 1\.3\d+ rad at \d\.\d+ s, must be within \[-3\.142, 1\.309\]",
            lambda: joint_reference(irb4600, joint_sine([0, 0, 2.0, 0, 0, 0], 0.1, 10.0)))  # fmt: skip
    refused(r"joint j6 moves at 7\.000 rad/s",
            lambda: joint_reference(irb4600, constant_velocity([0, 0, 0, 0, 0, 7.0], 0.1)))  # fmt: skip


def test_a_reference_built_by_hand_is_checked_too(irb4600):
    t = 0.004 * np.arange(5)
    still = np.zeros((5, 6))
    values = {"name": "by hand", "robot": irb4600, "t": t, "q": still, "dq": still, "ddq": still, "phases": ()}
    assert Reference(**values).duration == pytest.approx(0.016)
    for name, bad in (("q", still[:4]), ("dq", still * np.nan), ("ddq", still[:, :5]), ("t", t * 2)):
        refused(f"reference {name} |control_dt", lambda name=name, bad=bad: Reference(**values | {name: bad}))


@pytest.mark.parametrize("shape", [(6,), (1, 5), (2, 1, 6)])
def test_kinematics_want_one_row_of_joint_angles_per_pose(arm, shape):
    for question in (arm.tcp_position, arm.tcp_pose, arm.jacobian):
        refused("q has shape", lambda question=question: question(np.zeros(shape)))
    refused("dq has shape", lambda: arm.bias_acceleration(np.zeros((1, 6)), np.zeros(shape)))
