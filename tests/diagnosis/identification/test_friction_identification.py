"""Friction is found again: a known truth goes in, and comes back within its interval, or the result says it cannot."""

from dataclasses import replace

import numpy as np
import pytest
from friction_samples import ladder, measured, sines

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.identification import friction_torques, identify_friction, predict_friction, validate
from ffgym.diagnosis.identification.bristle_fit import NAMES, fit_bristles
from ffgym.diagnosis.settings import settings, use_settings
from ffgym.published import ESTIMATION_RECORDS
from ffgym.robot import RigidArm

TOLERANCE = np.array([0.02, 0.02, 0.02, 0.1, 0.1, 0.1])
"""Relative, in the order of NAMES: f_c, f_s, f_v within 2 %, sigma_0 and sigma_1 within 10 %."""


def truth(robot, joint=0):
    return np.array([getattr(robot.friction, name)[joint] for name in NAMES])


def values(identification, joint=0):
    return np.array([estimate.value for estimate in identification.joints[joint].estimates])


@pytest.fixture(scope="module")
def axis(one_axis):
    return RigidArm(one_axis)


@pytest.fixture(scope="module")
def exact(axis):
    """Ladder, records 2, 4, 7, 9, 12, 14 of the thesis, and two that are not used."""
    return ladder(axis), sines(axis, ESTIMATION_RECORDS, record_dt=5e-4), sines(axis, (3, 13), record_dt=5e-4)


@pytest.fixture(scope="module")
def wrong(one_axis):
    """The model that is known before: older friction, and 5 % of the inertia missing, as thesis 6.1.2 estimates."""
    friction = one_axis.friction.scale(
        coulomb=0.7, static=1.1, viscous=1.5, stribeck_velocity=1.4, bristle_stiffness=2.0, bristle_damping=0.5
    )
    bodies = replace(one_axis.bodies, inertia=one_axis.bodies.inertia * 0.95)
    drive = replace(one_axis.drive, rotor_inertia=0.95 * one_axis.drive.rotor_inertia)
    return RigidArm(replace(one_axis, friction=friction, bodies=bodies, drive=drive))


@pytest.fixture(scope="module")
def found(exact, wrong):
    steady, moving, _ = exact
    torques = friction_torques(wrong, measured([*steady, *moving]))
    return identify_friction(torques, seed=0, n_resamples=200)


def test_friction_of_joint_1_is_found_from_the_records_of_the_thesis_with_a_wrong_model_before(found, one_axis):
    error = np.abs(values(found) / truth(one_axis) - 1)
    assert (error < TOLERANCE).all(), error
    assert all(estimate.status == "identified" for estimate in found.joints[0].estimates)
    assert found.joints[0].inertia_error == pytest.approx(0.05, abs=0.005)  # of the true one
    assert found.joints[0].notes == ()


def test_intervals_are_narrow_and_near_the_truth(found, one_axis):
    for estimate, true in zip(found.joints[0].estimates, truth(one_axis), strict=True):
        half = (estimate.high - estimate.low) / 2
        assert 0.0003 < half / true < 0.2
        assert estimate.low < estimate.value < estimate.high
        assert abs(estimate.value - true) < 3 * half


def test_intervals_reach_further_than_resamples_by_what_was_calibrated(found):
    joint, widened = found.joints[0], settings().friction.widened
    assert widened > 1
    for estimate, own in zip(
        joint.estimates, [*joint.stribeck.resampled.T[:4], *joint.bristles.resampled.T], strict=True
    ):
        ends = estimate.value + widened * (np.quantile(own, [0.05, 0.95]) - estimate.value)
        np.testing.assert_allclose([estimate.low, estimate.high], ends)


def test_new_parameters_explain_records_that_were_not_used_and_old_ones_do_not(found, exact, wrong):
    torques = friction_torques(wrong, measured(exact[2], seed=7))
    known = found.model_error
    for new, old in zip(
        validate(found.friction, torques, known), validate(wrong.robot.friction, torques, known), strict=True
    ):
        assert new.segment == old.segment
        assert new.share > 0.99
        assert new.rms_error < 0.25 * old.rms_error


def test_predicted_friction_is_that_of_the_plant(axis, exact):
    (torque, _) = friction_torques(axis, exact[2])
    true = torque.signals.low_pass(exact[2][0].joint_array("friction.effort"), torque.signals.dt)
    rows = slice(1500, -1500)
    assert np.abs(predict_friction(axis.robot.friction, torque) - true)[rows].max() < 0.02
    assert np.abs(torque.friction - true)[rows].max() < 0.01


def test_what_the_motions_do_not_excite_keeps_its_value_and_says_so(axis, wrong, exact):
    moving = exact[1]
    fast = friction_torques(wrong, ladder(axis, speeds=(2.0, 5.0, 9.0, 14.0)))
    (joint,) = identify_friction(fast, n_resamples=50).joints
    by_name = {estimate.name.split(".")[1]: estimate for estimate in joint.estimates}
    assert by_name["coulomb"].is_identified
    assert by_name["viscous"].is_identified
    for name in ("static", "stribeck_velocity", "bristle_stiffness", "bristle_damping"):
        estimate = by_name[name]
        assert not estimate.is_identified, name
        assert estimate.reason
        assert estimate.value >= estimate.prior  # f_s is at least f_c
        assert (estimate.low, estimate.high) == (0.0, np.inf)
    (joint,) = identify_friction(friction_torques(wrong, moving[:1]), n_resamples=50).joints
    assert [estimate.status for estimate in joint.estimates[:4]] == ["not excited"] * 4


def test_bristles_of_a_joint_without_a_stribeck_peak_are_found_with_intervals(found):
    static = np.array(
        [0.55, 0.55, 0.0437, 0.15]
    )  # f_c and f_s are the same, as a fit finds them where there is no peak
    [joint] = found.joints
    fit = fit_bristles(joint.bristles.data, static, np.tile(static, (20, 1)), np.random.default_rng(0))
    np.testing.assert_allclose(fit.values, joint.bristles.values, rtol=0.1)
    np.testing.assert_allclose(fit.resampled, np.tile(fit.values, (20, 1)), rtol=0.1)


def test_a_resample_without_viscous_friction_leaves_intervals_finite(found):
    [joint] = found.joints
    static = np.array([0.55, 0.55, 0.0437, 0.15])
    resampled = np.tile(static, (20, 1))
    resampled[3, 2] = 0.0
    fit = fit_bristles(joint.bristles.data, static, resampled, np.random.default_rng(0))
    assert np.isfinite(fit.resampled).all()


def test_a_given_stribeck_velocity_is_kept(wrong, exact):
    torques = friction_torques(wrong, measured(exact[0]))
    (joint,) = identify_friction(torques, stribeck_velocity={"j1": 0.15}, n_resamples=50).joints
    assert joint.estimates[3].value == 0.15
    assert joint.estimates[3].status == "given"


def test_thresholds_are_those_that_hold_while_friction_is_identified(wrong, exact):
    torques = friction_torques(wrong, measured(exact[0]))
    with use_settings({"friction.wide": 1e-6}):
        (strict,) = identify_friction(torques, n_resamples=50).joints
    with use_settings({"friction.fewest_runs": 1000}):
        (none,) = identify_friction(torques, n_resamples=50).joints
    assert [estimate.status for estimate in strict.estimates[:4]] == ["wide"] * 4
    assert none.stribeck is None


def test_both_directions_that_differ_are_told_not_averaged_away(axis, exact):
    (steady,) = exact[0]
    speed = steady["motor.velocity.j1"]
    uneven = steady["motor.effort.j1"] + 0.03 + 0.004 * np.abs(speed)
    torques = friction_torques(axis, measured([steady.with_columns({"motor.effort.j1": uneven})]))
    (joint,) = identify_friction(torques, n_resamples=100).joints
    assert joint.stribeck.offset == pytest.approx(0.03, abs=0.003)
    assert joint.stribeck.asymmetry == pytest.approx(0.004, rel=0.1)
    assert any("offset" in note for note in joint.notes)
    assert any("differs between directions" in note for note in joint.notes)
    np.testing.assert_allclose(values_of(joint)[:3], truth(axis.robot)[:3], rtol=0.02)


def values_of(joint):
    return np.array([estimate.value for estimate in joint.estimates])


def test_one_direction_only_is_told(axis, exact):
    (steady,) = exact[0]
    (torque,) = friction_torques(axis, [steady])
    forward = replace(torque, valid=torque.valid & (torque.signals.motor_dq[:, 0] > 0))
    (joint,) = identify_friction([forward], n_resamples=50).joints
    assert any("one direction only" in note for note in joint.notes)
    assert joint.stribeck.offset == 0.0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"stribeck_velocity": {"j1": -1.0}}, r"stribeck_velocity of j1 = -1.0 rad/s is out of range"),
        ({"seed": -1}, "seed = -1.0 is out of range"),
        ({"torques": ["log"]}, "torque must be a FrictionTorque, got str; friction_torques makes them of recordings"),
    ],
)
def test_an_option_that_makes_no_sense_is_refused_by_name(wrong, exact, options, message):
    torques = friction_torques(wrong, exact[0][:1])
    with pytest.raises(FFGymError, match=message):
        identify_friction(**{"torques": torques} | options)


def test_same_seed_gives_the_same_bits_and_joints_can_be_chosen(wrong, exact):
    torques = friction_torques(wrong, measured([*exact[0], *exact[1][:2]]))
    once, again = (identify_friction(torques, seed=3, n_resamples=8) for _ in range(2))
    assert once.joints[0].estimates == again.joints[0].estimates
    with pytest.raises(FFGymError, match=r"Unknown joint 'j7'. Available: j1"):
        identify_friction(torques, joints=["j7"])
    with pytest.raises(FFGymError, match="no recordings"):
        identify_friction([])
