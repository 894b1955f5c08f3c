"""Derivatives of the Jacobian against finite differences, on random arms with hinges and slides."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from ffgym.robot import RigidArm
from ffgym.robot.inverse_kinematics.newton import jacobian_rates, jacobian_slope
from tests.robot.arm_samples import random_arm

STEP = 1e-3
WEIGHTS = np.array([1, -8, 8, -1]) / (12 * STEP)
SECOND = np.array([-1, 16, -30, 16, -1]) / (12 * STEP**2)

few = settings(max_examples=30)
arms = st.builds(random_arm, st.sampled_from(["RR", "RPR", "PRRP", "RRRRRR", "RRRRRRR"]), st.integers(0, 2**32 - 1))
seeds = st.integers(0, 2**32 - 1)


@few
@given(arms, seeds)
def test_the_rates_of_the_jacobian_are_its_time_derivatives(robot, seed):
    arm, rng = RigidArm(robot), np.random.default_rng(seed)
    q, dq = rng.uniform(-1, 1, (2, robot.n_joints))
    rate, second = jacobian_rates(arm.jacobian(q[None]), dq[None])
    samples = arm.jacobian(q + STEP * np.arange(-2, 3)[:, None] * dq)
    np.testing.assert_allclose(rate[0], np.einsum("k,kij->ij", WEIGHTS, samples[[0, 1, 3, 4]]), atol=1e-8)
    np.testing.assert_allclose(second[0], np.einsum("k,kij->ij", SECOND, samples), atol=1e-6)


@few
@given(arms, seeds)
def test_the_bias_acceleration_is_the_rate_of_the_jacobian_times_the_speed(robot, seed):
    arm, rng = RigidArm(robot), np.random.default_rng(seed)
    q, dq = rng.uniform(-2, 2, (2, 7, robot.n_joints))
    rate, _ = jacobian_rates(arm.jacobian(q), dq)
    np.testing.assert_allclose(np.einsum("tij,tj->ti", rate, dq), arm.bias_acceleration(q, dq), atol=1e-11)


@few
@given(arms, seeds)
def test_the_slope_of_joint_torques_is_that_of_the_jacobian(robot, seed):
    arm, rng = RigidArm(robot), np.random.default_rng(seed)
    q, force = rng.uniform(-1, 1, robot.n_joints), rng.normal(size=6)
    slope = jacobian_slope(arm.jacobian(q[None]), force[None])[0]
    for k, unit in enumerate(np.eye(robot.n_joints)):
        torques = arm.jacobian(q + STEP * np.array([-2, -1, 1, 2])[:, None] * unit).swapaxes(1, 2) @ force
        np.testing.assert_allclose(slope[:, k], WEIGHTS @ torques, atol=1e-8)
