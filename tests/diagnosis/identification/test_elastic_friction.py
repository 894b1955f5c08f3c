"""Friction behind gravity, inertia and elastic joints: two joints from one set of recordings."""

from dataclasses import replace

import numpy as np
import pytest
from friction_samples import ladder, measured, sines

from ffgym.core.measures import rms
from ffgym.diagnosis.identification import friction_torque, friction_torques, identify_friction
from ffgym.diagnosis.identification.bristle_fit import NAMES
from ffgym.robot import RigidArm, load_robot


@pytest.fixture(scope="module")
def two_link():
    return RigidArm(load_robot("two_link"))


@pytest.fixture(scope="module")
def moving(two_link):
    """Records 4 and 15 of both joints; record 15 runs at 5 Hz and 10 rad/s."""
    return sines(two_link, (4, 15), physics_dt=2.5e-4, least=2.0)


def test_friction_torque_is_the_plants_through_gravity_and_bending_joints(two_link, moving):
    for recording in moving:
        torque = friction_torque(two_link, recording)
        true = torque.signals.low_pass(recording.joint_array("friction.effort"), torque.signals.dt)
        assert rms((torque.friction - true)[torque.valid]) < 0.03 * rms(true[torque.valid])


def test_taken_as_rigid_joints_cost_much_of_the_friction_at_5_hz(two_link, moving):
    stiff = replace(two_link.robot.drive, joint_stiffness=np.full(2, np.inf), joint_damping=np.zeros(2))
    rigid = RigidArm(replace(two_link.robot, drive=stiff))
    fast = moving[1]
    true = fast.joint_array("friction.effort")
    elastic_error, rigid_error = (
        rms((torque.friction - true)[torque.valid, 0])
        for torque in (friction_torque(two_link, fast), friction_torque(rigid, fast))
    )
    assert rigid_error > 5 * elastic_error
    assert rigid_error > 0.1  # N m, of a Coulomb torque of 0.54


def test_wrong_rotors_and_links_are_told_apart_by_the_bending_that_they_cause(two_link, moving):
    robot = two_link.robot
    bodies = replace(robot.bodies, inertia=0.9 * robot.bodies.inertia)
    drive = replace(robot.drive, rotor_inertia=0.95 * robot.drive.rotor_inertia)
    wrong = RigidArm(replace(robot, bodies=bodies, drive=drive))
    true, known = friction_torque(two_link, moving[1]), friction_torque(wrong, moving[1])
    rows = known.valid
    missing = (known.friction - true.friction)[rows, 0]
    by_links, rotor = known.by_links[rows, 0], (known.by_inertia - known.by_links)[rows, 0]

    def left(*columns):
        """Share of what is missing that shares of some inertias do not explain, and the shares."""
        shares, *_ = np.linalg.lstsq(np.stack(columns, axis=1), missing)
        return rms(missing - np.stack(columns, axis=1) @ shares) / rms(missing), shares

    share, (of_rotor, of_links) = left(rotor, by_links)
    assert share < 0.25
    assert of_rotor == pytest.approx(1 / 0.95 - 1, rel=0.25)
    assert 0 < of_links < 0.11  # part of the links' inertia is that of their centres of mass
    without_bending = left(rotor, known.inertia[rows, 0] - rotor)
    assert without_bending[0] > 2 * share


def test_a_wrong_joint_stiffness_is_missing_as_its_derivative_says(two_link, moving):
    drive = replace(two_link.robot.drive, joint_stiffness=0.995 * two_link.robot.drive.joint_stiffness)
    true = friction_torque(two_link, moving[1])
    known = friction_torque(RigidArm(replace(two_link.robot, drive=drive)), moving[1])
    rows = known.valid
    missing = (known.friction - true.friction)[rows]
    explained = (1 / 0.995 - 1) * known.by_springs[rows]
    assert rms(missing) > 1e-4
    assert rms(missing - explained) < 0.1 * rms(missing)


def test_a_record_that_begins_in_motion_counts_from_when_the_arm_no_longer_swings(two_link, moving):
    whole, cut = friction_torque(two_link, moving[0]), friction_torque(two_link, moving[0].slice(1.4))
    assert whole.valid[40:-40].all()
    assert not cut.valid[:1000].any()


def test_both_joints_are_found_from_one_set_of_recordings(two_link, moving):
    speeds = (0.03, 0.08, 0.15, 0.25, 0.6, 3.0, 9.0)
    recordings = measured([*ladder(two_link, speeds=speeds), *moving], noise=0.02)
    wrong = two_link.robot.friction.scale(coulomb=0.7, static=1.2, bristle_stiffness=1.5, bristle_damping=0.5)
    known = RigidArm(replace(two_link.robot, friction=wrong))
    found = identify_friction(friction_torques(known, recordings), n_resamples=60)
    for name, tolerance in zip(NAMES, (0.02, 0.02, 0.02, 0.15, 0.1, 0.1), strict=True):
        true = getattr(two_link.robot.friction, name)
        np.testing.assert_allclose(getattr(found.friction, name), true, rtol=tolerance, err_msg=name)
    assert all(estimate.is_identified for joint in found.joints for estimate in joint.estimates)
