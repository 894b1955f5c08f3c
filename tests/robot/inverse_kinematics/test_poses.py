"""One pose of the tool: the solution nearest to a seed, and all of them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ffgym.core.errors import FFGymError
from ffgym.robot import RigidArm, pose_solutions, solve_path, solve_pose
from ffgym.robot.inverse_kinematics import rotation_error
from scripts.engine.second.arm import PinocchioArm
from tests.robot.arm_samples import ARMS, make_arm

seeds = st.integers(0, 2**32 - 1)
X, Y, Z = np.eye(3)


def check_all_reach(arm, solutions, position, rotation):
    where, turned = arm.tcp_pose(solutions)
    np.testing.assert_allclose(where, np.tile(position, (len(solutions), 1)), rtol=0, atol=1e-9)
    if rotation is not None:
        np.testing.assert_allclose(rotation_error(rotation, turned), 0, atol=1e-9)
    low, high = arm.robot.kinematics.range.T
    assert np.all((solutions >= low) & (solutions <= high))


@settings(max_examples=20)
@given(st.sampled_from(sorted(ARMS)), seeds, st.booleans())
def test_a_pose_that_the_arm_has_been_in_is_found_again(name, seed, turning):
    arm = RigidArm(ARMS[name]())
    low, high = arm.robot.kinematics.range.T
    q = np.random.default_rng(seed).uniform(0.9 * low, 0.9 * high)
    position, rotation = (part[0] for part in arm.tcp_pose(q[None]))
    asked = rotation if turning else None
    found = solve_pose(arm, position, asked, q)
    check_all_reach(arm, found[None], position, asked)
    np.testing.assert_allclose(found, q, rtol=0, atol=1e-9)


def test_a_pose_far_from_the_seed_is_found_too_though_a_path_must_begin_near_it(arm):
    q = np.array([1.8, 0.75, -2.15, 0.8, -2.1, 3.0])
    position, rotation = arm.tcp_pose(q[None])
    home = arm.robot.work_area.home
    with pytest.raises(FFGymError, match="joint limits"):
        solve_path(arm, position, rotation[0], home)
    check_all_reach(arm, solve_pose(arm, position[0], rotation[0], home)[None], position[0], rotation[0])


def test_a_planar_arm_has_its_elbow_up_or_down():
    arm = RigidArm(ARMS["two_link"]())
    up = np.array([-1.0, 1.5])
    position = arm.tcp_position(up[None])[0]
    first, second = pose_solutions(arm, position, None, up)
    np.testing.assert_allclose(first, up, atol=1e-9)
    assert second[1] == pytest.approx(-1.5)
    np.testing.assert_allclose(solve_pose(arm, position, None, second), second, atol=1e-9)


def test_the_six_axis_robot_has_eight_solutions_or_four_where_it_cannot_reach_over_itself(irb4600):
    """Shoulder, elbow and wrist each one way or the other, as for every arm with a spherical wrist (Pieper 1968)."""
    free = replace(irb4600, kinematics=replace(irb4600.kinematics, range=np.tile([-np.pi, np.pi], (6, 1))))
    wide, chain, rng = RigidArm(free), PinocchioArm(irb4600), np.random.default_rng(0)
    shoulder, upper, fore = 0.175, 0.9, np.hypot(0.175, 0.96)
    counts = []
    for q in rng.uniform([-3, -0.6, -1.5, -3, 0.4, -3], [3, 0.6, 0.5, 3, 1.5, 3], (12, 6)):
        position, rotation = (part[0] for part in wide.tcp_pose(q[None]))
        solutions = pose_solutions(wide, position, rotation, q)
        check_all_reach(wide, solutions, position, rotation)
        wrist = chain.joint_origins(q)[4]
        backwards = np.hypot(np.hypot(*wrist[:2]) + shoulder, wrist[2] - 0.495)
        counts.append(len(solutions))
        assert len(solutions) == (8 if fore - upper < backwards < fore + upper else 4)
        np.testing.assert_allclose(solutions[0], q, atol=1e-9)
        assert np.all(np.diff(np.abs(solutions - q).max(axis=1)) >= 0)
    assert set(counts) == {4, 8}


def test_every_whole_turn_within_the_limits_is_a_solution(arm):
    area = arm.robot.work_area
    solutions = pose_solutions(arm, area.positions["p1"], area.tool_rotation, area.home)
    check_all_reach(arm, solutions, area.positions["p1"], area.tool_rotation)
    same_arm = np.abs(solutions[:, :3] - solutions[0, :3]).max(axis=1) < 1e-6
    last = np.sort(solutions[same_arm & (np.abs(solutions[:, 3] - solutions[0, 3]) < 1e-6)][:, 5])
    low, high = arm.robot.kinematics.range[5]
    np.testing.assert_allclose(np.diff(last), 2 * np.pi, atol=1e-9)
    assert last[0] - 2 * np.pi < low
    assert last[-1] + 2 * np.pi > high


def test_a_hinge_that_comes_out_beyond_its_range_is_turned_back():
    limits = [[-0.5, 2 * np.pi - 0.6], [-3.0, 3.0]]
    arm = RigidArm(make_arm("turner", "RR", [Z, 0.5 * X], [Y, Y], tcp=0.4 * X, limits=limits))
    position = arm.tcp_position(np.array([[5.5, 0.3]]))[0]  # from -0.4 the way leads to 5.5 - 2 pi, beyond the limit
    found = solve_path(arm, position[None], None, np.array([-0.4, 0.3]))
    check_all_reach(arm, found, position, None)
    np.testing.assert_allclose(found, [[5.5, 0.3]], atol=1e-9)


@pytest.mark.parametrize(("name", "turning"), [("seven_axis", True), ("three_link", False), ("gantry", False)])
def test_the_nearest_posture_is_the_seed_itself_where_it_makes_the_pose(name, turning):
    arm = RigidArm(ARMS[name]())
    home = arm.robot.work_area.home
    position, rotation = (part[0] for part in arm.tcp_pose(home[None]))
    asked = rotation if turning else None
    np.testing.assert_allclose(solve_pose(arm, position, asked, home), home, atol=1e-9)
    solutions = pose_solutions(arm, position, asked, home)
    np.testing.assert_allclose(solutions[0], home, atol=1e-9)
    check_all_reach(arm, solutions, position, asked)


def test_all_postures_found_are_nearest_to_the_seed_among_their_neighbours():
    """Also those that Newton's method reaches beyond a joint limit, which a whole turn brings back within."""
    arm = RigidArm(ARMS["seven_axis"]())
    home, speed = arm.robot.work_area.home, arm.robot.kinematics.max_speed
    position, rotation = arm.tcp_pose(home[None])
    solutions = pose_solutions(arm, position[0], rotation[0], home)
    assert len(solutions) > 1
    free = np.linalg.svd(arm.jacobian(solutions))[2][:, 6]
    np.testing.assert_allclose(np.sum(free * (solutions - home) / speed**2, axis=1), 0, atol=1e-9)


def test_what_is_found_is_the_same_in_every_call():
    arm = RigidArm(ARMS["seven_axis"]())
    pose = arm.tcp_pose(arm.robot.work_area.home[None])
    first, second = (pose_solutions(arm, pose[0][0], pose[1][0], np.zeros(7)) for _ in range(2))
    np.testing.assert_array_equal(first, second)


def test_a_stretched_arm_is_solved_though_its_equations_are_exactly_singular():
    arm = RigidArm(ARMS["two_link"]())
    np.testing.assert_allclose(solve_pose(arm, [0.9, 0.0, 1.0], None, np.zeros(2)), 0, atol=1e-9)
    bent = solve_pose(arm, [0.8, 0.0, 1.0], None, np.zeros(2))
    np.testing.assert_allclose(arm.tcp_position(bent[None])[0], [0.8, 0, 1], atol=1e-9)


def test_a_pose_at_a_joint_limit_is_within_it():
    limits = [[-1.0, 1.5], [0.0, 2.0], [-0.25, 0.75]]
    arm = RigidArm(make_arm("short", "RRP", [Z, 0.4 * X, 0.3 * X], [Z, Z, X], tcp=0.2 * X, limits=limits))
    for q in (np.array([-1.0, 0.0, 0.75]), np.array([1.5, 2.0, -0.25])):
        position, rotation = (part[0] for part in arm.tcp_pose(q[None]))
        np.testing.assert_allclose(solve_pose(arm, position, rotation, q), q, rtol=0, atol=1e-9)
        np.testing.assert_allclose(pose_solutions(arm, position, rotation, q)[0], q, rtol=0, atol=1e-9)
    along = np.linspace([-0.5, 0.3, 0.75], [0.5, 1.3, 0.75], 50)  # one joint stays at its limit, to rounding
    positions, rotations = arm.tcp_pose(along)
    np.testing.assert_allclose(solve_path(arm, positions, rotations, along[0]), along, rtol=0, atol=1e-9)
    beyond = np.array([[-1.0, -1e-6, 0.75]])
    assert arm.robot.kinematics.beyond_limits(beyond).tolist() == [[False, True, False]]
