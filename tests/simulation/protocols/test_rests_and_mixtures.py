"""Protocols of several joints: dwell and restart, holds, warm-up, excitation, diagnosis."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.paths.motions.part import resting_position
from ffgym.robot import RigidArm
from ffgym.simulation.protocols.mixtures import Circles, DiagnosisMotions
from ffgym.simulation.protocols.rests import DwellRestart, Holds
from ffgym.simulation.protocols.stage import (
    LARGE_TORQUE,
    TOOL_DROP,
    TOOL_NEARBY,
    ProtocolStage,
    spread_poses,
    torque_use,
)
from ffgym.simulation.protocols.together import Excitation, WarmUp
from tests.simulation.protocols.protocol_samples import ROBOTS, arm_of, schedule_of

every_robot = pytest.mark.parametrize("robot", ROBOTS)


def span(reference, label):
    """First and last row of a phase."""
    (phase,) = (p for p in reference.phases if p.label == label)
    inside = np.flatnonzero((reference.t >= phase.start) & (reference.t < phase.end))
    return inside[0], inside[-1]


@every_robot
def test_joints_restart_in_the_same_direction_after_rests_of_the_given_lengths(robot):
    (motion,) = schedule_of(robot, "dwell_restart")
    reference = motion.reference
    rests = {p.label: p.end - p.start for p in reference.phases if p.label.startswith("rest of")}
    assert list(rests.values()) == pytest.approx([0.1, 0.3, 1.0, 3.0, 10.0, 30.0])
    for i, (label, duration) in enumerate(rests.items(), start=1):
        first, last = span(reference, label)
        assert not reference.dq[first + 1 : last].any()
        restart, _ = span(reference, f"run {i} after {duration:g} s")
        assert np.all(reference.dq[restart + 1] > 0)
        drive = reference.robot.drive
        np.testing.assert_allclose(reference.dq[restart + 1] * np.abs(drive.gear_ratio), 0.5)
    np.testing.assert_allclose(reference.q[-1], reference.q[0], atol=1e-9)


@every_robot
def test_a_pose_is_held_after_coming_from_below_and_from_above(robot):
    for motion in schedule_of(robot, "holds"):
        reference = motion.reference
        (below, _), (above, _) = (span(reference, f"rest from {side}") for side in ("below", "above"))
        np.testing.assert_allclose(reference.q[below + 1], reference.q[above + 1], atol=1e-9)
        before, after = span(reference, "approach from below")[1], span(reference, "approach from above")[1]
        assert np.all(reference.dq[before] > 0)
        assert np.all(reference.dq[after] < 0)


def test_poses_of_holds_spread_the_load_of_every_motor_that_gravity_loads():
    arm = arm_of("irb4600_60_205")
    poses = spread_poses(ProtocolStage(arm=arm), 6, np.zeros(6))
    load = arm.robot.drive.motor_torque(arm.holding_torque(poses)) / arm.robot.drive.peak_torque
    assert np.all(np.ptp(load, axis=0)[1:3] > 0.1)
    assert len(np.unique(poses, axis=0)) == 6


def test_the_warm_up_repeats_one_motion_at_its_times():
    motions = schedule_of("two_link", "warm_up")
    starts = np.cumsum([m.pause for m in motions]) + np.cumsum([0, *(m.reference.duration for m in motions[:-1])])
    np.testing.assert_allclose(starts - starts[0], [0, 300, 600, 1200, 2400, 4800, 9600])
    for motion in motions[1:]:
        np.testing.assert_array_equal(motion.reference.q, motions[0].reference.q)


def away(arm, reference):
    """How far the tool goes from where it rests, as a share of how far it may."""
    if arm.robot.tool is None:
        return 0.0
    rest = arm.tcp_position(resting_position(arm.robot)[None])
    way = (arm.tcp_position(reference.q) - rest) / np.linalg.norm(rest)
    return max(np.linalg.norm(way, axis=1).max() / TOOL_NEARBY, -way[:, 2].min() / TOOL_DROP)


@pytest.mark.parametrize("name", ["diagnosis", "excitation", "warm_up", "holds"])
@pytest.mark.parametrize("robot", ["irb4600_60_205", "kuka_kr300_r2500"])
def test_tools_of_the_built_in_robots_stay_above_the_floor(robot, name):
    arm = arm_of(robot)
    for motion in schedule_of(robot, name):
        assert arm.tcp_position(motion.reference.q[::10])[:, 2].min() > 0.1


@every_robot
def test_excitations_differ_and_are_as_large_as_reach_speed_or_torque_allow(robot):
    arm = arm_of(robot)
    motions = [m.reference for m in schedule_of(robot, "excitation")]
    assert not np.allclose(motions[0].q, motions[1].q)
    kinematics = arm.robot.kinematics
    for reference in motions:
        use = [
            np.abs(reference.q - reference.q[0]).max(axis=0) / (0.15 * np.ptp(kinematics.range, axis=1)),
            np.abs(reference.dq).max(axis=0) / (0.8 * kinematics.max_speed),
        ]
        torque, near = torque_use(arm, reference), away(arm, reference)
        assert np.max(use) <= 1 + 1e-9
        assert torque <= 1.01 * LARGE_TORQUE
        assert near <= 1.01
        assert torque > 0.95 * LARGE_TORQUE or near > 0.95 or np.allclose(np.max(use, axis=0), 1)


def test_excitation_of_one_joint_moves_no_other():
    arm = arm_of("two_link")
    (motion,) = Excitation(joints=("elbow",), count=1).schedule(arm)
    assert not np.ptp(motion.reference.q[:, 0])


@every_robot
def test_the_diagnosis_takes_a_minute_and_a_half_and_stands_moves_and_turns_every_joint(robot):
    motions = [m.reference for m in schedule_of(robot, "diagnosis")]
    assert len(motions) == 8
    assert 80 <= sum(reference.duration for reference in motions) <= 90
    motor_speed = np.concatenate([np.abs(reference.dq) for reference in motions]) * np.abs(
        motions[0].robot.drive.gear_ratio
    )
    for low, high in ((0.1, 0.6), (2.0, 6.0), (10.0, np.inf)):
        share = np.mean((motor_speed >= low) & (motor_speed <= high), axis=0)
        assert np.all(share > 0.02)
    assert np.all(np.mean(motor_speed < 1e-3, axis=0) > 0.03)
    triangle = motions[0]
    for half in np.array_split(triangle.dq, 2):
        assert np.all(
            np.sum(np.diff(np.sign(half), axis=0) == -2, axis=0) + np.sum(half[1:] * half[:-1] < 0, axis=0) >= 1
        )


def test_joints_of_a_diagnosis_turn_at_times_of_their_own():
    dq = schedule_of("irb4600_60_205", "diagnosis")[0].reference.dq
    turning = (np.abs(dq) < 0.5 * np.abs(dq).max(axis=0)) & (np.abs(dq).max(axis=1, keepdims=True) > 0)
    inner = turning[200:-200]
    alone = np.sum(inner & (inner.sum(axis=1, keepdims=True) == 1), axis=0) / inner.sum(axis=0)
    assert np.all(alone > 0.4)


def test_circles_are_those_that_are_asked_for():
    motions = Circles(positions=("p2",), speeds=(0.02,), radii=(0.004,)).schedule(arm_of("irb4600_60_205"))
    assert [m.reference.name for m in motions] == ["circles.p2.20_mm_s"]
    assert [p.label for p in motions[0].reference.phases if p.kind == "circle"] == ["circle 4 mm"]


def test_a_robot_that_can_hardly_hold_itself_makes_no_large_motion():
    robot = arm_of("two_link").robot
    weak = replace(robot, drive=replace(robot.drive, peak_torque=np.array([9.0, 3.0])))
    with pytest.raises(FFGymError, match="no motion, however small, takes at most 50%"):
        Excitation(count=1).schedule(RigidArm(weak))
    with pytest.raises(FFGymError, match="holding the arm in its rest position takes more than 50%"):
        Holds().schedule(RigidArm(weak))


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: Circles(positions=("p9",)), "Unknown position 'p9'"),
        (lambda: DwellRestart(rests=()), r"rests = \[\] s must be > 0"),
        (lambda: DwellRestart(speed=0.0), "speed = 0.0 rad/s is out of range"),
        (lambda: Holds(poses=0), "poses = 0"),
        (lambda: Holds(approach=0.01), "approach = 0.01 rad is out of range"),
        (lambda: WarmUp(times=(1.0, 300.0)), "must begin with 0"),
        (lambda: WarmUp(times=(0.0, 5.0)), "at least 10.6 s apart"),
        (lambda: Excitation(reach=0.9), "reach = 0.9"),
        (lambda: Excitation(harmonics=0), "harmonics = 0"),
        (lambda: DiagnosisMotions(joints=("x",)), "Unknown joint 'x'"),
    ],
)
def test_settings_of_mixtures_that_make_no_sense_are_named_with_their_protocol(build, message):
    with pytest.raises(FFGymError, match=message) as caught:
        build().schedule(arm_of("irb4600_60_205"))
    assert str(caught.value).startswith("Protocol ")


def test_a_pause_must_be_a_time():
    with pytest.raises(FFGymError, match=r"pause = -1\.0 s is out of range"):
        DiagnosisMotions(pause=-1.0)
