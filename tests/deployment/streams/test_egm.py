"""ABB EGM: packets, and a plan sent to an emulated controller."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.control import SetpointResponse
from ffgym.core.errors import FFGymError
from ffgym.deployment import SetpointPlan
from ffgym.deployment.streams import (
    EgmWire,
    Envelope,
    Feedback,
    JointAxes,
    PacketError,
    StreamCommand,
    StreamSession,
    record_session,
)
from ffgym.deployment.streams.emulators import EmulatedController, EmulatedRobot, run_in_lock_step
from ffgym.robot import RigidArm, RobotDescription


@pytest.fixture(scope="module")
def wire(axes: JointAxes) -> EgmWire:
    return EgmWire(axes)


def emulate(
    robot: RobotDescription, wire: EgmWire, start: np.ndarray, arm: RigidArm, response: SetpointResponse
) -> EmulatedController:
    return EmulatedController(EmulatedRobot(robot, start, cycle=wire.cycle, response=response, arm=arm), wire)


def test_packets_are_messages_of_abb_in_degrees_and_milliseconds(wire: EgmWire) -> None:
    from abb_robot_client.egm import egm_pb2

    position = np.deg2rad([10.0, 20.0, -30.0, 40.0, -50.0, 60.0])
    feedback = Feedback(sequence=7, time=1.028, position=position)
    message = egm_pb2.EgmRobot.FromString(wire.encode_feedback(feedback, position))
    assert message.header.seqno == 7
    assert message.header.tm == 1028
    assert message.header.mtype == egm_pb2.EgmHeader.MSGTYPE_DATA
    assert np.allclose(message.feedBack.joints.joints, [10, 20, -30, 40, -50, 60])
    none = np.zeros(6)
    command = StreamCommand(sequence=3, time=0.5, position=position, correction=none, velocity=none, effort=none)
    sent = egm_pb2.EgmSensor.FromString(wire.encode_command(command))
    assert (sent.header.seqno, sent.header.tm) == (3, 500)
    assert sent.header.mtype == egm_pb2.EgmHeader.MSGTYPE_CORRECTION
    assert np.allclose(sent.planned.joints.joints, [10, 20, -30, 40, -50, 60])


def test_a_controller_is_ready_with_motors_on_and_its_guidance_running(wire: EgmWire) -> None:
    from abb_robot_client.egm import egm_pb2

    data = wire.encode_feedback(Feedback(sequence=7, time=1.0, position=np.zeros(6)), np.zeros(6))
    for change in (
        lambda m: setattr(m.motorState, "state", m.motorState.MOTORS_OFF),
        lambda m: setattr(m.mciState, "state", m.mciState.MCI_STOPPED),
    ):
        message = egm_pb2.EgmRobot.FromString(data)
        change(message)
        assert not wire.decode_feedback(message.SerializeToString()).ready


def test_packets_come_back_from_the_wire(wire: EgmWire) -> None:
    position = np.linspace(-0.5, 0.5, 6)
    back = wire.decode_feedback(
        wire.encode_feedback(Feedback(sequence=2**32 + 5, time=4.0, position=position), position)
    )
    assert (back.sequence, back.time, back.ready) == (5, 4.0, True)
    assert np.allclose(back.position, position, rtol=1e-15)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda m: m.header.ClearField("seqno"), "no sequence number"),
        (lambda m: setattr(m.header, "mtype", 3), "kind of message"),
        (lambda m: m.feedBack.joints.joints.pop(), "number of joints"),
        (lambda m: m.feedBack.joints.joints.append(0.0), "number of joints"),
        (lambda m: m.feedBack.joints.joints.__setitem__(2, float("nan")), "not finite"),
        (lambda m: m.feedBack.joints.joints.__setitem__(2, 1e6), "out of range"),
    ],
)
def test_a_message_that_says_nothing_to_trust_is_refused(wire: EgmWire, change, reason: str) -> None:
    from abb_robot_client.egm import egm_pb2

    message = egm_pb2.EgmRobot.FromString(
        wire.encode_feedback(Feedback(sequence=1, time=1.0, position=np.zeros(6)), np.zeros(6))
    )
    change(message)
    with pytest.raises(PacketError, match=reason):
        wire.decode_feedback(message.SerializeToString())


def test_bytes_that_are_no_message_are_refused(wire: EgmWire) -> None:
    for data in (b"", b"\xff" * 40, b"<Rob/>"):
        with pytest.raises(PacketError):
            wire.decode_feedback(data)


def test_a_plan_reaches_the_servo_late_by_delay_and_filter(
    wire: EgmWire, wave: SetpointPlan, envelope: Envelope, irb4600: RobotDescription, arm: RigidArm
) -> None:
    response = SetpointResponse.low_pass(20.0, delay=0.0093)
    controller = emulate(irb4600, wire, wave.program[0], arm, response)
    session = StreamSession(wave, wire, envelope, irb4600.drive)
    told: list[tuple[float, float]] = []
    run_in_lock_step(session, controller, progress=lambda done, total: told.append((done, total)))
    assert told[0] == (0.0, session.plan.t[-1])
    assert told[-1] == (session.plan.t[-1], session.plan.t[-1])
    assert session.state == "ended"
    assert not session.refused
    # what was sent is the plan, answer by answer
    log = record_session(session, irb4600)
    count = len(wave.program)
    sent = irb4600.drive.joint_angle(log.joint_array("reference.position"))[:count]
    assert np.allclose(sent, wave.setpoints, atol=1e-12)
    assert np.allclose(log.t[:count], wave.t, atol=1e-9)
    # what the servo got is its delay and filter of that
    truth = controller.robot.truth("wave")
    rows = irb4600.drive.joint_angle(truth.joint_array("reference.position"))[15::16]
    first = 9  # the tenth packet was the first that was answered
    expected = response.apply(wave.setpoints, wave.dt)
    assert np.abs(rows[first : first + count - 1] - expected[1:]).max() < 1e-12


def test_measured_positions_are_late_by_the_whole_delay(
    wire: EgmWire, wave: SetpointPlan, envelope: Envelope, irb4600: RobotDescription, arm: RigidArm
) -> None:
    logs = {}
    for delay in (0.004, 0.030):
        controller = emulate(irb4600, wire, wave.program[0], arm, SetpointResponse(delay=delay))
        session = StreamSession(wave, wire, envelope, irb4600.drive)
        run_in_lock_step(session, controller)
        log = record_session(session, irb4600)
        logs[delay] = irb4600.drive.joint_angle(log.joint_array("motor.position"))[:, 0], log.t
    (early, t), (late, _) = logs[0.004], logs[0.030]
    moving = (t > 0.5) & (t < 1.5)
    assert np.abs(np.interp(t - 0.026, t, early) - late)[moving].max() < 1e-5
    assert np.abs(early - late)[moving].max() > 1e-3


def test_a_robot_at_another_pose_is_not_moved(
    wire: EgmWire, wave: SetpointPlan, envelope: Envelope, irb4600: RobotDescription, arm: RigidArm
) -> None:
    start = wave.program[0] + [0, 0, 0.003, 0, 0, 0]
    controller = emulate(irb4600, wire, start, arm, SetpointResponse(delay=0.004))
    session = StreamSession(wave, wire, envelope, irb4600.drive)
    with pytest.raises(FFGymError, match=r"not at the first pose of 'wave': joint j3 is at"):
        run_in_lock_step(session, controller)
    assert session.sent == 0
    assert np.allclose(controller.robot.position, start, atol=1e-9)


def test_robots_of_more_than_six_joints_are_refused(axes: JointAxes) -> None:
    seven = replace(axes, names=tuple("abcdefg"), units=("rad",) * 7, low=-np.ones(7), high=np.ones(7))
    with pytest.raises(FFGymError, match="EGM sends 6 joints"):
        EgmWire(seven)
