"""Inverse kinematics undoes the kinematics of the arm, on the branch of its seed, along whole paths."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from ffgym.paths import cartesian_reference, circle_test
from ffgym.robot import RigidArm, solve_path
from ffgym.robot.inverse_kinematics import rotation_error, solve_twist

few = settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
seeds = st.integers(0, 2**32 - 1)
CONDITION = 100.0
"""Poses worse than this are near a singularity, where a small change of pose is a large one of the joints."""


def random_poses(arm: RigidArm, seed: int, count: int) -> np.ndarray:
    """Joint angles (count, N) within the limits, away from singularities."""
    limits, rng = arm.robot.kinematics.range, np.random.default_rng(seed)
    q = rng.uniform(limits[:, 0] + 0.1, limits[:, 1] - 0.1, size=(4 * count, len(limits)))
    return q[np.linalg.cond(arm.jacobian(q)) < CONDITION][:count]


@few
@given(seeds)
def test_inverse_kinematics_finds_the_pose_near_its_seed(arm, seed):
    rng = np.random.default_rng(seed)
    for q in random_poses(arm, seed, 5):
        position, rotation = arm.tcp_pose(q[None])
        found = solve_path(arm, position, rotation[0], q + rng.uniform(-0.02, 0.02, 6))
        again, turned = arm.tcp_pose(found)
        np.testing.assert_allclose(again, position, rtol=0, atol=1e-9)
        np.testing.assert_allclose(rotation_error(rotation[0], turned), 0, atol=1e-9)
        np.testing.assert_allclose(found[0], q, rtol=0, atol=1e-9 * CONDITION)


@few
@given(seeds)
def test_tcp_position_is_that_of_tcp_pose(arm, seed):
    q = np.random.default_rng(seed).uniform(-4, 4, size=(7, 6))
    np.testing.assert_allclose(arm.tcp_position(q), arm.tcp_pose(q)[0], rtol=0, atol=1e-14)


@few
@given(seeds)
def test_the_jacobian_is_the_derivative_of_the_pose(arm, seed):
    rng, h = np.random.default_rng(seed), 1e-6
    q, dq = rng.uniform(-3, 3, size=(2, 5, 6))
    (ahead, turned_ahead), (behind, turned_behind) = arm.tcp_pose(q + h * dq), arm.tcp_pose(q - h * dq)
    linear = (ahead - behind) / (2 * h)
    angular = Rotation.from_matrix(turned_ahead @ turned_behind.swapaxes(1, 2)).as_rotvec() / (2 * h)
    twist = np.einsum("tij,tj->ti", arm.jacobian(q), dq)
    np.testing.assert_allclose(twist, np.hstack([linear, angular]), rtol=0, atol=1e-7)


@few
@given(seeds)
def test_bias_acceleration_is_the_rate_of_the_jacobian_times_the_speed(arm, seed):
    rng, h = np.random.default_rng(seed), 1e-6
    q, dq = rng.uniform(-3, 3, size=(2, 5, 6))
    rate = (arm.jacobian(q + h * dq) - arm.jacobian(q - h * dq)) / (2 * h)
    np.testing.assert_allclose(arm.bias_acceleration(q, dq), np.einsum("tij,tj->ti", rate, dq), rtol=0, atol=3e-7)


@few
@given(seeds)
def test_a_twist_is_solved_for_the_joint_speed_that_makes_it(arm, seed):
    q = random_poses(arm, seed, 5)
    dq = np.random.default_rng(seed).uniform(-1, 1, size=q.shape)
    jacobian = arm.jacobian(q)
    np.testing.assert_allclose(solve_twist(jacobian, np.einsum("tij,tj->ti", jacobian, dq)), dq, rtol=0, atol=1e-10)


@given(seed=seeds, angle=st.sampled_from([0.0, 1e-12, 1e-6, 0.1, 2.0, 3.1, np.pi - 1e-7, np.pi]))
def test_rotation_error_is_the_rotation_vector_up_to_half_a_turn(seed, angle):
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    actual = Rotation.random(random_state=seed)
    wanted = Rotation.from_rotvec(angle * axis) * actual
    error = rotation_error(wanted.as_matrix(), actual.as_matrix()[None])[0]
    assert np.linalg.norm(error) == pytest.approx(angle, abs=1e-8)
    reached = Rotation.from_rotvec(error) * actual
    np.testing.assert_allclose(reached.as_matrix(), wanted.as_matrix(), atol=2e-7)


@pytest.mark.parametrize("position", ["p1", "p2", "p3", "p4"])
@pytest.mark.parametrize("speed", [0.01, 0.1])
def test_a_reference_follows_its_path_and_its_rates_are_derivatives(arm, position, speed):
    path = circle_test(arm.robot.position(position), speed, radii=(0.005,), dt=arm.robot.servo.control_dt)
    reference = cartesian_reference(arm, path)
    where, turn = arm.tcp_pose(reference.q)
    np.testing.assert_allclose(where, path.position, rtol=0, atol=1e-9)
    np.testing.assert_allclose(rotation_error(arm.robot.work_area.tool_rotation, turn), 0, atol=1e-9)
    twist = np.einsum("tij,tj->ti", arm.jacobian(reference.q), reference.dq)
    np.testing.assert_allclose(twist[:, :3], path.velocity, rtol=0, atol=1e-12)
    np.testing.assert_allclose(twist[:, 3:], 0, atol=1e-12)
    spline = CubicSpline(reference.t, reference.q)
    scale = speed**2 / 0.005 * reference.t[1] ** 2 * (speed / 0.005)  # jerk times step squared: error of a cubic
    np.testing.assert_allclose(spline(reference.t, 1), reference.dq, rtol=0, atol=0.2 * scale + 1e-8)
    np.testing.assert_allclose(spline(reference.t, 2), reference.ddq, rtol=0, atol=0.5 * scale / reference.t[1] + 1e-5)


def test_a_large_circle_stays_on_one_branch(arm):
    path = circle_test((1.5, 0.0, 0.6), 0.3, radii=(0.2,), dt=0.004)
    reference = cartesian_reference(arm, path)
    np.testing.assert_allclose(arm.tcp_position(reference.q), path.position, rtol=0, atol=1e-9)
    assert np.abs(np.diff(reference.q, axis=0)).max() < 1.5 * np.abs(reference.dq).max() * 0.004
    np.testing.assert_allclose(reference.q[-1], reference.q[0], rtol=0, atol=1e-8)
    assert np.all(reference.q[:, 4] > 0.3)  # the wrist does not flip


def test_a_path_solved_in_blocks_is_the_same_as_point_by_point(arm):
    area = arm.robot.work_area
    path = circle_test((1.5, 0.0, 0.6), 0.3, radii=(0.1,), dt=0.004)
    whole = solve_path(arm, path.position, area.tool_rotation, area.home)
    for row in (1, 255, 256, 257, len(whole) - 1):
        alone = solve_path(arm, path.position[row : row + 1], area.tool_rotation, whole[row - 1])
        np.testing.assert_allclose(whole[row], alone[0], rtol=0, atol=1e-8)
