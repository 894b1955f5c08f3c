"""The planar two-link arm against its equations of motion in closed form, as textbooks write them down."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ffgym.robot import RigidArm, load_robot, motor_torque, resonances, solve_path

LENGTH, CENTRE, MASS, INERTIA = 1.0, 0.5, 50.0, 10.0
"""Of each link [m], [m], [kg], [kg m^2]: Siciliano, Sciavicco, Villani, Oriolo, Robotics (2009)."""
MOTOR = 5.0
"""Mass of the elbow motor [kg]."""
TOOL, TOOL_AT, TOOL_INERTIA = 5.0, 1.05, 0.01
"""Mass [kg], distance of its centre from the elbow [m] and inertia [kg m^2] of the tool."""
RATIO, ROTOR = 100.0, 0.01
G = 9.81


@pytest.fixture(scope="module")
def two_link():
    return RigidArm(load_robot("two_link"))


def angles(largest):
    return st.lists(st.floats(-largest, largest, allow_subnormal=False), min_size=2, max_size=2).map(np.array)


def closed_form(q, dq, ddq):
    """Torque of shoulder and elbow [N m] for angles counted upwards from the horizontal."""
    (q1, q2), (w1, w2) = q, dq
    moment = MASS * CENTRE + TOOL * TOOL_AT  # of the forearm about the elbow, [kg m]
    forearm = INERTIA + MASS * CENTRE**2 + TOOL_INERTIA + TOOL * TOOL_AT**2  # about the elbow, [kg m^2]
    upper = INERTIA + MASS * CENTRE**2 + (MOTOR + MASS + TOOL) * LENGTH**2  # about the shoulder, [kg m^2]
    coupled = LENGTH * moment * np.cos(q2)
    mass = np.array([[upper + forearm + 2 * coupled, forearm + coupled], [forearm + coupled, forearm]])
    turning = LENGTH * moment * np.sin(q2)
    coriolis = np.array([-turning * (2 * w1 * w2 + w2**2), turning * w1**2])
    elbow = G * moment * np.cos(q1 + q2)
    gravity = np.array([G * (MASS * CENTRE + (MOTOR + MASS + TOOL) * LENGTH) * np.cos(q1) + elbow, elbow])
    return mass @ ddq + coriolis + gravity


@given(q=angles(3.0), dq=angles(3.0), ddq=angles(20.0))
def test_torque_is_that_of_the_textbook(two_link, q, dq, ddq):
    torque = two_link.inverse_dynamics(q[None], dq[None], ddq[None], gravity=True)[0]
    wanted = closed_form(q, dq, ddq)
    np.testing.assert_allclose(torque, wanted, rtol=0, atol=1e-12 * (1 + np.abs(wanted).max()))


@given(q=angles(3.0), dq=angles(3.0), ddq=angles(20.0))
def test_motor_torque_adds_rotors_and_friction(two_link, q, dq, ddq):
    friction = two_link.robot.friction.steady_torque(RATIO * dq)
    wanted = closed_form(q, dq, ddq) / RATIO + RATIO * ROTOR * ddq + friction
    total = motor_torque(two_link, q[None], dq[None], ddq[None]).total[0]
    np.testing.assert_allclose(total, wanted, rtol=0, atol=1e-12 * (1 + np.abs(wanted).max()))


@given(q=angles(3.0))
def test_tool_tip_is_at_the_end_of_both_links(two_link, q):
    reach, lift = np.array([LENGTH, LENGTH + 0.1]), np.cumsum(q)
    wanted = [reach @ np.cos(lift), 0.0, 1.2 + reach @ np.sin(lift)]
    np.testing.assert_allclose(two_link.tcp_position(q[None])[0], wanted, atol=1e-14)


def test_arm_reaches_its_work_area_elbow_up_away_from_singularities(two_link):
    area = two_link.robot.work_area
    for point in area.positions.values():
        q = solve_path(two_link, point[None], area.tool_rotation, area.home)
        assert q[0, 1] < 0
        assert np.linalg.cond(two_link.jacobian(q)[0][[0, 2]]) < 3
        assert 9 < resonances(two_link, q[0])[0] < 12  # Hz, as the description says


def test_motors_hold_the_level_arm_with_two_thirds_to_spare(two_link):
    held = two_link.gravity_torque(np.zeros((1, 2)))[0] / RATIO
    np.testing.assert_allclose(held, [11.3, 3.0], rtol=0.02)  # as the description says
    assert np.all(3 * held < two_link.robot.drive.peak_torque)
