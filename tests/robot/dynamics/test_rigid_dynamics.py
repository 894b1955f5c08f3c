"""Properties of rigid dynamics that no other engine need tell; tests/oracle compares every number with Pinocchio."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ffgym.robot import RigidArm
from tests.robot.arm_samples import ARMS


def test_mass_matrices_are_symmetric_to_the_bit_and_positive_definite(arm):
    for mass in arm.mass_matrix(np.random.default_rng(0).uniform(-3, 3, (50, 6))):
        np.testing.assert_array_equal(mass, mass.T)
        assert np.linalg.eigvalsh(mass).min() > 0


def test_inverse_dynamics_leaves_gravity_out_unless_asked(arm):
    q, dq, ddq = np.random.default_rng(0).uniform(-3, 3, (3, 20, 6))
    without = arm.inverse_dynamics(q, dq, ddq)
    with_gravity = arm.inverse_dynamics(q, dq, ddq, gravity=True)
    np.testing.assert_allclose(with_gravity - without, arm.gravity_torque(q), atol=1e-9)


def test_a_row_has_the_same_bits_alone_and_among_thousands(arm):
    rng = np.random.default_rng(1)
    q, dq, ddq = rng.uniform(-2, 2, (3, 2500, 6))
    together = arm.inverse_dynamics(q, dq, ddq, gravity=True)
    for row in (0, 1023, 1024, 2499):
        alone = arm.inverse_dynamics(*(x[row : row + 1] for x in (q, dq, ddq)), gravity=True)
        np.testing.assert_array_equal(alone[0], together[row])


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
