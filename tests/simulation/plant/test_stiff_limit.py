"""The flexible arm becomes the rigid one as its joints stiffen."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.robot import ModelOptions, RigidArm
from ffgym.simulation.plant import Plant
from scripts.tables.physics import free_of_servo
from tests.simulation.plant.driving import controls

DURATION = 0.3
PHYSICS_DT = 0.0000625
FACTORS = (10.0, 100.0, 1000.0)


def pushed(robot, corner, friction):
    """Motor and link angles, link side [rad], under the same torques: rigid gravity and a sine on every motor."""
    plant = Plant(robot, 1, options=ModelOptions(friction=friction, physics_dt=PHYSICS_DT, looks=False))
    arm = RigidArm(robot)
    plant.rest(corner[None])
    n = round(DURATION / PHYSICS_DT)
    phase = 2 * np.pi * np.arange(n) / n
    torque = arm.gravity_torque(corner[None]) / robot.drive.gear_ratio
    torque = torque + np.array([3, 5, 3, 0.3, 0.3, 0.2]) * np.sin(phase)[:, None]
    state = plant.unpack(*(x[0] for x in plant.advance(controls(plant, torque=torque[None]))))
    return state.motor_position[15::16] / robot.drive.gear_ratio, state.link_position[15::16]


def stiffened(robot, factor):
    """Copy with stiffness and damping times `factor`; inf is rigid."""
    damping = np.zeros(6) if np.isinf(factor) else robot.drive.joint_damping * factor
    return replace(
        robot, drive=replace(robot.drive, joint_stiffness=robot.drive.joint_stiffness * factor, joint_damping=damping)
    )


@pytest.mark.parametrize("friction", [False, True])
def test_difference_to_the_rigid_arm_falls_as_one_over_stiffness(irb4600, corners, friction):
    robot = free_of_servo(irb4600)
    rigid = pushed(stiffened(robot, np.inf), corners["p2"], friction)
    np.testing.assert_allclose(rigid[0], rigid[1], atol=1e-15)
    differences = []
    for factor in FACTORS:
        flexible = pushed(stiffened(robot, factor), corners["p2"], friction)
        differences.append([np.abs(a - b).max() for a, b in zip(flexible, rigid, strict=True)])
    ratios = np.array(differences)[:-1] / np.array(differences)[1:]
    np.testing.assert_allclose(ratios, 10.0, rtol=0.05)
    travel = np.ptp(rigid[0], axis=0).max()
    assert np.max(differences[-1]) < 1e-3 * travel


def test_a_rigid_robot_has_one_hinge_per_joint(irb4600):
    plant = Plant(stiffened(irb4600, np.inf), 1)
    assert plant.model.nq == 6
    assert not plant.addresses.is_elastic.any()


def test_a_flexible_robot_built_rigid_rests_undeflected_and_its_integral_holds_gravity(irb4600, arm, corners):
    plant = Plant(irb4600, 1, options=ModelOptions(flexible=False, looks=False))
    plant.rest(corners["p2"][None])
    state = plant.state()
    np.testing.assert_allclose(state.link_position[0], corners["p2"], atol=1e-15)
    held = irb4600.servo.integral_gain * state.integral * irb4600.drive.gear_ratio
    np.testing.assert_allclose(held, arm.gravity_torque(corners["p2"][None]), atol=1e-9)


def test_robots_may_mix_rigid_and_elastic_joints(irb4600, corners):
    stiffness = irb4600.drive.joint_stiffness.copy()
    stiffness[[0, 3]] = np.inf
    mixed = replace(irb4600, drive=replace(irb4600.drive, joint_stiffness=stiffness))
    plant = Plant(mixed, 1)
    plant.rest(corners["p1"][None])
    state = plant.state()
    deflection = (state.link_position - state.motor_position / mixed.drive.gear_ratio)[0]
    np.testing.assert_allclose(deflection[[0, 3]], 0, atol=1e-16)
    assert np.abs(deflection[1]) > 1e-4
