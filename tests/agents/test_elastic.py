"""Elastic feed-forward: the arm stays on the path, the drives give what it says, step by step as all at once."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.agents import LawAgent
from ffgym.agents.elastic import ElasticLaw, elastic_feedforward, elastic_law
from ffgym.agents.flexible_joints import friction_along
from ffgym.control import CausalLaw, DynamicLuGreExact, Window
from ffgym.core.errors import FFGymError
from ffgym.envs import EpisodeRecorder
from ffgym.envs.sb3 import make_sb3_env
from ffgym.paths import constant_velocity, joint_reference, joint_sine
from ffgym.recordings.metrics import path_errors
from ffgym.robot import RigidArm
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant.draws import with_payload
from ffgym.studies import circle_references, circle_study

SMALLEST = ("p2", 0.1)
"""Position and speed [m/s] of the fastest motion, with r = 1 mm."""


def stiffened(robot, joints):
    """The robot with rigid `joints`, a list of truth values."""
    stiffness = np.where(joints, np.inf, robot.drive.joint_stiffness)
    damping = np.where(joints, 0.0, robot.drive.joint_damping)
    return replace(robot, drive=replace(robot.drive, joint_stiffness=stiffness, joint_damping=damping))


@pytest.fixture(scope="module")
def law(irb4600):
    return elastic_feedforward(irb4600)


@pytest.fixture(scope="module")
def references(arm):
    return circle_references(arm, ["p1", "p2"], speeds=(0.04, 0.1), radii=(0.001,))


@pytest.fixture(scope="module")
def soft_axis(one_axis):
    """The one-axis model with a spring that resonates at 9 Hz behind the locked motor, as the robot's first joint."""
    drive = replace(one_axis.drive, joint_stiffness=np.array([21.0]), joint_damping=np.array([0.017]))
    return replace(one_axis, drive=drive)


# What it is worth


@pytest.fixture(scope="module")
def study(irb4600, law):
    springs = replace(elastic_feedforward(irb4600, compensate_friction=False), name="springs alone")
    return circle_study(irb4600, laws=[DynamicLuGreExact(irb4600.friction), law, springs], speeds=(0.04, 0.1))


@pytest.mark.parametrize(("speed", "left"), [(40, 0.02), (100, 0.03)])
def test_it_takes_nearly_all_of_the_path_error_that_dynamic_lugre_leaves(study, speed, left):
    errors = {
        agent: [cell.rms_mm for cell in study.select(agent=agent, speed_mm_s=speed)]
        for agent in ("elastic", "lugre_dynamic")
    }
    assert len(errors["elastic"]) == 12
    assert np.mean(errors["elastic"]) < left * np.mean(errors["lugre_dynamic"])
    assert np.all(np.array(errors["elastic"]) < 0.3 * np.array(errors["lugre_dynamic"]))


def test_at_high_speed_springs_count_for_more_than_friction_and_both_together_for_most(study):
    lugre, both, springs = (
        np.mean([cell.rms_mm for cell in study.select(agent=agent, speed_mm_s=100)])
        for agent in ("lugre_dynamic", "elastic", "springs alone")
    )
    assert both < 0.3 * springs < 0.1 * lugre


def test_it_also_helps_where_the_arm_hardly_bends(irb4600, law):
    laws = [DynamicLuGreExact(irb4600.friction), law]
    found = circle_study(irb4600, laws=laws, positions=["p1"], speeds=(0.01,), radii=(0.001,))
    lugre, elastic = (cell.rms_mm for cell in found.cells)
    assert elastic < 0.2 * lugre


def test_the_link_of_a_moving_start_follows_its_sine(soft_axis):
    reference = joint_reference(soft_axis, joint_sine([0.5], 3.0, 1.0))
    laws = [DynamicLuGreExact(soft_axis.friction), elastic_feedforward(soft_axis)]
    lugre, elastic = (
        link_miss(recording, reference)[200:]  # once the spring has bent
        for recording in simulate([Run(reference=reference, law=law) for law in laws])
    )
    assert np.abs(elastic).max() < 0.1 * np.abs(lugre).max()


def link_miss(recording, reference):
    """How far links are from the reference at its samples, beyond where they began [rad], (T, N)."""
    link = recording.joint_array("link.position")[:: round(reference.robot.servo.control_dt / recording.dt)]
    return link - link[0] - (reference.q - reference.q[0])


# What it says of the machine


def test_drives_give_the_torque_that_it_foresees(references, law, irb4600):
    reference = references["p1", 0.04]
    (recording,) = simulate([Run(reference=reference, law=law)])
    given = recording.joint_array("motor.effort")[::4]
    foreseen = law.motor_torque(reference)
    np.testing.assert_allclose(given[0], foreseen[0], atol=1e-3 * irb4600.drive.peak_torque.max())  # the arm has sagged
    miss, swing = np.std(given - foreseen, axis=0), np.std(foreseen, axis=0)
    assert np.all(miss < 0.05 * swing)


def test_it_tells_where_a_drive_will_clip(references, law, irb4600):
    peak = irb4600.drive.peak_torque
    for key, clips in {SMALLEST: True, ("p1", 0.1): False}.items():
        (recording,) = simulate([Run(reference=references[key], law=law)])
        assert np.any(np.abs(recording.joint_array("command.effort")) > peak) == clips
        assert np.any(np.abs(law.motor_torque(references[key])) > peak) == clips


def test_it_rests_where_the_reference_does(references, law):
    reference = references["p1", 0.04]
    still = reference.t < reference.phases[0].end - law.preview * 0.004
    assert not law.torque(reference)[still].any()


# Limits


def test_on_a_rigid_axis_it_is_dynamic_lugre_averaged_around_samples(one_axis):
    reference = joint_reference(one_axis, joint_sine([1.0], 1.0, 1.0))
    law, lugre = elastic_feedforward(one_axis), DynamicLuGreExact(one_axis.friction)
    torque, speed = law.torque(reference), reference.motor_dq
    speed_after = np.concatenate([speed, speed[-1:]])
    np.testing.assert_allclose(torque[1:], friction_along(lugre, speed_after, 0.004)[1:], atol=1e-12)
    smooth = (np.abs(speed[1:, 0]) > 1.0) & (reference.t[1:] > 0.02)  # it begins at full speed with relaxed bristles
    np.testing.assert_allclose(torque[1:][smooth], lugre.torque(reference)[1:][smooth], atol=0.02 * 0.5634)


def test_rigid_joints_of_an_elastic_robot_get_friction_and_the_change_of_gravity(irb4600, references):
    robot = stiffened(irb4600, [False, True, False, False, True, False])
    reference = references["p1", 0.04]
    torque = elastic_law(RigidArm(robot), RigidArm(irb4600)).torque(reference)
    speed = np.concatenate([reference.motor_dq, reference.motor_dq[-1:]])
    gravity = RigidArm(robot).gravity_torque(reference.q) / robot.drive.gear_ratio
    rigid = friction_along(DynamicLuGreExact(robot.friction), speed, 0.004) + gravity - gravity[0]
    np.testing.assert_allclose(torque[1:, [1, 4]], rigid[1:, [1, 4]], atol=1e-10)
    assert np.abs(torque - rigid)[1:, 0].max() > 1.0


def test_stiffer_springs_lead_less_in_proportion(irb4600, references):
    reference, added = references["p1", 0.04], []
    for factor in (1e2, 1e3):
        drive = irb4600.drive
        stiff = replace(
            drive, joint_stiffness=factor * drive.joint_stiffness, joint_damping=factor * drive.joint_damping
        )
        laws = [
            ElasticLaw(model=RigidArm(replace(irb4600, drive=own)), friction=None)
            for own in (stiff, stiffened(irb4600, np.ones(6, bool)).drive)
        ]
        added.append(np.abs(laws[0].torque(reference) - laws[1].torque(reference)).max())
    assert added[0] / added[1] == pytest.approx(10, rel=1e-3)


def test_it_replaces_the_rigid_feed_forward_of_a_controller_that_knows_other_masses(irb4600, references):
    loaded, reference = RigidArm(with_payload(irb4600, 5.0)), references["p1", 0.1]
    knowing, unknowing = elastic_law(loaded, RigidArm(irb4600)), elastic_law(loaded)
    drive = irb4600.drive
    missing = (
        loaded.inverse_dynamics(reference.q, reference.dq, reference.ddq)
        - RigidArm(irb4600).inverse_dynamics(reference.q, reference.dq, reference.ddq)
    ) / drive.gear_ratio
    missing[0] = 0.0
    np.testing.assert_allclose(knowing.torque(reference) - unknowing.torque(reference), missing, atol=1e-10)
    assert np.abs(missing).max() > 0.1


# One by one, and side by side


@pytest.mark.parametrize("preview", [3, 4, 5])
@pytest.mark.parametrize("friction", [True, False])
def test_steps_give_the_torque_of_the_whole_reference(irb4600, references, preview, friction):
    law = replace(elastic_feedforward(irb4600, compensate_friction=friction), preview=preview)
    reference = references[SMALLEST]
    np.testing.assert_allclose(CausalLaw.torque(law, reference), law.torque(reference), atol=1e-12)


@pytest.mark.parametrize("frequency", [1.0, 3.0])
def test_steps_give_the_torque_of_a_motion_that_does_not_begin_at_rest(soft_axis, frequency):
    law = elastic_feedforward(soft_axis)
    reference = joint_reference(soft_axis, joint_sine([1.0], frequency, 0.5))
    np.testing.assert_allclose(CausalLaw.torque(law, reference), law.torque(reference), atol=1e-12)


@pytest.fixture(scope="module")
def lowered(irb4600, arm):
    """The arm goes to where gravity bends joint 2 otherwise, and stays: the servo's integral runs to its end in 3 s."""
    home = irb4600.work_area.home
    path = constant_velocity([0, 0.5, 0.2, 0, 0, 0], 0.6, start=home, dwell=6.0, dt=0.004, name="lowered")
    return joint_reference(irb4600, path)


def test_it_holds_where_the_integral_of_the_servo_has_run_to_its_end(irb4600, arm, law, lowered):
    (recording,) = simulate([Run(reference=lowered, law=law)], arm=arm, record_dt=0.004)
    ends = np.abs(recording.joint_array("feedback.integral")[-1]) / irb4600.drive.peak_torque
    assert ends.max() == pytest.approx(1.0, rel=1e-3)
    tcp = recording.vector("tcp.position")[recording.mask(label="rest 1")]
    assert np.linalg.norm(tcp[-1] - tcp[50]) < 5e-5  # 0.2 s after it stopped the integral has begun to run


def test_steps_give_the_torque_of_a_motion_on_which_the_integral_runs_to_its_end(law, lowered):
    np.testing.assert_allclose(CausalLaw.torque(law, lowered), law.torque(lowered), atol=1e-9)


def test_a_batch_gives_the_bits_of_each_row(references, law):
    every = [Window.along(reference, law.preview) for reference in references.values()]
    rows = np.arange(60, 160, 7)  # on the lead-in and the circle
    parts = {name: np.concatenate([getattr(w, name)[rows] for w in every]) for name in ("q", "motor_dq", "motor_ddq")}
    together = Window(**parts, dt=0.004)
    memory = law.initial_memory(together)
    torque, after = law.step(memory, together)
    for row in range(len(torque)):
        assert np.array_equal(law.initial_memory(together[row]), memory[row])
        alone, remembered = law.step(memory[row], together[row])
        np.testing.assert_array_equal(alone, torque[row])
        np.testing.assert_array_equal(remembered, after[row])


def test_two_calls_give_the_same_bits(references, law):
    np.testing.assert_array_equal(law.torque(references[SMALLEST]), law.torque(references[SMALLEST]))


def test_as_an_agent_it_makes_the_path_error_of_the_simulation(irb4600, law):
    recorder = EpisodeRecorder()
    env = make_sb3_env(
        "ffgym/CirclePath-v0", 2, positions=["p1", "p2"], speeds=[0.1], radii=[0.003], sampling="sequence",
        preview=law.preview, action_scale=105.0, recorder=recorder,
    )  # fmt: skip
    agent, observation, state, start = LawAgent.for_env(law, env), env.reset(), None, np.ones(2, bool)
    while len(recorder.recordings) < 2:
        action, state = agent.predict(observation, state, start)
        assert np.abs(action).max() < 1
        observation, _, start, _ = env.step(action)
    study = circle_study(irb4600, laws=[law], positions=["p1", "p2"], speeds=(0.1,), radii=(0.003,))
    found = [error.rms * 1e3 for recording in recorder.recordings[:2] for error in path_errors(recording)]
    np.testing.assert_allclose(found, [cell.rms_mm for cell in study.cells], rtol=1e-9)


# Refusals


def test_it_must_see_three_to_five_samples_ahead(law):
    for preview in (2, 6, 3.5):
        with pytest.raises(FFGymError, match="preview of elastic feed-forward"):
            replace(law, preview=preview)


def test_friction_of_another_robot_is_refused_and_so_are_parameters_for_a_law(law, one_axis):
    with pytest.raises(FFGymError, match="Friction for 1 joints does not fit robot 'irb4600_60_205' with 6"):
        replace(law, friction=DynamicLuGreExact(one_axis.friction))
    with pytest.raises(FFGymError, match="must be a DynamicLuGreExact or None, got LuGreParameters"):
        replace(law, friction=one_axis.friction)


def test_a_controller_of_another_robot_is_refused(law, one_axis):
    with pytest.raises(FFGymError, match="both must describe one robot"):
        replace(law, controller=RigidArm(one_axis))


def test_a_model_that_is_no_arm_is_refused(irb4600):
    with pytest.raises(FFGymError, match=r"must be a RigidArm.* got RobotDescription"):
        ElasticLaw(model=irb4600, friction=None)


def test_springs_that_are_slower_than_a_sample_are_refused(irb4600):
    drive = replace(irb4600.drive, joint_damping=0.005 * irb4600.drive.joint_stiffness)
    with pytest.raises(FFGymError, match=r"must be at most the control step of 0\.004 s"):
        elastic_feedforward(replace(irb4600, drive=drive))


def test_a_reference_of_another_robot_is_refused(law, one_axis):
    with pytest.raises(FFGymError, match="does not fit robot 'one_axis'"):
        law.torque(joint_reference(one_axis, joint_sine([1.0], 1.0, 0.1)))
