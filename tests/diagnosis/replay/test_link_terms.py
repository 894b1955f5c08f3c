"""Terms of links between the places where they are evaluated are those of the arm there."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.diagnosis.replay.links import bending_of, link_terms, terms_beside
from ffgym.robot import RigidArm, load_robot


@pytest.mark.parametrize(
    ("samples", "dt"),
    [(400, 0.002), (402, 0.001), (100, 0.004), (5, 0.002), (3, 0.001), (1, 0.001)],
    ids=["every 2nd", "every 4th, not to the end", "every one", "few", "fewer than a cubic takes", "one"],
)
def test_interpolated_terms_are_those_of_the_arm_at_every_sample(samples, dt):
    robot = load_robot("irb4600_60_205")
    arm = RigidArm(robot)
    rng = np.random.default_rng(3)
    t = dt * np.arange(samples)
    swing = 2 * np.pi * rng.uniform(0.3, 1.0, (2, robot.n_joints))
    phase = rng.uniform(0, 2 * np.pi, swing.shape)
    angle = t[:, None, None] * swing + phase
    q, dq, ddq = 0.4 * np.sin(angle), 0.4 * swing * np.cos(angle), -0.4 * swing**2 * np.sin(angle)
    terms = link_terms(arm, q, dq, dt)
    rows = (-1, robot.n_joints)
    true = arm.inverse_dynamics(q.reshape(rows), dq.reshape(rows), ddq.reshape(rows), gravity=True)
    true = true + arm.spring_torque(q.reshape(rows))
    np.testing.assert_allclose(terms.torque(ddq).reshape(rows), true, rtol=0, atol=1e-6 * np.abs(true).max())
    mass = arm.mass_matrix(q.reshape(rows)).reshape(terms.mass.shape)
    np.testing.assert_allclose(terms.mass, mass, rtol=0, atol=1e-6 * np.abs(mass).max())


def test_what_bending_adds_is_what_links_ask_for_that_move_otherwise_than_motors():
    """To first order: of deflections a hundred times as small, next to nothing else is left."""
    robot = load_robot("irb4600_60_205")
    arm, rng, n = RigidArm(robot), np.random.default_rng(4), robot.n_joints
    q, dq, ddq = rng.uniform(-1, 1, (3, 1, 8, n)) * np.array([0.5, 2.0, 10.0])[:, None, None, None]
    angle, rate = rng.uniform(-1, 1, (2, 1, 8, n)) * np.array([1e-4, 1e-2])[:, None, None, None]
    bending = bending_of(arm, q, dq, ddq, 0.001, np.arange(n))
    found = (bending.place @ angle[..., None] + bending.rate @ rate[..., None])[0, ..., 0]
    true = arm.inverse_dynamics((q + angle)[0], (dq + rate)[0], ddq[0], gravity=True)
    true = true - arm.inverse_dynamics(q[0], dq[0], ddq[0], gravity=True)
    true = true + arm.spring_torque((q + angle)[0]) - arm.spring_torque(q[0])
    np.testing.assert_allclose(found, true, rtol=0, atol=1e-2 * np.abs(true).max())


def test_joints_that_do_not_bend_add_nothing():
    robot = load_robot("irb4600_60_205")
    q = np.full((20, 1, robot.n_joints), 0.3)
    bending = bending_of(RigidArm(robot), q, q, q, 0.001, np.array([1]))
    others = np.arange(robot.n_joints) != 1
    assert not bending.rate[..., others].any()
    assert not bending.place[..., others].any()
    assert bending.place[..., 1].any()


def test_terms_of_other_masses_follow_from_those_of_the_described_ones():
    """Where the described arm was: to a thousandth of what the masses change, though evaluated a quarter as often."""
    robot = load_robot("irb4600_60_205")
    bodies = replace(robot.bodies, mass=1.1 * robot.bodies.mass, inertia=1.2 * robot.bodies.inertia)
    heavier = replace(robot, bodies=bodies)
    joints = np.arange(robot.n_joints)
    rng, dt = np.random.default_rng(3), 0.002
    swing, phase = 2 * np.pi * rng.uniform(0.3, 1.0, (2, 6)), rng.uniform(0, 2 * np.pi, (2, 6))
    angle = dt * np.arange(500)[:, None, None] * swing + phase
    q, dq, ddq = 0.4 * np.sin(angle), 0.4 * swing * np.cos(angle), -0.4 * swing**2 * np.sin(angle)
    bent = 1e-3 * np.cos(angle)

    def terms(arm):
        bending = bending_of(arm, q + bent, dq, ddq, dt, joints)
        at_rest = link_terms(arm, q + bent, dq, dt)
        unbent = at_rest.bias - np.matmul(bending.place, bent[..., None])[..., 0]
        return replace(at_rest, bias=unbent, bending=bending, bent=bent)

    plain, true = terms(RigidArm(robot)), terms(RigidArm(heavier))
    found = terms_beside(RigidArm(heavier), plain, q, dq, ddq, dt, joints)
    for own, other, before in (
        (found.torque(ddq), true.torque(ddq), plain.torque(ddq)),
        (found.mass, true.mass, plain.mass),
        (found.bending.place, true.bending.place, plain.bending.place),
        (found.bending.rate, true.bending.rate, plain.bending.rate),
    ):
        np.testing.assert_allclose(own, other, rtol=0, atol=1e-3 * np.abs(other - before).max())
