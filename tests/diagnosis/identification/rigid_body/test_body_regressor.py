"""Torque as a linear function of parameters: it is that of the arm, for all kinds of joints, drives and bodies."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from ffgym.diagnosis.identification.rigid_body import TERMS
from ffgym.diagnosis.identification.rigid_body.bodies import (
    bodies_of,
    body_torque,
    mass_com_inertia,
    parameters,
    pseudo_inertia,
    with_bodies,
)
from ffgym.diagnosis.identification.rigid_body.terms import rigid_motion
from ffgym.robot import RigidArm, load_robot, motor_torque
from tests.robot.arm_samples import random_arm
from tests.robot.robot_samples import unusual


def random_states(robot, seed, count=20):
    return np.random.default_rng(seed).normal(size=(3, count, robot.n_joints))


@given(types=st.text("RP", min_size=1, max_size=5), seed=st.integers(0, 1000))
@settings(max_examples=15)
def test_torque_of_bodies_is_the_inverse_dynamics_of_any_arm(types, seed):
    robot = random_arm(types, seed)
    states = random_states(robot, seed)
    wanted = RigidArm(robot).inverse_dynamics(*states, gravity=True)
    found = body_torque(robot, np.array([body.parameters for body in bodies_of(robot)]), *states)
    np.testing.assert_allclose(found, wanted, rtol=1e-10, atol=1e-10 * np.abs(wanted).max())


def test_terms_add_up_to_the_motor_torque_of_a_robot_with_rail_couplings_and_springs():
    robot = unusual(load_robot("irb4600_60_205"))
    states = random_states(robot, 0)
    motion = rigid_motion(robot, *states)
    found = sum(term.torque(robot, motion, term.described(robot)) for term in TERMS)
    wanted = motor_torque(RigidArm(robot), *states)
    steady = wanted.friction - robot.friction.steady_torque(motion.motor_dq)
    steady += robot.friction.coulomb * np.sign(motion.motor_dq) + robot.friction.viscous * motion.motor_dq
    np.testing.assert_allclose(found, wanted.total - wanted.friction + steady, rtol=1e-10, atol=1e-9)


def test_labels_units_and_columns_of_each_term_are_as_many_as_its_parameters():
    robot = load_robot("kuka_kr300_r2500")
    motion = rigid_motion(robot, *random_states(robot, 0, count=2))
    for term in TERMS:
        count = len(term.described(robot))
        assert len(term.labels(robot)) == len(term.units(robot)) == count
        assert sum(part.shape[1] for part in term.columns(robot, motion)) == count


def test_bodies_come_back_from_their_parameters():
    robot = load_robot("kuka_kr300_r2500")
    again = with_bodies(robot, np.array([body.parameters for body in bodies_of(robot)]))
    np.testing.assert_allclose(again.bodies.com, robot.bodies.com, atol=1e-12)
    np.testing.assert_allclose(again.bodies.inertia, robot.bodies.inertia, atol=1e-11)
    np.testing.assert_allclose(again.tool.inertia, robot.tool.inertia, atol=1e-11)


@given(seed=st.integers(0, 1000))
def test_points_of_mass_are_a_body_and_a_hole_makes_it_none(seed):
    rng = np.random.default_rng(seed)
    points, weights = rng.normal(size=(6, 3)), rng.uniform(0.5, 2.0, 6)
    homogeneous = np.column_stack([points, np.ones(6)])
    moments = np.einsum("k,ki,kj->ij", weights, homogeneous, homogeneous)
    com = weights @ points / weights.sum()
    away = points - com
    tensor = np.einsum(
        "k,kij->ij", weights, (away**2).sum(1)[:, None, None] * np.eye(3) - away[:, :, None] * away[:, None]
    )
    values = parameters(weights.sum(), com, tensor[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]])
    np.testing.assert_allclose(pseudo_inertia(values), moments, atol=1e-10)
    assert np.linalg.eigvalsh(pseudo_inertia(values))[0] > 0
    mass, _, inertia = mass_com_inertia(values)
    thin = parameters(mass, com, inertia * [1.0, 1.0, 2.5, 1, 1, 1] + [0, 0, inertia[:2].sum(), 0, 0, 0])
    assert np.linalg.eigvalsh(pseudo_inertia(thin))[0] < 0
