"""ROS 2: messages of a joint trajectory controller, and their way over DDS."""

import threading
from dataclasses import replace

import numpy as np
import pytest
from stream_samples import FollowingRobot

from ffgym.control import SetpointResponse
from ffgym.core.errors import FFGymError
from ffgym.deployment import SetpointPlan
from ffgym.deployment.streams import Envelope, Feedback, JointAxes, PacketError, Ros2Wire, StreamCommand, StreamSession
from ffgym.deployment.streams.dds import TOPIC, DdsPort
from ffgym.deployment.streams.emulators import DirectTorque, EmulatedController, EmulatedRobot, run_in_lock_step
from ffgym.deployment.streams.emulators.live import serve_live
from ffgym.deployment.streams.live import run_live
from ffgym.robot import RigidArm, RobotDescription

LOOPBACK = (
    '<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo"/></Interfaces>'
    "<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
    '<Peers><Peer address="127.0.0.1"/></Peers></Discovery></Domain></CycloneDDS>'
)


@pytest.fixture(scope="module")
def store():
    from rosbags.typesys import Stores, get_typestore

    return get_typestore(Stores.ROS2_JAZZY)


def state_of(store, wire: Ros2Wire, **change) -> bytes:
    """Write a JointState as another sender does."""
    message = store.deserialize_cdr(
        wire.encode_feedback(Feedback(sequence=0, time=7.25, position=np.arange(6) / 10), np.zeros(6)),
        "sensor_msgs/msg/JointState",
    )
    return bytes(store.serialize_cdr(replace(message, **change), "sensor_msgs/msg/JointState"))


@pytest.mark.parametrize("torques", [False, True])
def test_a_setpoint_is_a_trajectory_of_one_point_that_is_due_in_a_cycle(axes: JointAxes, store, torques: bool) -> None:
    wire = Ros2Wire(axes, cycle=0.008, torques=torques)
    position = np.arange(6) / 10
    command = StreamCommand(
        sequence=4, time=1.5, position=position, correction=position, velocity=2 * position, effort=3 * position
    )
    message = store.deserialize_cdr(wire.encode_command(command), "trajectory_msgs/msg/JointTrajectory")
    assert message.joint_names == list(axes.names)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (0, 0)
    (point,) = message.points
    assert np.array_equal(point.positions, position)
    assert np.array_equal(point.velocities, 2 * position)
    assert np.array_equal(point.effort, 3 * position if torques else [])
    assert (point.time_from_start.sec, point.time_from_start.nanosec) == (0, 8_000_000)


def test_joints_are_read_by_name_in_any_order_and_beside_others(axes: JointAxes, store) -> None:
    wire = Ros2Wire(axes)
    names, position = ["gripper", *reversed(axes.names)], np.array([9.0, *reversed(np.arange(6) / 10)])
    feedback = wire.decode_feedback(state_of(store, wire, name=names, position=position))
    assert np.array_equal(feedback.position, np.arange(6) / 10)
    assert feedback.time == 7.25


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"name": ["other"] * 6}, "number of joints"),
        ({"position": np.zeros(5)}, "number of joints"),
        ({"position": np.full(6, np.nan)}, "not finite"),
        ({"position": np.full(6, 50.0)}, "out of range"),
    ],
)
def test_a_state_that_says_nothing_to_trust_is_refused(axes: JointAxes, store, change: dict, reason: str) -> None:
    wire = Ros2Wire(axes)
    with pytest.raises(PacketError, match=reason):
        wire.decode_feedback(state_of(store, wire, **change))


def test_bytes_that_are_no_message_are_refused(axes: JointAxes, store) -> None:
    wire = Ros2Wire(axes)
    good = state_of(store, wire)
    for data in (b"", good[:30], b"\x00\x00" + good[2:], good[:12] + b"\xff" * 30 + good[42:], b"\x00" * 70_000):
        with pytest.raises(PacketError):
            wire.decode_feedback(data)


def test_efforts_reach_the_motors_of_an_emulated_controller(
    axes: JointAxes, wave: SetpointPlan, envelope: Envelope, irb4600: RobotDescription, arm: RigidArm
) -> None:
    wire = Ros2Wire(axes, torques=True)
    robot = EmulatedRobot(irb4600, wave.program[0], cycle=0.004, response=SetpointResponse(delay=0.004), arm=arm)
    given, advance = [], robot.advance

    def note(setpoint, torque):
        given.append(torque)
        advance(setpoint, torque)

    robot.advance = note
    session = StreamSession(wave, wire, envelope, irb4600.drive)
    run_in_lock_step(session, EmulatedController(robot, wire, direct_torque=DirectTorque()))
    assert session.state == "ended"
    assert np.abs(np.stack(given)[9:510] - wave.torque).max() < 1e-12


def test_a_plan_is_sent_over_dds(
    axes: JointAxes,
    brief: SetpointPlan,
    envelope: Envelope,
    irb4600: RobotDescription,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("CYCLONEDDS_URI", LOOPBACK)
    monkeypatch.setenv("ROS_DOMAIN_ID", "77")
    wire = Ros2Wire(axes)
    robot = FollowingRobot(irb4600, brief.program[0], cycle=0.004)
    ports = DdsPort(TOPIC), DdsPort(TOPIC, is_controller=True)
    controller = EmulatedController(robot, wire)
    server = threading.Thread(target=serve_live, args=(controller, ports[1], None), kwargs={"longest": 20.0})
    server.start()
    session = StreamSession(brief, wire, envelope, irb4600.drive)
    run_live(session, ports[0])
    server.join()
    for port in ports:
        port.close()
    assert session.state == "ended"
    assert robot.missed < robot.cycles


def test_a_domain_that_cannot_be_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "high")
    with pytest.raises(FFGymError, match="ROS_DOMAIN_ID"):
        DdsPort(TOPIC)
