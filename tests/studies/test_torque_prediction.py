"""Prediction of recorded motor torque: exact on a recording of the same physics, and wrong where physics is missing."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.control import NoCompensation
from ffgym.core.errors import FFGymError
from ffgym.paths import joint_reference, joint_sine
from ffgym.published import KR300_FRICTION
from ffgym.recordings import Header, Recording
from ffgym.robot import RigidArm, load_robot, motor_torque
from ffgym.simulation import Run, simulate
from ffgym.studies.torque_prediction import predict_torque

T = 0.004 * np.arange(1500)
JOINTS = ("a1", "a2", "a3", "a4", "a5", "a6")


@pytest.fixture(scope="module")
def kr300():
    return load_robot("kuka_kr300_r2500")


def sway():
    """Position, speed and acceleration of joints that swing at 0.25 Hz, each in its own phase."""
    w, phase = 2 * np.pi * 0.25, np.arange(6)
    angle = w * T[:, None] + phase
    return 0.2 * np.sin(angle), 0.2 * w * np.cos(angle), -0.2 * w**2 * np.sin(angle)


def recorded(robot, position, torque, **header):
    columns = {"timestamp": T}
    for j, joint in enumerate(JOINTS):
        columns |= {f"motor.position.{joint}": position[:, j], f"motor.effort.{joint}": torque[:, j]}
    settings = {"position_side": "link", "torque_semantics": "motor_side"} | header
    gear_ratio = tuple(robot.drive.gear_ratio)
    return Recording(columns, Header(robot=robot.name, joints=JOINTS, gear_ratio=gear_ratio, **settings))


@pytest.fixture(scope="module")
def ideal(kr300):
    """Torque of the rigid arm with the published friction."""
    q, dq, ddq = sway()
    parts = motor_torque(RigidArm(kr300), q, dq, ddq)
    return replace(parts, friction=KR300_FRICTION.torque(dq) / kr300.drive.gear_ratio)


def shares(prediction, name):
    return np.array([error.share for error in prediction.errors(name)])


def test_torque_of_the_same_physics_is_predicted(kr300, ideal):
    prediction = predict_torque(kr300, recorded(kr300, sway()[0], ideal.total), KR300_FRICTION)
    assert shares(prediction, "published friction").max() < 0.01
    assert shares(prediction, "description").max() < 0.1  # the asymmetry is missing


def test_without_the_spring_only_axis_2_is_wrong(kr300, ideal):
    prediction = predict_torque(kr300, recorded(kr300, sway()[0], ideal.total), KR300_FRICTION)
    errors = shares(prediction, "without springs")
    assert errors[1] > 0.3
    assert np.delete(errors, 1).max() < 0.01


def test_sides_of_the_gearbox_make_no_difference(kr300, ideal):
    ratio, q = kr300.drive.gear_ratio, sway()[0]
    wanted = predict_torque(kr300, recorded(kr300, q, ideal.total))
    recording = recorded(kr300, q * ratio, ideal.total * ratio, position_side="motor", torque_semantics="link_side")
    prediction = predict_torque(kr300, recording)
    np.testing.assert_allclose(prediction.measured, wanted.measured, rtol=1e-12)
    np.testing.assert_allclose(prediction.predicted["description"], wanted.predicted["description"], rtol=1e-7)


def test_a_rest_is_not_scored(kr300, ideal):
    q = sway()[0]
    q[:300], q[-300:] = q[300], q[-301]
    prediction = predict_torque(kr300, recorded(kr300, q, ideal.total))
    assert not prediction.scored[:200].any()
    assert not prediction.scored[-200:].any()


def test_torque_of_a_simulated_robot_with_elastic_joints_is_predicted(kr300):
    path = joint_sine(np.full(6, 0.2), 0.25, 6.0, centre=kr300.work_area.home, dt=kr300.servo.control_dt)
    (recording,) = simulate([Run(reference=joint_reference(kr300, path), law=NoCompensation())])
    prediction = predict_torque(kr300, recording.slice(2.0))  # the sine begins at full speed
    assert shares(prediction, "description").max() < 0.15


@pytest.mark.parametrize(
    ("header", "cutoff", "message"),
    [
        ({"torque_semantics": "unspecified"}, 10.0, "does not say what its torque is"),
        ({}, 125.0, "must lie below 125 Hz"),
        ({}, 0.0, "cutoff"),
    ],
)
def test_a_recording_that_does_not_do_is_refused(kr300, ideal, header, cutoff, message):
    with pytest.raises(FFGymError, match=message):
        predict_torque(kr300, recorded(kr300, sway()[0], ideal.total, **header), cutoff=cutoff)


def test_joints_that_never_move_are_named(kr300, ideal):
    q = sway()[0]
    q[:, 3] = 0.1
    with pytest.raises(FFGymError, match=r"\['a4'\] never move"):
        predict_torque(kr300, recorded(kr300, q, ideal.total))


def test_the_wrong_robot_is_refused(kr300, one_axis, ideal):
    with pytest.raises(FFGymError, match="6 joints, robot 'one_axis' 1"):
        predict_torque(one_axis, recorded(kr300, sway()[0], ideal.total))
