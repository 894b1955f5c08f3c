"""What a recording says about each motor.

The motions that learning families are trained on.
"""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.agents.trials import (
    SIGNALS,
    Lesson,
    SimulatedTrial,
    every_speed,
    friction_motions,
    learning_signal,
    run_trial,
    thesis_motions,
    training_motions,
)
from ffgym.control import NoCompensation, StaticLuGre
from ffgym.core.errors import FFGymError
from ffgym.paths import joint_reference, joint_sine
from ffgym.robot import RigidArm
from ffgym.simulation import Resolver, Run
from ffgym.studies import circle_references


@pytest.fixture(scope="module")
def circle(arm):
    return circle_references(arm, ["p1"], [0.1], [0.001])["p1", 0.1]


@pytest.fixture(scope="module")
def recording(arm, circle):
    law = StaticLuGre(arm.robot.friction)
    return SimulatedTrial(arm=arm)([Run(reference=circle, law=law)], 0)[0]


def test_a_lesson_has_the_reference_the_torque_and_the_error_of_every_row(circle, recording):
    lesson = Lesson.of(circle, recording)
    at_samples = slice(None, None, 4)
    np.testing.assert_allclose(lesson.t[at_samples], circle.t, atol=1e-12)
    np.testing.assert_allclose(lesson.motor_dq[at_samples], circle.motor_dq, atol=1e-9)
    np.testing.assert_allclose(lesson.motor_ddq[at_samples], circle.motor_ddq, atol=1e-9)
    slope = np.gradient(lesson.motor_dq, lesson.t, axis=0)
    middle = lesson.moving & (np.roll(lesson.moving, 2) & np.roll(lesson.moving, -2))
    scale = np.abs(lesson.motor_ddq).max(axis=0)
    assert np.abs((slope - lesson.motor_ddq)[middle] / scale).max() < 0.1  # Hermite pieces against straight lines
    torque = StaticLuGre(circle.robot.friction).torque(circle)
    np.testing.assert_allclose(lesson.added[at_samples][1:], torque[1:], atol=1e-12)
    assert not lesson.moving[0]
    assert not lesson.moving[-1]
    assert np.abs(lesson.motor_dq[~lesson.moving]).max() < 0.02  # a step that straddles the border


def test_signals_are_what_the_thesis_calls_them(circle, recording):
    u_p, u_c, e_p = (learning_signal(recording, circle.robot, name) for name in SIGNALS)
    integral = recording.joint_array("feedback.integral")
    np.testing.assert_array_equal(u_p, u_c - integral)
    assert np.abs(integral).max() > 0.1  # gravity
    lesson = Lesson.of(circle, recording, "e_p")
    np.testing.assert_array_equal(lesson.signal, e_p)
    np.testing.assert_array_equal(e_p, circle.robot.servo.position_gain * lesson.error)


def test_a_wrong_signal_or_a_recording_of_another_motion_is_refused(arm, circle, recording):
    with pytest.raises(FFGymError, match=r"Unknown learning signal 'u_x'\. Available: e_p, u_c, u_p"):
        Lesson.of(circle, recording, "u_x")
    other = circle_references(arm, ["p1"], [0.04], [0.001])["p1", 0.04]
    with pytest.raises(FFGymError, match="not of the motion"):
        Lesson.of(other, recording)


def test_sensor_noise_differs_from_trial_to_trial_and_repeats_itself(one_axis):
    reference = joint_reference(one_axis, joint_sine([1.0], 1.0, 0.2))
    trial = SimulatedTrial(arm=RigidArm(one_axis), sensors=(Resolver(bits=10),))
    runs = [Run(reference=reference, law=NoCompensation())]
    np.testing.assert_array_equal(
        trial(runs, 3)[0].joint_array("motor.position"), trial(runs, 3)[0].joint_array("motor.position")
    )


def test_a_machine_that_loses_a_recording_is_named(one_axis):
    run = Run(reference=joint_reference(one_axis, joint_sine([1.0], 1.0, 0.2)))
    with pytest.raises(FFGymError, match="Trial 3 returned 1 recordings of 2 runs"):
        run_trial(lambda runs, number: SimulatedTrial(arm=RigidArm(one_axis))(runs, number)[1:], [run, run], 3)


def test_the_thesis_learns_at_p1_at_10_mm_s_and_on_the_sine_of_1_hz(arm, one_axis):
    assert [motion.name for motion in thesis_motions(arm)] == ["p1, 10 mm/s"]
    assert [motion.name for motion in thesis_motions(RigidArm(one_axis))] == ["sine 1 Hz"]


def test_every_speed_of_the_tests_can_be_shown(arm, one_axis):
    assert [motion.name for motion in every_speed(arm)] == ["p1, 10 mm/s", "p1, 40 mm/s", "p1, 100 mm/s"]
    assert [motion.name for motion in every_speed(RigidArm(one_axis))] == ["sine 1 Hz", "sine 3 Hz"]


def test_friction_is_learned_where_it_is_most_of_the_feedback(arm, one_axis):
    assert [motion.name for motion in friction_motions(arm)] == ["p1, 10 mm/s", "p1, 40 mm/s"]
    assert [motion.name for motion in friction_motions(RigidArm(one_axis))] == ["sine 1 Hz", "sine 3 Hz"]


def test_positions_and_speeds_can_be_chosen(arm):
    names = [motion.name for motion in training_motions(arm, ["p2", "p3"], [0.1])]
    assert names == ["p2, 100 mm/s", "p3, 100 mm/s"]


def test_a_robot_without_test_motion_is_refused(irb4600):
    arm = RigidArm(replace(irb4600, work_area=None))
    with pytest.raises(FFGymError, match="no test motion to learn on; give"):
        thesis_motions(arm)
