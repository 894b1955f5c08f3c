"""Gains of a servo from torque beside set-points and angles: found, with what they are found from, or refused."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from ffgym.control import SetpointResponse
from ffgym.core.types import Array
from ffgym.diagnosis.identification.servo_equation import ServoLog, why_no_torque, with_angles
from ffgym.diagnosis.identification.servo_gains import GAINS, ServoFit, fit_servo, search_response
from ffgym.diagnosis.identification.setpoint_model import ResponseModel, SetpointLog
from ffgym.paths import joint_reference, joint_sine
from ffgym.recordings import Recording
from ffgym.robot import RigidArm, RobotDescription
from ffgym.simulation import Run, simulate
from tests.deployment.drive_samples import FACTORS, RESPONSE, log_of_drive, probe, with_other_gains


@pytest.fixture(scope="module")
def log(one_axis: RobotDescription) -> Recording:
    """Two seconds of a drive."""
    return log_of_drive(probe(one_axis, 2.0), with_other_gains(one_axis), one_axis)


def changed(recording: Recording, **change: Mapping[str, Array]) -> Recording:
    """Replace families of the one joint."""
    return recording.derive(dict(recording.columns) | {f"{name.replace('_', '.')}.j1": x for name, x in change.items()})


def fit(
    recording: Recording,
    robot: RobotDescription,
    response: SetpointResponse = RESPONSE,
    *,
    instruments: bool = False,
    covariance: Array | None = None,
) -> ServoFit:
    """Fit gains, with delay and filter as they are."""
    logs = [ServoLog.of(recording, RigidArm(robot), feedforward=True)]
    free = None
    if instruments:  # angles of the documented robot along the same set-points
        sent = SetpointLog.of(recording, robot)
        model = ResponseModel(arm=RigidArm(robot), logs=(sent,), n_threads=1)
        (residual,) = model.residuals([(response, np.zeros(3 * robot.n_joints))])
        free = with_angles(logs, [np.pad(sent.measured - residual, ((0, len(recording) - len(residual)), (0, 0)))])
    return fit_servo(
        logs,
        robot.servo,
        response,
        np.random.default_rng(0),
        joints=robot.joints,
        instruments=free,
        covariance=covariance,
    )


def test_gains_are_found_whatever_the_friction_is(log: Recording, one_axis: RobotDescription) -> None:
    found = fit(log, one_axis)
    for estimate, factor in zip(found.estimates[0], FACTORS.values(), strict=True):
        assert estimate.is_identified
        assert estimate.value == pytest.approx(factor * estimate.prior, rel=0.02)
        assert estimate.low < factor * estimate.prior < estimate.high < 1.05 * estimate.value
    assert found.explained[0] > 0.999
    assert found.feedforward[0] == pytest.approx(1.0, abs=0.03)
    assert not found.refused


def test_delay_and_filter_are_found_with_the_gains(log: Recording, one_axis: RobotDescription) -> None:
    searched = search_response([ServoLog.of(log, RigidArm(one_axis), feedforward=True)])
    response = searched.response
    assert searched.total_spread < 0.2e-3
    assert response.total_delay == pytest.approx(RESPONSE.total_delay, abs=0.2e-3)
    found = fit(log, one_axis, response)
    assert found.servo.position_gain[0] == pytest.approx(1.4 * one_axis.servo.position_gain[0], rel=0.03)


def test_instruments_take_what_stepped_angles_do_to_least_squares(log: Recording, one_axis: RobotDescription) -> None:
    step = 2 * np.pi / 2**12
    rough = changed(log, motor_position=np.round(log["motor.position.j1"] / step) * step)
    plain, free = fit(rough, one_axis), fit(rough, one_axis, instruments=True)
    right = FACTORS["velocity_gain"] * one_axis.servo.velocity_gain[0]
    assert plain.estimates[0][1].high < 0.8 * right
    assert free.estimates[0][1].low < right < free.estimates[0][1].high
    assert free.servo.velocity_gain[0] == pytest.approx(right, rel=0.15)


def test_noise_of_torque_makes_intervals_wider_and_moves_nothing(log: Recording, one_axis: RobotDescription) -> None:
    noise = 0.05 * one_axis.friction.static[0] * np.random.default_rng(3).standard_normal(len(log))
    noisy = fit(changed(log, motor_effort=log["motor.effort.j1"] + noise), one_axis)
    for estimate, exact, name in zip(noisy.estimates[0], fit(log, one_axis).estimates[0], GAINS, strict=True):
        assert estimate.high - estimate.low > 1.5 * (exact.high - exact.low)
        assert estimate.low < FACTORS[name] * estimate.prior < estimate.high
    assert 0.7 < noisy.explained[0] < 0.99


def test_two_logs_tell_more_than_one(log: Recording, one_axis: RobotDescription) -> None:
    rng, arm = np.random.default_rng(3), RigidArm(one_axis)
    noise = 0.05 * one_axis.friction.static[0] * rng.standard_normal((2, len(log)))
    logs = [
        ServoLog.of(changed(log, motor_effort=log["motor.effort.j1"] + each), arm, feedforward=True) for each in noise
    ]
    one, two = (
        fit_servo(each, one_axis.servo, RESPONSE, np.random.default_rng(0), joints=one_axis.joints).estimates[0]
        for each in (logs[:1], logs)
    )
    for name, alone, together in zip(GAINS, one, two, strict=True):
        assert together.high - together.low < 0.9 * (alone.high - alone.low)
        assert together.low < FACTORS[name] * together.prior < together.high


def test_what_is_not_known_of_delay_and_filter_makes_intervals_wider(
    log: Recording, one_axis: RobotDescription
) -> None:
    sure, unsure = (fit(log, one_axis, covariance=np.diag(np.square(spread))) for spread in ([1e-6] * 2, [5e-4] * 2))
    for narrow, wide in zip(sure.estimates[0][:2], unsure.estimates[0][:2], strict=True):
        assert wide.high - wide.low > 1.5 * (narrow.high - narrow.low)


def test_a_filter_at_its_bound_adds_nothing_to_intervals(log: Recording, one_axis: RobotDescription) -> None:
    alone, beside = (fit(log, one_axis, covariance=np.diag(spread)) for spread in ([1e-8], [1e-8, 0.0]))
    for one, other in zip(alone.estimates[0], beside.estimates[0], strict=True):
        assert np.isfinite(other.high)
        assert (one.low, one.high) == (other.low, other.high)


def test_an_integral_that_a_log_does_not_show_stays_as_documented(one_axis: RobotDescription) -> None:
    slow = replace(one_axis, servo=replace(one_axis.servo, integral_gain=np.array([2.0])))
    log = log_of_drive(probe(slow, 1.2), with_other_gains(slow), slow)
    noise = 0.05 * slow.friction.static[0] * np.random.default_rng(3).standard_normal(len(log))
    found = fit(changed(log, motor_effort=log["motor.effort.j1"] + noise), slow)
    position, velocity, integral = found.estimates[0]
    assert integral.status == "wide"
    assert integral.value == integral.prior == found.servo.integral_gain[0] == 2.0
    assert "too wide" in integral.reason
    assert "longer or slower motion" in integral.reason
    assert position.is_identified
    assert velocity.is_identified


def test_a_joint_that_rests_is_refused(log: Recording, one_axis: RobotDescription) -> None:
    still = changed(log, reference_position=np.full(len(log), log["reference.position.j1"][0]))
    found = fit(still, one_axis)
    assert {each.status for each in found.refused} == {"not excited"}
    assert len(found.refused) == 3
    np.testing.assert_array_equal(found.servo.velocity_gain, one_axis.servo.velocity_gain)


def test_a_torque_that_is_not_the_servos_is_refused(log: Recording, one_axis: RobotDescription) -> None:
    found = fit(changed(log, motor_effort=log["motor.effort.j1"][::-1].copy()), one_axis)
    assert {each.status for each in found.refused} == {"not measured"}
    assert "it is another torque" in found.refused[0].reason
    assert found.explained[0] < 0.5


def test_feed_forward_that_was_recorded_is_taken_from_the_torque(one_axis: RobotDescription) -> None:
    reference = joint_reference(one_axis, joint_sine([0.1], 3.0, 2.0))
    (recording,) = simulate([Run(reference=reference)], record_dt=0.001)
    found = fit(recording, one_axis, SetpointResponse())
    for estimate in found.estimates[0][:2]:
        assert estimate.value == pytest.approx(estimate.prior, rel=0.03)
    assert np.isnan(found.feedforward[0])
    # another one than the controller's is not
    wrong = changed(recording, feedforward_effort=0 * recording["feedforward.effort.j1"])
    assert fit(wrong, one_axis, SetpointResponse()).estimates[0][0].value != pytest.approx(
        found.estimates[0][0].value, rel=0.05
    )


def test_rows_at_the_limit_of_the_drive_do_not_count(log: Recording, one_axis: RobotDescription) -> None:
    torque = log["motor.effort.j1"].copy()
    torque[200:220] = one_axis.drive.peak_torque[0]
    counts = ServoLog.of(changed(log, motor_effort=torque), RigidArm(one_axis), feedforward=True).counts[:, 0]
    assert not counts[190:230].any()
    assert counts[100:170].all()
    assert counts[260:400].all()


def test_it_says_why_no_torque_is_known(log: Recording) -> None:
    assert why_no_torque([log]) == ""
    without = log.derive({name: x for name, x in log.columns.items() if not name.startswith("motor.effort")})
    assert "has no motor torque (motor.effort)" in why_no_torque([log, without])
    untold = log.derive(log.columns, replace(log.header, hold="unspecified"))
    assert "hold of its header" in why_no_torque([untold])
    times = log.t.copy()
    times[50:] += 0.004
    assert "is sampled unevenly" in why_no_torque([log.derive(dict(log.columns) | {"timestamp": times})])
