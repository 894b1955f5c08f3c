"""The linear model answers added torque as the simulated robot does.

The correction is the least-squares solution, where no torque can be improved.

Errors at the control samples, from recordings at any rate, noisy or with holes.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import fftconvolve

from ffgym.agents.task_torques import MotionTorque, TaskTorques
from ffgym.agents.torque_response import NormOptimalStep, TorqueResponse, at_samples, circle_rms, task_error
from ffgym.core.errors import FFGymError
from ffgym.core.measures import rms_length
from ffgym.paths import joint_reference, joint_sine
from ffgym.recordings.metrics import motor_error, path_errors, standstill_offset
from ffgym.robot import RigidArm
from ffgym.simulation import LaserTracker, Run, simulate
from ffgym.studies import circle_references
from scripts.tables.physics import free_of_servo
from tests.robot.robot_samples import unusual


def without_bristles(robot):
    """The same robot with viscous friction alone, but for a billionth of the rest."""
    return replace(robot, friction=robot.friction.scale(coulomb=1e-9, static=1e-9, bristle_damping=0.0))


def pulse(reference, joint):
    """A smooth torque of 1 N m on one joint (T, N), from 0.1 s on for 0.1 s."""
    torque = np.zeros_like(reference.q)
    torque[:, joint] = np.where(np.abs(reference.t - 0.15) < 0.05, np.sin(np.pi * (reference.t - 0.1) / 0.1) ** 2, 0.0)
    return torque


def answer(arm, reference, torque, read):
    """What `torque` changes in the simulation, at the control samples."""
    tasks = (torque, np.zeros_like(torque))
    laws = [TaskTorques(tasks=(MotionTorque(name="a", q=reference.q, torque=u),)) for u in tasks]
    pushed, left = simulate([Run(reference=reference, law=law) for law in laws], arm=arm)
    return (read(pushed) - read(left))[:: round(reference.robot.servo.control_dt / pushed.dt)]


@pytest.mark.parametrize("joint", [0, 1, 2, 4])
def test_the_model_answers_as_the_simulated_arm(irb4600, joint):
    arm = RigidArm(without_bristles(irb4600))
    reference = circle_references(arm, ["p2"], [0.1], [0.001])["p2", 0.1]
    torque = pulse(reference, joint)
    for target, read in (("motor", lambda r: -motor_error(r)), ("tcp", lambda r: r.vector("tcp.position"))):
        simulated = answer(arm, reference, torque, read)
        predicted = TorqueResponse.of(arm, reference.q[0], target).along(torque)
        assert np.abs(predicted - simulated).max() < 0.03 * np.abs(simulated).max()  # physics step of 0.25 ms


def test_viscous_friction_on_the_arm_damps_the_arm(one_axis):
    drive = replace(one_axis.drive, joint_stiffness=np.array([21.0]), joint_damping=np.array([0.017]))
    robot = without_bristles(replace(one_axis, drive=drive))
    friction = robot.friction.scale(viscous=10.0)
    arms = [RigidArm(replace(robot, friction=friction).with_arm_share(share)) for share in (0.8, 0.0)]
    reference = joint_reference(arms[0].robot, joint_sine([0.1], 1.0, 0.6))
    torque = pulse(reference, 0)
    simulated = answer(arms[0], reference, torque, lambda recording: recording.joint_array("motor.position"))
    behind, before = (TorqueResponse.of(arm, reference.q[0], "motor").along(torque) for arm in arms)
    assert np.abs(behind - simulated).max() < 0.01 * np.abs(simulated).max()
    assert np.abs(before - simulated).max() > 0.03 * np.abs(simulated).max()


def test_the_model_answers_as_the_simulated_rigid_axis(one_axis):
    arm = RigidArm(without_bristles(one_axis))
    reference = joint_reference(arm.robot, joint_sine([0.1], 1.0, 0.6))
    torque = pulse(reference, 0)
    simulated = answer(arm, reference, torque, lambda recording: -motor_error(recording))
    predicted = TorqueResponse.of(arm, reference.q[0], "motor").along(torque)
    assert np.abs(predicted - simulated).max() < 0.01 * np.abs(simulated).max()


@pytest.mark.parametrize("joint", [0, 2, 3, 4])
def test_the_model_answers_on_a_rail_with_reversing_and_coupled_motors_and_a_counterbalance(irb4600, joint):
    robot = unusual(irb4600)
    strongly_coupled = replace(robot.drive, coupling=30 * robot.drive.coupling)
    arm = RigidArm(without_bristles(replace(robot, drive=strongly_coupled)))
    centre = np.array([0.2, 0.1, 0.2, 0.4, 0.6, 0.3])
    reference = joint_reference(arm.robot, joint_sine(np.zeros(6), 1.0, 0.6, centre=centre))
    torque = 0.3 * pulse(reference, joint)
    for target, read in (("motor", lambda r: -motor_error(r)), ("tcp", lambda r: r.vector("tcp.position"))):
        simulated = answer(arm, reference, torque, read)
        predicted = TorqueResponse.of(arm, reference.q[0], target).along(torque)
        assert np.abs(predicted - simulated).max() < 0.03 * np.abs(simulated).max()


def test_torque_samples_are_joined_by_straight_lines(irb4600, corners):
    finer = replace(irb4600, servo=replace(irb4600.servo, control_dt=0.002))
    coarse = np.random.default_rng(0).normal(size=(40, 6))
    coarse[0] = 0.0  # as every added torque
    fine = np.empty((79, 6))
    fine[::2], fine[1::2] = coarse, (coarse[1:] + coarse[:-1]) / 2
    for target in ("motor", "tcp"):
        rough = TorqueResponse.of(RigidArm(irb4600), corners["p1"], target).along(coarse)
        smooth = TorqueResponse.of(RigidArm(finer), corners["p1"], target).along(fine)
        np.testing.assert_allclose(smooth[::2], rough, rtol=1e-9, atol=1e-12 * np.abs(rough).max())


def test_a_target_that_does_not_exist_is_refused(arm, one_axis):
    with pytest.raises(FFGymError, match=r"Unknown target 'link'\. Available: motor, tcp"):
        TorqueResponse.of(arm, np.zeros(6), "link")
    with pytest.raises(FFGymError, match="has no tool, so it has no TCP"):
        TorqueResponse.of(RigidArm(one_axis), np.zeros(1), "tcp")


SAMPLES, REST = 60, 12_000
"""Length of the error, and of the rest after it, in which the slowest consequence of a torque dies away."""


def slope(response, error, torque, tolerance, scale):
    """Derivative of half the cost by each torque, and its part from the torques alone, (T, N) each."""
    left = error - response.along(torque)
    from_error = np.zeros_like(torque)
    for j in range(torque.shape[1]):
        impulse = np.zeros_like(torque)
        impulse[0, j] = 1.0
        answer = response.along(impulse)
        for i in range(error.shape[1]):  # correlation: what a torque does to all errors after it
            from_error[:, j] -= fftconvolve(left[::-1, i], answer[:, i])[: len(left)][::-1] / tolerance**2
    from_torque = torque / scale**2
    return from_error + from_torque, from_torque


@pytest.mark.parametrize(("target", "tolerance"), [("motor", 4e-3), ("tcp", 2e-5), ("tcp", 1e-4)])
def test_the_correction_is_the_least_squares_solution(arm, corners, target, tolerance):
    response = TorqueResponse.of(arm, corners["p1"], target)
    scale = arm.robot.friction.coulomb
    error = np.zeros((SAMPLES + REST, len(response.output)))
    bumps = np.random.default_rng(1).normal(size=error.shape[1])
    error[:SAMPLES] = 5 * tolerance * np.sin(np.linspace(0, np.pi, SAMPLES))[:, None] * bumps
    found = NormOptimalStep.of(response, tolerance, scale).correction(error)
    assert not found[0].any()
    total, from_torque = slope(response, error, found, tolerance, scale)
    inner = slice(1, 3 * SAMPLES)
    assert np.abs(total[inner]).max() < 1e-3 * np.abs(from_torque[inner]).max()


def test_a_smaller_tolerance_leaves_less_error_and_asks_for_more_torque(arm, corners):
    response = TorqueResponse.of(arm, corners["p3"], "tcp")
    error = 1e-4 * np.sin(np.arange(150) * 0.1)[:, None] * np.ones(3)
    left, asked = [], []
    for tolerance in (1e-4, 3e-5, 1e-5):
        torque = NormOptimalStep.of(response, tolerance, arm.robot.friction.coulomb).correction(error)
        left.append(np.linalg.norm(error - response.along(torque)))
        asked.append(np.linalg.norm(torque))
    assert left == sorted(left, reverse=True)
    assert asked == sorted(asked)


def test_no_error_needs_no_correction(arm, corners):
    response = TorqueResponse.of(arm, corners["p1"], "tcp")
    step = NormOptimalStep.of(response, 1e-5, arm.robot.friction.coulomb)
    assert not step.correction(np.zeros((30, 3))).any()


def test_a_tolerance_of_zero_and_a_servo_that_holds_nothing_are_refused(arm, irb4600, corners):
    response = TorqueResponse.of(arm, corners["p1"], "tcp")
    with pytest.raises(FFGymError, match=r"tolerance = 0\.0 rad or m is out of range"):
        NormOptimalStep.of(response, 0.0, irb4600.friction.coulomb)
    loose = TorqueResponse.of(RigidArm(free_of_servo(irb4600)), corners["p1"], "tcp")
    with pytest.raises(FFGymError, match="The servo must hold every motor"):
        NormOptimalStep.of(loose, 1e-5, irb4600.friction.coulomb)


@pytest.fixture(scope="module")
def reference(arm):
    return circle_references(arm, ["p1"], [0.1], [0.001, 0.003])["p1", 0.1]


@pytest.fixture(scope="module")
def recording(arm, reference):
    return simulate([Run(reference=reference)], arm=arm)[0]


def test_a_straight_line_comes_back_as_it_is(reference, recording):
    line = np.stack([3.0 - 2.0 * recording.t, 0.5 * recording.t], axis=1)
    found = at_samples(line, recording, reference)
    inner = slice(1, -1)  # at the ends there is nothing beyond
    np.testing.assert_allclose(found[inner], np.stack([3.0 - 2.0 * reference.t, 0.5 * reference.t], axis=1)[inner])


def test_a_recording_at_the_control_rate_is_taken_as_it_is(arm, reference):
    (slow,) = simulate([Run(reference=reference)], arm=arm, record_dt=0.004)
    np.testing.assert_array_equal(task_error(slow, reference, "motor"), motor_error(slow))


def test_rows_that_the_tracker_missed_lie_between_their_neighbours(reference, recording):
    line = (2.0 * recording.t)[:, None]
    holes = np.where(np.arange(len(line))[:, None] % 10 == 0, line, np.nan)
    inner = slice(1, -3)
    np.testing.assert_allclose(at_samples(holes, recording, reference)[inner, 0], 2.0 * reference.t[inner])
    with pytest.raises(FFGymError, match="no row in which the TCP was seen"):
        at_samples(np.full_like(line, np.nan), recording, reference)


def test_noise_is_averaged(reference, recording):
    noise = np.random.default_rng(0).normal(size=(len(recording.t), 1))
    assert np.std(at_samples(noise, recording, reference)) < 0.5


def test_the_error_of_the_tool_is_its_reference_less_what_was_measured(reference, recording):
    offset = standstill_offset(recording)
    exact = recording.vector("tcp_reference.position") - (recording.vector("tcp.position") - offset)
    found = task_error(recording, reference, "tcp")
    np.testing.assert_allclose(found, exact[::4], atol=0.02 * np.abs(exact).max())  # averaged over 8 ms
    assert np.abs(found[:10]).max() < 1e-9  # it begins at rest


def test_a_tracker_at_its_own_rate_shows_the_same_error(arm, reference, recording):
    tracker = LaserTracker(noise=0.0, period=0.01)
    (tracked,) = simulate([Run(reference=reference)], arm=arm, sensors=[tracker])
    exact = task_error(recording, reference, "tcp")
    assert rms_length(task_error(tracked, reference, "tcp") - exact) < 0.1 * rms_length(
        exact
    )  # straight lines of 10 ms


def test_errors_are_told_circle_by_circle(reference, recording):
    error = task_error(recording, reference, "tcp")
    told = circle_rms(error, reference)
    scored = {e.label: e for e in path_errors(recording)}
    assert list(told) == list(scored) == ["circle 1 mm", "circle 3 mm"]
    for label, value in told.items():
        assert value >= 0.98 * scored[label].rms_3d  # the nearest point of the circle is no farther than the due one


def test_a_recording_of_another_motion_is_refused(arm, recording):
    other = circle_references(arm, ["p1"], [0.04], [0.001])["p1", 0.04]
    with pytest.raises(FFGymError, match="is not of the motion 'p1, 40 mm/s'"):
        task_error(recording, other, "motor")
