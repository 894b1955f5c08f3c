"""Protocols of one joint at a time: speed ladder, table 6.1, slow triangles."""

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.published import FRICTION_RECORDS
from ffgym.simulation.protocols.one_by_one import RAMP, SHORTEST, SPEEDS, TURNS, SlowTriangles, SpeedLadder, Table61
from ffgym.simulation.protocols.stage import ProtocolStage
from tests.simulation.protocols.protocol_samples import ROBOTS, arm_of, schedule_of

every_robot = pytest.mark.parametrize("robot", ROBOTS)


def own_motor(reference, joint):
    """Speed of the motor of a joint that moves alone, without what couplings add."""
    return reference.dq[:, joint] * reference.robot.drive.gear_ratio[joint]


def rows(reference, phase):
    return (reference.t >= phase.start) & (reference.t < phase.end)


@every_robot
def test_the_ladder_runs_each_joint_alone_at_the_speeds_of_the_thesis_in_both_directions(robot):
    arm = arm_of(robot)
    last = arm.robot.n_joints - 1
    (motion,) = schedule_of(robot, "speed_ladder")
    reference = motion.reference
    assert not np.delete(reference.dq, last, axis=1).any()
    speed = own_motor(reference, last) * np.sign(arm.robot.drive.gear_ratio[last])
    forwards = [p for p in reference.phases if p.label.endswith("forwards")]
    back = [p for p in reference.phases if p.label.endswith("back")]
    for phase, there in zip(forwards + back, [*SPEEDS, *(-x for x in SPEEDS)], strict=True):
        np.testing.assert_allclose(speed[rows(reference, phase)], there, rtol=1e-9)
    for one, other in zip(forwards, back, strict=True):
        assert one.end - one.start >= SHORTEST
        ways = [reference.q[rows(reference, phase), last] for phase in (one, other)]
        step = np.abs(reference.dq[rows(reference, one), last]).max() * reference.t[1] * (1 + 1e-6)
        assert abs(ways[0].min() - ways[1].min()) <= step
        assert abs(ways[0].max() - ways[1].max()) <= step


@every_robot
def test_the_ladder_runs_about_the_rest_position_where_the_range_allows(robot):
    stage = ProtocolStage(arm=arm_of(robot))
    (motion,) = schedule_of(robot, "speed_ladder")
    way = (TURNS * 2 * np.pi + SPEEDS[-1] * RAMP) * stage.joint_side(1.0)[-1]
    middle = stage.about(stage.rest, stage.only([stage.robot.n_joints - 1], way / 2))[-1]
    assert np.abs(motion.reference.q[:, -1] - middle).max() <= way / 2 * (1 + 1e-9)


def test_speeds_are_those_of_the_thesis_interval_and_dense_near_zero():
    assert (SPEEDS[0], SPEEDS[-1]) == (0.01, 14.0)
    assert np.all(np.diff(np.diff(SPEEDS)) > 0)
    assert np.sum(np.array(SPEEDS) < 0.15) >= 5  # below the Stribeck speed of the thesis


@every_robot
def test_bristles_have_slipped_at_the_slowest_speed(robot):
    friction = arm_of(robot).robot.friction
    (motion,) = schedule_of(robot, "speed_ladder")
    slowest = next(p for p in motion.reference.phases if p.label.endswith("forwards"))
    assert SPEEDS[0] * (slowest.end - slowest.start) >= 5 * friction.static[-1] / friction.bristle_stiffness[-1]


def test_poses_load_the_motor_differently():
    arm = arm_of("irb4600_60_205")
    ladders = [m.reference for m in SpeedLadder(joints=("j2",), speeds=(5.0,), poses=3).schedule(arm)]
    assert [ladder.name for ladder in ladders] == [f"speed_ladder.j2.pose_{i}" for i in (1, 2, 3)]
    load = [arm.robot.drive.motor_torque(arm.holding_torque(ladder.q[:1]))[0, 1] for ladder in ladders]
    assert np.ptp(load) > 0.1 * arm.robot.drive.peak_torque[1]
    assert load[1] == pytest.approx((load[0] + load[2]) / 2, abs=0.1 * np.ptp(load))


def test_a_joint_that_gravity_does_not_load_has_one_pose():
    assert len(SpeedLadder(joints=("j1",), speeds=(5.0,), poses=3).schedule(arm_of("irb4600_60_205"))) == 1


@every_robot
@pytest.mark.parametrize("number", [1, 11, 15])
def test_a_record_of_table_6_1_is_the_sine_of_the_thesis_over_whole_periods(robot, number):
    arm = arm_of(robot)
    last = arm.robot.n_joints - 1
    (motion,) = Table61(joints=(arm.robot.joints[last],), records=(number,)).schedule(arm)
    reference, record = motion.reference, FRICTION_RECORDS[number - 1]
    assert reference.name == f"table_6_1.{arm.robot.joints[last]}.record_{number:02d}"
    (sine,) = (p for p in reference.phases if p.kind == "motion")
    inside = rows(reference, sine)
    expected = record.amplitude * np.sin(2 * np.pi * record.frequency * (reference.t[inside] - sine.start))
    speed = own_motor(reference, last) * np.sign(arm.robot.drive.gear_ratio[last])
    np.testing.assert_allclose(speed[inside], expected, atol=1e-9 * record.amplitude)
    periods = (sine.end - sine.start) * record.frequency
    assert periods == pytest.approx(round(periods))
    assert periods >= 3
    np.testing.assert_allclose(reference.q[-1], reference.q[0], atol=1e-12)


def test_all_records_of_all_joints_are_made_if_nothing_else_is_said():
    arm = arm_of("two_link")
    names = [m.reference.name for m in Table61().schedule(arm)]
    assert len(names) == 30
    assert names[15] == "table_6_1.elbow.record_01"


@every_robot
def test_triangles_stay_within_the_bristles_and_go_beyond(robot):
    arm = arm_of(robot)
    motions = schedule_of(robot, "slow_triangles")
    bristle = arm.robot.friction.static[-1] / arm.robot.friction.bristle_stiffness[-1]
    half_way = [np.ptp(m.reference.q[:, -1]) / 2 * abs(arm.robot.drive.gear_ratio[-1]) for m in motions]
    np.testing.assert_allclose(half_way, [0.5 * bristle, 2 * bristle, 8 * bristle, 1.0], rtol=1e-3)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: SpeedLadder(joints=("j7",)), "Unknown joint 'j7'. Available: j1, j2, j3, j4, j5, j6"),
        (lambda: SpeedLadder(speeds=()), r"speeds = \[\] rad/s must be > 0"),
        (lambda: SpeedLadder(speeds=(1.0, -1.0)), r"speeds = \[1.0, -1.0\] rad/s must be > 0"),
        (lambda: SpeedLadder(speeds=(1e4,)), "joint j1 has no room for 10000 rad/s of its motor"),
        (lambda: SpeedLadder(poses=0), "poses = 0"),
        (lambda: Table61(records=(16,)), r"records = \[16.0\] must be numbers from 1 to 15"),
        (lambda: Table61(periods=0), "periods = 0"),
        (lambda: SlowTriangles(sliding=-1.0), r"sliding = -1.0 rad is out of range"),
        (lambda: SlowTriangles(sliding=1e4), "joint j1 would go .* more than its range"),
    ],
)
def test_settings_that_make_no_sense_are_named_with_their_protocol(build, message):
    with pytest.raises(FFGymError, match=message) as caught:
        build().schedule(arm_of("irb4600_60_205"))
    assert str(caught.value).startswith("Protocol ")


@pytest.mark.parametrize("joints", ["j1", ("j1", "j1"), (1,)])
def test_joints_must_be_names_each_of_them_once(joints):
    with pytest.raises(FFGymError, match="must be a list of names, each of them once"):
        SpeedLadder(joints=joints)
