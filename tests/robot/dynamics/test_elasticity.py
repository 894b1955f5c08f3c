"""Gravity sag and resonances of the flexible arm."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh

from ffgym.robot import RigidArm, resonances, static_deflection
from scripts.engine.second.arm import PinocchioArm


def test_springs_carry_gravity_in_the_bent_pose(irb4600, arm, corners):
    motor_q = np.array(list(corners.values()))
    deflection = static_deflection(arm, motor_q)
    independent = PinocchioArm(irb4600)
    for q, delta in zip(motor_q, deflection, strict=True):
        spring = irb4600.drive.joint_stiffness * delta
        np.testing.assert_allclose(spring, -independent.gravity_torque(q + delta), atol=1e-8)


@pytest.mark.parametrize(("name", "sag"), [("p1", 1.9e-3), ("p4", 1.9e-3), ("p2", 3.3e-3), ("p3", 3.3e-3)])
def test_the_tool_sags_down_by_millimetres_and_further_out_by_more(arm, corners, name, sag):
    q = corners[name][None]
    moved = arm.tcp_pose(q + static_deflection(arm, q))[0] - arm.tcp_pose(q)[0]
    assert moved[0, 2] == pytest.approx(-sag, rel=0.3)
    assert np.abs(moved[0, :2]).max() < 0.5 * sag


def test_deflection_of_a_pose_does_not_depend_on_the_other_poses(arm):
    poses = np.random.default_rng(0).uniform(-1, 1, (50, 6))
    together = static_deflection(arm, poses)
    alone = np.concatenate([static_deflection(arm, pose[None]) for pose in poses])
    np.testing.assert_array_equal(together, alone)


@pytest.mark.parametrize("name", ["p1", "p2", "p3", "p4"])
def test_lowest_resonance_with_locked_motors_is_near_ten_hertz(arm, corners, name):
    assert 9.0 <= resonances(arm, corners[name])[0] <= 11.0


@pytest.mark.parametrize("name", ["p1", "p2"])
def test_resonances_are_the_eigenvalues_of_springs_and_independent_inertia(irb4600, arm, corners, name):
    drive, mass = irb4600.drive, PinocchioArm(irb4600).mass_matrix(corners[name])
    stiffness = np.diag(drive.joint_stiffness)
    locked = np.sqrt(eigh(stiffness, mass, eigvals_only=True)) / (2 * np.pi)
    np.testing.assert_allclose(resonances(arm, corners[name]), locked, rtol=1e-9)
    # free motors: link and motor angles side by side, the spring between them
    rotors = np.diag(drive.gear_ratio**2 * drive.rotor_inertia)
    both_mass = np.block([[mass, np.zeros((6, 6))], [np.zeros((6, 6)), rotors]])
    both_springs = np.block([[stiffness, -stiffness], [-stiffness, stiffness]])
    free = np.sqrt(np.maximum(eigh(both_springs, both_mass, eigvals_only=True), 0))[6:] / (2 * np.pi)
    np.testing.assert_allclose(resonances(arm, corners[name], "free"), free, rtol=1e-9)


def test_a_rigid_joint_has_no_resonance(one_axis):
    for motors in ("locked", "free"):
        assert resonances(RigidArm(one_axis), np.zeros(1), motors).size == 0


@pytest.mark.parametrize("motors", ["locked", "free"])
def test_a_rigid_joint_is_the_limit_of_a_stiff_one(irb4600, corners, motors):
    def with_wrist(stiffness):
        values = irb4600.drive.joint_stiffness.copy()
        values[3:] = stiffness
        return RigidArm(replace(irb4600, drive=replace(irb4600.drive, joint_stiffness=values)))

    rigid = resonances(with_wrist(np.inf), corners["p1"], motors)
    assert rigid.shape == (3,)
    np.testing.assert_allclose(rigid, resonances(with_wrist(1e12), corners["p1"], motors)[:3], rtol=1e-5)
