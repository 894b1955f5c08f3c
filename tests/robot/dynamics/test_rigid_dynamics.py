"""MuJoCo's rigid arm against Lagrange's equations for an arm that only shares the description."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.robot.independent_arm import IndependentArm


@pytest.fixture(scope="module")
def independent(irb4600):
    return IndependentArm(irb4600)


def joints(largest):
    return st.lists(st.floats(-largest, largest, allow_subnormal=False), min_size=6, max_size=6).map(np.array)


angles, speeds, accelerations = joints(3.0), joints(3.0), joints(20.0)


@given(q=angles)
def test_tcp_position_follows_the_chain_of_homogeneous_transforms(arm, independent, q):
    position, _ = arm.tcp_pose(q[None])
    np.testing.assert_allclose(position[0], independent.tcp(q), atol=1e-14)


def test_tcp_position_is_that_of_the_pose(arm):
    q = np.random.default_rng(0).uniform(-3, 3, (20, 6))
    np.testing.assert_allclose(arm.tcp_position(q), arm.tcp_pose(q)[0], atol=1e-14)


@given(q=angles)
def test_tool_orientation_follows_the_chain_of_homogeneous_transforms(arm, independent, q):
    _, rotation = arm.tcp_pose(q[None])
    np.testing.assert_allclose(rotation[0], independent.frames(q)[-1][:3, :3] @ arm.robot.tool.rotation, atol=1e-13)


@given(q=angles, dq=speeds)
def test_jacobian_times_speed_is_the_velocity_of_the_tcp(arm, independent, q, dq):
    twist = arm.jacobian(q[None])[0] @ dq
    rate, frame = independent.frame_rates(q, dq)[-1], independent.frames(q)[-1]
    tool = arm.robot.tool
    np.testing.assert_allclose(twist[:3], rate[:3, :3] @ tool.rotation @ tool.tcp + rate[:3, 3], atol=1e-12)
    spin = rate[:3, :3] @ frame[:3, :3].T
    np.testing.assert_allclose(twist[3:], [spin[2, 1], spin[0, 2], spin[1, 0]], atol=1e-12)


@given(q=angles, dq=speeds)
def test_bias_acceleration_is_the_derivative_of_the_jacobian_along_the_motion(arm, q, dq):
    step = 1e-4
    offsets = np.array([-2, -1, 1, 2])[:, None] * step
    twists = arm.jacobian(q + offsets * dq) @ dq
    derivative = (twists[0] - 8 * twists[1] + 8 * twists[2] - twists[3]) / (12 * step)
    np.testing.assert_allclose(arm.bias_acceleration(q[None], dq[None])[0], derivative, atol=1e-7)


@given(q=angles, dq=speeds)
def test_mass_matrix_gives_the_kinetic_energy_of_the_links(arm, independent, q, dq):
    energy = 0.5 * dq @ arm.mass_matrix(q[None])[0] @ dq
    np.testing.assert_allclose(energy, independent.kinetic_energy(q, dq), rtol=1e-12, atol=1e-12)


@given(q=angles)
def test_mass_matrix_is_symmetric_and_positive_definite(arm, independent, q):
    mass = arm.mass_matrix(q[None])[0]
    np.testing.assert_array_equal(mass, mass.T)
    assert np.linalg.eigvalsh(mass).min() > 0
    np.testing.assert_allclose(mass, independent.mass_matrix(q), atol=1e-10)


@given(q=angles)
def test_gravity_torque_is_the_slope_of_the_potential_energy(arm, independent, q):
    np.testing.assert_allclose(arm.gravity_torque(q[None])[0], independent.gravity_torque(q), atol=1e-9)


@settings(max_examples=40)
@given(q=angles, dq=speeds, ddq=accelerations)
def test_inverse_dynamics_obeys_lagranges_equations(arm, independent, q, dq, ddq):
    torque = arm.inverse_dynamics(q[None], dq[None], ddq[None])[0]
    scale = 1 + np.abs(torque).max()
    np.testing.assert_allclose(torque, independent.lagrange_torque(q, dq, ddq), atol=1e-10 * scale)


@given(q=angles, dq=speeds)
def test_inverse_dynamics_leaves_gravity_out_unless_asked(arm, q, dq):
    still = np.zeros_like(q)
    without = arm.inverse_dynamics(q[None], dq[None], still[None])
    with_gravity = arm.inverse_dynamics(q[None], dq[None], still[None], gravity=True)
    np.testing.assert_allclose(with_gravity - without, arm.gravity_torque(q[None]), atol=1e-9)


def test_a_row_has_the_same_bits_alone_and_among_thousands(arm):
    rng = np.random.default_rng(1)
    q, dq, ddq = rng.uniform(-2, 2, (3, 2500, 6))
    together = arm.inverse_dynamics(q, dq, ddq, gravity=True)
    for row in (0, 1023, 1024, 2499):
        alone = arm.inverse_dynamics(*(x[row : row + 1] for x in (q, dq, ddq)), gravity=True)
        np.testing.assert_array_equal(alone[0], together[row])
