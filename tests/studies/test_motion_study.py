"""The study of any motion: what it scores is what its recordings hold."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.control import DynamicLuGreExact, NoCompensation
from ffgym.core.errors import FFGymError
from ffgym.paths import constant_velocity, joint_reference, joint_sine
from ffgym.paths.excitations import joint_path
from ffgym.paths.motion import standstill
from ffgym.recordings.metrics import contour_errors, motor_error, motor_error_rms
from ffgym.robot import ModelOptions, RigidArm
from ffgym.simulation import Run, SimulatedRig, sensors_of, simulate
from ffgym.studies import circle_references, motion_study


@pytest.fixture(scope="module")
def circle(arm):
    return next(iter(circle_references(arm, ["p1"], [0.1], [0.001]).values()))


@pytest.fixture(scope="module")
def study(irb4600, arm, circle):
    return motion_study(
        [circle], laws=[NoCompensation(), DynamicLuGreExact(irb4600.friction)], rig=SimulatedRig(arm=arm)
    )


def sine(robot, frequency=3.0):
    path = joint_sine([0.2] * robot.n_joints, frequency, 0.5, dt=robot.servo.control_dt, name=f"sine {frequency:g}")
    return joint_reference(robot, path)


def test_recordings_are_those_of_simulate(study, arm, circle):
    assert [(r.agent, r.motion) for r in study.results] == list(study.recordings)
    assert study.agents == ["none", "lugre_dynamic"]
    (alone,) = simulate([Run(reference=circle)], arm=arm)
    assert study.recordings["none", circle.name].equals(alone)
    assert study.fingerprint == alone.header.provenance["physics_fingerprint"]


def test_errors_are_those_of_the_metrics_without_standstill(study):
    for result in study.results:
        recording = study.recordings[result.agent, result.motion]
        moving = ~recording.mask(kind="standstill")
        np.testing.assert_allclose(result.motor_rms_rad, motor_error_rms(recording), rtol=1e-15)
        np.testing.assert_array_equal(result.motor_max_rad, np.abs(motor_error(recording)[moving]).max(axis=0))
        for stretch, error in zip(result.path, contour_errors(recording), strict=True):
            assert (stretch.label, stretch.start, stretch.end) == (error.label, error.start, error.end)
            figures = (stretch.rms_mm, stretch.max_mm, stretch.lag_rms_mm, stretch.lag_max_mm)
            np.testing.assert_allclose(figures, np.array([error.rms, error.max, error.lag_rms, error.lag_max]) * 1e3)


def test_use_of_torque_and_speed_is_relative_to_the_limits(study, irb4600, circle):
    for result in study.results:
        recording = study.recordings[result.agent, result.motion]
        torque = np.abs(recording.joint_array("command.effort")).max(axis=0)
        np.testing.assert_allclose(np.array(result.torque_use) * irb4600.drive.peak_torque, torque)
        speed = np.abs(circle.dq).max(axis=0)
        np.testing.assert_allclose(np.array(result.speed_use) * irb4600.kinematics.max_speed, speed)
        assert 0 < max(result.torque_use) < 1
        assert 0 < max(result.speed_use) < 1


def test_a_robot_without_a_tool_is_scored_at_its_motors(one_axis):
    (result,) = motion_study([sine(one_axis)], laws=[NoCompensation()]).results
    assert result.path == []
    assert result.motor_max_rad[0] >= result.motor_rms_rad[0] > 0


def test_sensors_without_a_tracker_leave_no_path_error(irb4600, arm, circle):
    resolver = sensors_of(irb4600)[:1]
    (blind,) = motion_study([circle], laws=[NoCompensation()], rig=SimulatedRig(arm=arm, sensors=resolver)).results
    assert blind.path == []
    (seen,) = motion_study(
        [circle], laws=[NoCompensation()], rig=SimulatedRig(arm=arm, sensors=sensors_of(irb4600)), seed=1
    ).results
    assert seen.path[0].rms_mm > 0


def test_options_and_sample_time_reach_the_plant(one_axis):
    rig = SimulatedRig(arm=RigidArm(one_axis), options=ModelOptions(friction=False, looks=False))
    smooth = motion_study([sine(one_axis)], laws=[NoCompensation()], rig=rig, record_dt=0.004)
    (recording,) = smooth.recordings.values()
    assert recording.dt == pytest.approx(0.004)
    assert not recording.joint_array("friction.effort").any()


def test_several_motions_run_side_by_side(one_axis):
    study = motion_study([sine(one_axis, 1.0), sine(one_axis, 3.0)], laws=[NoCompensation()])
    assert [r.motion for r in study.results] == ["sine 1", "sine 3"]
    (alone,) = motion_study([sine(one_axis, 3.0)], laws=[NoCompensation()]).results
    assert alone == study.results[1]


@pytest.mark.parametrize("case", ["none", "twins", "no law", "two laws of one name"])
def test_a_study_without_motions_or_with_names_that_clash_is_refused(case, one_axis):
    motions = {"none": [], "twins": [sine(one_axis), sine(one_axis)]}.get(case, [sine(one_axis)])
    laws = {"no law": [], "two laws of one name": [NoCompensation()] * 2}.get(case, [NoCompensation()])
    with pytest.raises(FFGymError, match="different names"):
        motion_study(motions, laws=laws)


def test_a_motion_that_is_all_standstill_is_refused(one_axis):
    rest = joint_reference(one_axis, joint_path("rest", [standstill("rest", np.zeros(1), 0.1)], 0.004))
    with pytest.raises(FFGymError, match="'rest' is all standstill"):
        motion_study([rest], laws=[NoCompensation()])


def test_motions_of_two_robots_are_refused(one_axis, irb4600):
    run = constant_velocity([0.1] + [0.0] * 5, 0.1, start=irb4600.work_area.home, dt=0.004, name="run")
    with pytest.raises(FFGymError, match="share one robot"):
        motion_study([sine(one_axis), joint_reference(irb4600, run)], laws=[NoCompensation()])


def test_drives_that_cannot_give_what_is_asked_are_named(one_axis):
    easy = motion_study([sine(one_axis)], laws=[NoCompensation()])
    assert easy.overloads == []
    weak = replace(one_axis, drive=replace(one_axis.drive, peak_torque=np.array([1e-3])))
    hard = motion_study([sine(weak)], laws=[NoCompensation()])
    (sentence,) = hard.overloads
    assert f"sine 3 with law 'none' asks {hard.results[0].torque_use[0]:.0%} of the peak torque of j1" in sentence
