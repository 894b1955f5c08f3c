"""Kinematics and rigid dynamics of arms with any hinges and slides, against an arm that only shares the description."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from ffgym.robot import RigidArm
from tests.robot.arm_samples import ARMS, random_arm
from tests.robot.independent_arm import IndependentArm

TYPES = ("R", "P", "RR", "RP", "PR", "PRP", "RRR", "RRPR", "PPP", "RRRRR", "RRRRRR", "PRRRRRR", "RRRRRRR", "PRPRPRPR")
"""Arms of one to eight joints; every joint before and behind every other kind."""


@st.composite
def arms_in_motion(draw):
    """A random arm, and joint positions, speeds and accelerations."""
    robot = random_arm(draw(st.sampled_from(TYPES)), draw(st.integers(0, 2**32 - 1)))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    q, dq, ddq = rng.uniform(-2, 2, (3, robot.n_joints))
    return robot, q, dq, ddq


few = settings(max_examples=40)


@few
@given(arms_in_motion())
def test_the_tool_is_where_the_chain_of_transforms_puts_it(motion):
    robot, q, *_ = motion
    arm, independent = RigidArm(robot), IndependentArm(robot)
    position, rotation = arm.tcp_pose(q[None])
    np.testing.assert_allclose(position[0], independent.tcp(q), atol=1e-13)
    np.testing.assert_allclose(rotation[0], independent.tool_rotation(q), atol=1e-13)
    np.testing.assert_allclose(arm.tcp_position(q[None]), position, atol=1e-13)


@few
@given(arms_in_motion())
def test_the_jacobian_is_the_slope_of_the_pose(motion):
    robot, q, dq, _ = motion
    arm, independent, step = RigidArm(robot), IndependentArm(robot), 1e-30
    twist = arm.jacobian(q[None])[0] @ dq
    np.testing.assert_allclose(twist[:3], independent.tcp(q + 1j * step * dq).imag / step, atol=1e-12)
    spin = (independent.tool_rotation(q + 1j * step * dq).imag / step) @ independent.tool_rotation(q).T
    np.testing.assert_allclose(twist[3:], [spin[2, 1], spin[0, 2], spin[1, 0]], atol=1e-12)


@few
@given(arms_in_motion())
def test_the_bias_acceleration_is_the_rate_of_the_jacobian_times_the_speed(motion):
    robot, q, dq, _ = motion
    arm, step = RigidArm(robot), 1e-4
    twists = arm.jacobian(q + np.array([-2, -1, 1, 2])[:, None] * step * dq) @ dq
    rate = (twists[0] - 8 * twists[1] + 8 * twists[2] - twists[3]) / (12 * step)
    np.testing.assert_allclose(arm.bias_acceleration(q[None], dq[None])[0], rate, atol=1e-7)


@few
@given(arms_in_motion())
def test_the_rigid_dynamics_obey_lagranges_equations(motion):
    robot, q, dq, ddq = motion
    arm, independent = RigidArm(robot), IndependentArm(robot)
    torque = arm.inverse_dynamics(q[None], dq[None], ddq[None])[0]
    scale = 1 + np.abs(torque).max()
    np.testing.assert_allclose(torque, independent.lagrange_torque(q, dq, ddq), atol=1e-9 * scale)
    np.testing.assert_allclose(arm.gravity_torque(q[None])[0], independent.gravity_torque(q), atol=1e-10 * scale)


@pytest.mark.parametrize("name", ARMS)
def test_a_row_of_an_arm_has_the_same_bits_alone_and_among_others(name):
    arm = RigidArm(ARMS[name]())
    q, dq = np.random.default_rng(0).uniform(-1, 1, (2, 50, arm.robot.n_joints))
    for ask in (arm.tcp_position, arm.jacobian, lambda q: arm.bias_acceleration(q, dq[: len(q)])):
        np.testing.assert_array_equal(ask(q)[:1], ask(q[:1]))


def test_the_tool_of_a_scara_stays_upright():
    arm = RigidArm(ARMS["scara"]())
    q = np.random.default_rng(0).uniform(-1, 1, (20, 4))
    position, rotation = arm.tcp_pose(q)
    np.testing.assert_allclose(rotation[:, :, 2], np.tile([0.0, 0, -1], (20, 1)), atol=1e-15)
    np.testing.assert_allclose(position[:, 2], 0.6 - 0.1 - q[:, 2], atol=1e-15)
    yaw = Rotation.from_matrix(rotation).as_euler("xyz")[:, 2]
    np.testing.assert_allclose(np.sin(yaw - (q[:, 0] + q[:, 1] - q[:, 3])), 0, atol=1e-12)
