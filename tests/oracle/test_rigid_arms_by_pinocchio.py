"""Kinematics and rigid dynamics of arms against Pinocchio: two engines that share only the description."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ffgym.robot import RigidArm, builtin_parameters, builtin_robots, load_robot
from ffgym.robot.description import with_payload
from scripts.engine.second.arm import PinocchioArm
from tests.oracle.comparing import ROUNDING, relative
from tests.robot.arm_samples import ARMS, random_arm

TYPES = ("R", "P", "RR", "RP", "PR", "PRP", "RRR", "RRPR", "PPP", "RRRRR", "RRRRRR", "PRRRRRR", "RRRRRRR", "PRPRPRPR")
"""Random arms of one to eight joints; every joint before and behind every other kind."""


def differences(arm, other, rng, n_poses=20, least=0.0):
    """Largest difference of each quantity at random states, as a share of its largest value, see `relative`."""
    q, dq, ddq = rng.uniform(-3, 3, (3, n_poses, arm.robot.n_joints))
    mass, bias = arm.equations_of_motion(q, dq, gravity=True)
    pairs = [
        ("mass matrix", arm.mass_matrix(q), other.mass_matrix, (q,)),
        ("mass matrix beside bias", mass, other.mass_matrix, (q,)),
        ("bias", bias, other.bias, (q, dq)),
        ("gravity", arm.gravity_torque(q), other.gravity_torque, (q,)),
        ("inverse dynamics", arm.inverse_dynamics(q, dq, ddq, gravity=True), other.inverse_dynamics, (q, dq, ddq)),
        ("springs between links", arm.spring_torque(q), other.spring_torque, (q,)),
    ]
    if arm.robot.tool is not None:
        position, rotation, jacobian = arm.pose_and_jacobian(q)
        pairs += [
            ("TCP", position, lambda q: other.tcp_pose(q)[0], (q,)),
            ("TCP alone", arm.tcp_position(q), lambda q: other.tcp_pose(q)[0], (q,)),
            ("TCP of the pose", arm.tcp_pose(q)[0], lambda q: other.tcp_pose(q)[0], (q,)),
            ("orientation", rotation, lambda q: other.tcp_pose(q)[1], (q,)),
            ("Jacobian", jacobian, other.jacobian, (q,)),
            ("bias acceleration", arm.bias_acceleration(q, dq), other.bias_acceleration, (q, dq)),
        ]
    return {
        name: relative(found, [ask(*row) for row in zip(*rows, strict=True)], least) for name, found, ask, rows in pairs
    }


def too_large(found):
    return {name: value for name, value in found.items() if not value < ROUNDING}


@pytest.mark.parametrize("name", [*builtin_robots(), *builtin_parameters()])
def test_both_engines_agree_to_rounding_on_every_robot_that_ships(name):
    robot = load_robot(name)
    assert not too_large(differences(RigidArm(robot), PinocchioArm(robot), np.random.default_rng(0)))


@pytest.mark.parametrize("name", ARMS)
def test_both_engines_agree_to_rounding_on_arms_of_all_kinds(name):
    robot = ARMS[name]()
    assert not too_large(differences(RigidArm(robot), PinocchioArm(robot), np.random.default_rng(1)))


@settings(max_examples=40)
@given(types=st.sampled_from(TYPES), seed=st.integers(0, 2**32 - 1))
def test_both_engines_agree_to_rounding_on_any_chain_of_hinges_and_slides(types, seed):
    robot = random_arm(types, seed)
    # few poses, in which large terms may cancel: shares are of what a kilogram at a metre asks for at least
    assert not too_large(differences(RigidArm(robot), PinocchioArm(robot), np.random.default_rng(seed), 4, least=1.0))


@settings(max_examples=20)
@given(
    name=st.sampled_from([name for name in builtin_robots() if load_robot(name).tool is not None]),
    mass=st.floats(0.1, 200),
    offset=st.tuples(*[st.floats(-0.5, 0.5)] * 3).map(np.array),
    radius=st.floats(0.01, 0.5),
)
def test_a_payload_is_one_more_body_at_the_tool(name, mass, offset, radius):
    robot = load_robot(name)
    other = PinocchioArm(robot)
    other.add_body(mass, robot.tool.tcp + offset, mass * radius**2 * np.eye(3))
    found = differences(RigidArm(with_payload(robot, mass, offset, radius)), other, np.random.default_rng(2), n_poses=4)
    assert not too_large(found)
