"""Friction behind the elasticity in elastic feed-forward: the arm stays on its path, the spring carries it."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.agents.arm_friction import ArmState, ReferenceArmFriction
from ffgym.agents.elastic import elastic_feedforward, elastic_law
from ffgym.control import CausalLaw, DynamicLuGreExact, NoCompensation, Window
from ffgym.paths import joint_reference, joint_sine
from ffgym.robot import RigidArm
from ffgym.simulation import Run, simulate
from ffgym.studies import circle_references, circle_study

DT = 0.004


@pytest.fixture(scope="module")
def shared(irb4600):
    """The robot with the share of joints 1 to 3 that fits Tables 4.1 and 4.2 of the thesis."""
    return irb4600.with_arm_share([0.73, 0.73, 0.73, 0, 0, 0])


@pytest.fixture(scope="module")
def reference(shared):
    return circle_references(RigidArm(shared), ["p2"], speeds=(0.1,), radii=(0.001,))["p2", 0.1]


@pytest.fixture(scope="module")
def arm_friction(shared):
    return elastic_feedforward(shared).arm_friction


# What it is worth


@pytest.mark.parametrize(("speed", "left"), [(0.01, 0.15), (0.04, 0.15), (0.1, 0.25)])
def test_it_takes_nearly_all_error_of_an_arm_with_friction(shared, irb4600, speed, left):
    unaware = elastic_law(RigidArm(irb4600), name="unaware")
    laws = [NoCompensation(), DynamicLuGreExact(shared.friction), unaware, elastic_feedforward(shared)]
    cells = circle_study(shared, laws=laws, positions=["p1"], speeds=(speed,), radii=(0.001,)).cells
    none, lugre, without, knowing = (cell.rms_mm for cell in cells)
    assert knowing < left * none
    assert knowing < 0.2 * min(lugre, without)


@pytest.mark.parametrize("share", [0.4, 1.0])
def test_a_link_with_friction_follows_its_sine(one_axis, share):
    drive = replace(one_axis.drive, joint_stiffness=np.array([21.0]), joint_damping=np.array([0.017]))
    axis = replace(one_axis, drive=drive).with_arm_share(share)
    reference = joint_reference(axis, joint_sine([0.5], 1.0, 1.0))

    def miss(law):
        (recording,) = simulate([Run(reference=reference, law=law)], record_dt=DT)
        link = recording.joint_array("link.position") - reference.q
        return np.abs(link - link[0])[200:].max()  # once the spring has bent

    lost = share * axis.friction.coulomb[0] * drive.gear_ratio[0] / 21.0  # bend of the spring by the friction
    assert miss(elastic_feedforward(axis)) < 0.05 * lost
    assert miss(elastic_law(RigidArm(replace(axis, friction=one_axis.friction)))) > 0.5 * lost


# Lead and torque


def test_a_sliding_arm_bends_its_spring_by_its_friction(arm_friction, shared):
    speed = np.array([20.0, -30.0, 5.0, 1.0, 1.0, 1.0])
    step = arm_friction.along(np.tile(speed, (400, 1)), DT)
    friction = shared.arm_share * shared.drive.gear_ratio * shared.friction.steady_torque(speed)
    np.testing.assert_allclose(step.torque[:, -1], np.tile(friction, (32, 1)), rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(step.after.lead[-1], friction / shared.drive.joint_stiffness, rtol=1e-6, atol=1e-15)
    np.testing.assert_allclose(step.lead_speed[:, -1], 0, atol=1e-10)


def test_spring_and_damping_carry_the_friction_within_a_reversal(arm_friction, reference, shared):
    drive = shared.drive
    step = arm_friction.along(reference.motor_dq, DT)
    carried = drive.joint_stiffness * step.lead + drive.joint_damping * step.lead_speed
    assert np.std(carried - step.torque) < 2e-3 * np.std(step.torque)  # the rest is the sub-step of 1/8 ms
    assert np.std(drive.joint_stiffness * step.lead - step.torque) > 0.01 * np.std(step.torque)


def test_averages_do_not_depend_on_the_sub_steps(shared, reference):
    averages = [
        ReferenceArmFriction(law=DynamicLuGreExact(shared.friction, n), drive=shared.drive, share=shared.arm_share)
        .along(reference.motor_dq, DT)
        .around(DT)
        for n in (16, 32, 64)
    ]
    for part in ("angle", "speed", "acceleration"):
        rough, middle, fine = (getattr(average.lead, part) for average in averages)
        assert np.abs(middle - fine).max() < 0.4 * np.abs(rough - middle).max()
        assert np.abs(middle - fine).max() < 2e-3 * np.abs(fine).max()


def test_averaged_derivatives_add_up_to_the_lead(arm_friction, reference):
    step = arm_friction.along(reference.motor_dq, DT)
    asked = step.around(DT)
    np.testing.assert_allclose(DT * asked.lead.acceleration.cumsum(axis=0), step.across / DT, atol=1e-9)
    gone = DT * asked.lead.speed.cumsum(axis=0)  # averages reach half a step beyond their sample
    np.testing.assert_allclose(gone, step.mean_lead, atol=2e-2 * np.abs(step.mean_lead).max())


def test_drives_give_the_torque_that_it_foresees(shared):
    reference = circle_references(RigidArm(shared), ["p1"], speeds=(0.04,), radii=(0.003,))["p1", 0.04]
    law = elastic_feedforward(shared)
    (recording,) = simulate([Run(reference=reference, law=law)], record_dt=DT)
    given, foreseen = recording.joint_array("motor.effort"), law.motor_torque(reference)
    assert np.all(np.std(given - foreseen, axis=0) < 0.1 * np.std(foreseen, axis=0))


# Limits


def test_without_a_share_there_is_none(irb4600, shared):
    assert elastic_feedforward(irb4600).arm_friction is None
    assert elastic_feedforward(irb4600.with_arm_share(np.zeros(6))).arm_friction is None
    assert elastic_feedforward(shared, compensate_friction=False).arm_friction is None


def test_a_small_share_changes_the_torque_in_proportion(irb4600, reference):
    none, small, twice = (
        elastic_feedforward(irb4600.with_arm_share(np.full(6, share))).torque(reference) for share in (0, 1e-6, 2e-6)
    )
    assert np.abs(small - none).max() > 1e-7
    np.testing.assert_allclose(twice - none, 2 * (small - none), atol=1e-3 * np.abs(small - none).max())


def test_a_rigid_joint_has_all_friction_on_its_motor(shared, irb4600, reference):
    rigid = np.array([False, True, False, False, False, False])
    drive = replace(
        shared.drive,
        joint_stiffness=np.where(rigid, np.inf, shared.drive.joint_stiffness),
        joint_damping=np.where(rigid, 0.0, shared.drive.joint_damping),
    )
    torques = [elastic_feedforward(replace(each, drive=drive)).torque(reference) for each in (shared, irb4600)]
    np.testing.assert_allclose(torques[0][:, 1], torques[1][:, 1], atol=1e-12)
    assert np.abs(torques[0] - torques[1])[:, 0].max() > 0.5


# One by one, and side by side


@pytest.mark.parametrize("preview", [3, 4, 5])
def test_steps_give_the_torque_of_the_whole_reference(shared, reference, preview):
    law = replace(elastic_feedforward(shared), preview=preview)
    np.testing.assert_allclose(CausalLaw.torque(law, reference), law.torque(reference), atol=1e-12)


def test_a_batch_gives_the_bits_of_each_row(shared, reference):
    law, rows = elastic_feedforward(shared), np.arange(60, 160, 7)
    window = Window.along(reference, law.preview)
    together = Window(
        **{name: getattr(window, name)[rows] for name in ("q", "motor_dq", "motor_ddq")},
        dt=reference.robot.servo.control_dt,
    )
    memory = law.initial_memory(together)
    torque, after = law.step(memory, together)
    for row in range(len(torque)):
        alone, remembered = law.step(memory[row], together[row])
        np.testing.assert_array_equal(alone, torque[row])
        np.testing.assert_array_equal(remembered, after[row])


SIDES = {"motors": 0.0, "both": 0.3, "arm": 1.0}


@pytest.mark.parametrize("share", SIDES.values(), ids=SIDES)
def test_steps_ask_for_the_errors_of_the_whole_reference(irb4600, reference, share):
    law = elastic_feedforward(irb4600.with_arm_share(np.full(6, share)))
    for found, wanted in zip(CausalLaw.own_errors(law, reference), law.own_errors(reference), strict=True):
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-9 * np.abs(wanted).max())


@pytest.mark.parametrize("share", SIDES.values(), ids=SIDES)
def test_motors_have_the_errors_that_it_asks_for(irb4600, share):
    robot = irb4600.with_arm_share(np.full(6, share))
    reference, law = circle_references(RigidArm(robot), ["p1"], [0.04], [0.001])["p1", 0.04], elastic_feedforward(robot)
    (recording,) = simulate([Run(reference=reference, law=law)], record_dt=DT)
    motors = (recording.joint_array(f"motor.{name}") for name in ("position", "velocity"))
    found = [wanted - motor for wanted, motor in zip((reference.motor_q, reference.motor_dq), motors, strict=True)]
    found[0] -= found[0][0]  # sag of the servo at the start
    for error, asked, left in zip(found, law.own_errors(reference), (0.03, 0.2), strict=True):
        assert np.std(error - asked) < left * np.std(error)


def test_it_says_how_far_the_motors_lead_at_an_instant(shared, reference):
    law = elastic_feedforward(shared)
    memory, window = law.initial_memory(Window.along(reference, law.preview)[0]), Window.along(reference, law.preview)
    for k in range(120):
        _, memory = law.step(memory, window[k])
    state = law.arm_friction.along(reference.motor_dq[:122], DT).after
    unaware = elastic_law(RigidArm(shared.with_arm_share(np.zeros(6))))
    plain = unaware.initial_memory(window[0])
    for k in range(120):
        _, plain = unaware.step(plain, window[k])
    (angle, speed), (less, slower) = law.instant_error(memory), unaware.instant_error(plain)
    np.testing.assert_allclose(angle - less, -shared.drive.motor_angle(state.lead[-1]), atol=1e-9)
    np.testing.assert_allclose(speed - slower, -shared.drive.motor_angle(state.lead_speed[-1]), atol=1e-6)


def test_an_arm_at_rest_asks_for_nothing(arm_friction):
    still = np.zeros(6)
    step = arm_friction.within(ArmState.relaxed(still), still, still, DT)
    assert not np.any([step.lead, step.lead_speed, step.torque])
