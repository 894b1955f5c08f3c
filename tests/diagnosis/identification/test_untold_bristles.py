"""What does not tell bristles says so throughout: a joint that others only shake, an inertia that is wrong."""

from dataclasses import replace

import numpy as np
import pytest
from friction_samples import ladder, measured, sines

from ffgym.diagnosis.identification import friction_torques, identify_friction
from ffgym.diagnosis.identification.friction import friction_quantities
from ffgym.robot import RigidArm


@pytest.fixture(scope="module")
def shaken(one_axis):
    """A joint that rests in a ladder, and in a fast sine goes to and fro within its bristles."""
    arm = RigidArm(one_axis)
    (sine,) = sines(arm, (15,), physics_dt=2.5e-4, least=2.0)
    (small,) = friction_torques(arm, [sine])
    share = 0.01
    signals = replace(small.signals, dq=share * small.signals.dq)
    assert np.abs(signals.motor_dq).max() > 0.05
    return arm, replace(small, signals=signals)


def test_a_joint_that_is_shaken_is_not_excited_and_nothing_of_it_is_written(shaken):
    _, torque = shaken
    found = identify_friction([torque], n_resamples=20)
    (joint,) = found.joints
    assert {estimate.status for estimate in joint.estimates} == {"not excited"}
    assert joint.estimates[5].reason == "no record in which it reverses"
    assert friction_quantities(found) == {}
    assert (joint.inertia_error, joint.offset) == (0.0, 0.0)


def test_bristles_are_not_identified_on_a_coulomb_torque_that_is_not(one_axis):
    arm = RigidArm(one_axis)
    torques = friction_torques(arm, measured(sines(arm, (9,), physics_dt=2.5e-4, least=2.0)))
    (joint,) = identify_friction(torques, n_resamples=20).joints
    assert {estimate.status for estimate in joint.estimates} == {"not excited"}
    assert joint.estimates[4].reason == "f_c is not identified, on which bristles rest"


def test_a_shaken_record_beside_a_ladder_tells_no_bristles(shaken):
    arm, torque = shaken
    (joint,) = identify_friction([*friction_torques(arm, ladder(arm)), torque], n_resamples=20).joints
    assert joint.estimates[0].is_identified
    assert {estimate.status for estimate in joint.estimates[4:]} == {"not excited"}


def test_bristles_are_not_believed_beside_an_inertia_that_is_wrong_by_more_than_is_allowed_for(one_axis):
    arm = RigidArm(one_axis)
    bodies = replace(one_axis.bodies, inertia=one_axis.bodies.inertia * 0.5)
    drive = replace(one_axis.drive, rotor_inertia=0.5 * one_axis.drive.rotor_inertia)
    light = RigidArm(replace(one_axis, bodies=bodies, drive=drive))
    records = [*ladder(arm), *sines(arm, (9, 12), physics_dt=2.5e-4, least=3.0)]
    (joint,) = identify_friction(friction_torques(light, measured(records)), n_resamples=20).joints
    assert [estimate.status for estimate in joint.estimates[4:]] == ["at bound", "at bound"]
    assert any("inertia of the model seems wrong by 50%" in note for note in joint.notes)
