"""The KR 300 of the package against what was published: Newton-Euler on Denavit-Hartenberg and CAD numbers."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ffgym.published import KR300_FRICTION
from ffgym.robot import ModelOptions, RigidArm, compile_model, load_robot, motor_torque
from tests.robot import denavit_hartenberg as published

ROUNDING = 1e-12
"""Largest error relative to the largest torque: some hundred roundings."""

FASTEST = 0.76
"""Largest joint speed of the recordings [rad/s]."""


@pytest.fixture(scope="module")
def kr300():
    return load_robot("kuka_kr300_r2500")


@pytest.fixture(scope="module")
def rigid(kr300):
    return RigidArm(kr300)


def joints(largest):
    return st.lists(st.floats(-largest, largest, allow_subnormal=False), min_size=6, max_size=6).map(np.array)


angles, speeds, accelerations = joints(3.0), joints(3.0), joints(20.0)


def assert_equal(actual, wanted):
    np.testing.assert_allclose(actual, wanted, rtol=0, atol=ROUNDING * (1 + np.abs(wanted).max()))


@given(q=angles, dq=speeds, ddq=accelerations)
def test_torque_of_links_and_payload_is_that_of_newton_and_euler(rigid, q, dq, ddq):
    torque = rigid.inverse_dynamics(q[None], dq[None], ddq[None], gravity=True)[0]
    assert_equal(torque, published.newton_euler(q, dq, ddq))


@given(q=angles)
def test_gravity_torque_is_that_of_newton_and_euler(rigid, q):
    still = np.zeros(6)
    assert_equal(rigid.gravity_torque(q[None])[0], published.newton_euler(q, still, still))


@given(q=angles)
def test_mass_matrix_is_that_of_newton_and_euler(rigid, q):
    columns = [published.newton_euler(q, np.zeros(6), unit, gravity=np.zeros(3)) for unit in np.eye(6)]
    assert_equal(rigid.mass_matrix(q[None])[0], np.array(columns))


@given(q=angles, dq=speeds)
def test_coriolis_torque_is_that_of_newton_and_euler(rigid, q, dq):
    torque = rigid.inverse_dynamics(q[None], dq[None], np.zeros((1, 6)))[0]
    assert_equal(torque, published.newton_euler(q, dq, np.zeros(6), gravity=np.zeros(3)))


@given(q=angles, dq=speeds, ddq=accelerations)
def test_motor_torque_adds_rotors_spring_and_friction_behind_the_published_gears(rigid, q, dq, ddq):
    ratio, parts = published.GEAR_RATIO, motor_torque(rigid, q[None], dq[None], ddq[None])
    still = np.zeros(6)
    assert_equal(parts.gravity[0], published.newton_euler(q, still, still) / ratio)
    assert_equal((parts.inertia + parts.gravity)[0], published.newton_euler(q, dq, ddq) / ratio)
    assert_equal(parts.rotors[0], ratio * published.ROTOR_INERTIA * ddq)
    assert_equal(parts.friction[0], rigid.robot.friction.steady_torque(ratio * dq))
    springs = rigid.spring_torque(q[None])[0] / ratio
    assert_equal(parts.total[0], parts.gravity[0] + parts.inertia[0] + springs + parts.rotors[0] + parts.friction[0])


def test_spring_follows_the_published_gas_law_over_the_range_of_axis_2(kr300, rigid):
    q = np.zeros((500, 6))
    q[:, 1] = np.linspace(*kr300.kinematics.range[1], len(q))
    torque, wanted = rigid.spring_torque(q), published.counterbalance_torque(q[:, 1])
    assert np.abs(torque[:, 1] - wanted).max() < 0.002 * np.abs(wanted).max()
    np.testing.assert_array_equal(torque[:, [0, 2, 3, 4, 5]], 0)


def test_spring_carries_the_arm_that_leans_forward_and_can_be_left_out(kr300, rigid):
    leaning = np.array([[0, np.radians(60), 0, 0, 0, 0]])
    alone, spring = rigid.gravity_torque(leaning)[0, 1], rigid.spring_torque(leaning)[0, 1]
    assert abs(alone + spring) < 0.5 * abs(alone)
    assert compile_model(kr300).ntendon == 1
    assert compile_model(kr300, ModelOptions(springs=False)).ntendon == 0
    assert not RigidArm(replace(kr300, springs=())).spring_torque(leaning).any()


def test_flange_stands_where_the_published_chain_puts_it(kr300, rigid):
    rng = np.random.default_rng(0)
    for q in rng.uniform(-3, 3, (20, 6)):
        frame, place = np.diag([1.0, -1.0, -1.0]), np.zeros(3)  # z of the published base points down
        for turn, origin in published.steps(q):
            place, frame = place + frame @ origin, frame @ turn
        tcp, tool0 = rigid.tcp_pose(q[None])
        np.testing.assert_allclose(tcp[0], place + frame @ kr300.tool.tcp, atol=1e-12)
        np.testing.assert_allclose(tool0[0][:, 2], frame[:, 2], atol=1e-12)


def test_arm_is_upright_and_forearm_level_at_zero(rigid):
    tcp, tool0 = rigid.tcp_pose(np.zeros((1, 6)))
    np.testing.assert_allclose(tcp[0], [0.35 + 1.0 + 0.24 + 0.35, 0, 0.675 + 1.15 - 0.041], atol=1e-12)
    np.testing.assert_allclose(tool0[0][:, 2], [1, 0, 0], atol=1e-12)


def test_lugre_parameters_are_the_line_through_the_published_law_at_recorded_speeds(kr300):
    speed = np.linspace(0, FASTEST, 1001)
    line = np.polynomial.Polynomial.fit(speed, np.tanh(KR300_FRICTION.slow_steepness * speed), 1).convert()
    ratio, (offset, slope) = published.GEAR_RATIO, line.coef
    coulomb = (KR300_FRICTION.step + offset * KR300_FRICTION.slow_step) / ratio
    viscous = (KR300_FRICTION.viscous + slope * KR300_FRICTION.slow_step) / ratio**2
    np.testing.assert_allclose(kr300.friction.coulomb, coulomb, rtol=1e-4)
    np.testing.assert_allclose(kr300.friction.viscous, viscous, rtol=1e-4)
    np.testing.assert_array_equal(kr300.friction.static, kr300.friction.coulomb)


def test_lugre_friction_is_the_symmetric_part_of_the_published_law_at_recorded_speeds(kr300):
    speed = np.linspace(0.005, FASTEST, 500)[:, None]
    symmetric = (KR300_FRICTION.torque(speed) - KR300_FRICTION.torque(-speed)) / 2
    lugre = published.GEAR_RATIO * kr300.friction.steady_torque(published.GEAR_RATIO * speed)
    assert np.abs(lugre - symmetric).max() < 4.0  # N m on the link side


def test_speed_limits_are_those_of_motors_at_4500_turns_a_minute(kr300):
    turns = kr300.kinematics.max_speed * published.GEAR_RATIO * 60 / (2 * np.pi)
    np.testing.assert_allclose(turns, 4500, rtol=0.004)


def test_motors_can_carry_the_payload_in_any_pose(kr300, rigid):
    q = np.random.default_rng(0).uniform(*kr300.kinematics.range.T, (5000, 6))
    held = (rigid.gravity_torque(q) + rigid.spring_torque(q)) / published.GEAR_RATIO
    assert np.all(np.abs(held).max(axis=0) < 0.5 * kr300.drive.peak_torque)
