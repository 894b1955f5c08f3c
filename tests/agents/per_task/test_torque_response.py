"""The linear model answers added torque as the simulated robot does."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.agents.task_torques import Task, TaskTorques
from ffgym.agents.torque_response import TorqueResponse
from ffgym.core.errors import FFGymError
from ffgym.paths import joint_reference, joint_sine
from ffgym.recordings.metrics import motor_error
from ffgym.robot import RigidArm
from ffgym.simulation import Run, simulate
from ffgym.studies import circle_references
from tests.robot.robot_samples import unusual


def without_bristles(robot):
    """The same robot with viscous friction alone, but for a billionth of the rest."""
    return replace(robot, friction=robot.friction.scaled(coulomb=1e-9, static=1e-9, bristle_damping=0.0))


def pulse(reference, joint):
    """A smooth torque of 1 N m on one joint (T, N), from 0.1 s on for 0.1 s."""
    torque = np.zeros_like(reference.q)
    torque[:, joint] = np.where(np.abs(reference.t - 0.15) < 0.05, np.sin(np.pi * (reference.t - 0.1) / 0.1) ** 2, 0.0)
    return torque


def answer(arm, reference, torque, read):
    """What `torque` changes in the simulation, at the control samples."""
    tasks = (torque, np.zeros_like(torque))
    laws = [TaskTorques(tasks=(Task(name="a", q=reference.q, torque=u),)) for u in tasks]
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
