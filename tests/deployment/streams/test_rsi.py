"""KUKA RSI: telegrams, and corrections of a program that an emulated controller runs."""

import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest

from ffgym.control import SetpointResponse
from ffgym.core.errors import FFGymError
from ffgym.deployment import SetpointPlan
from ffgym.deployment.streams import Envelope, Feedback, JointAxes, PacketError, RsiWire, StreamCommand, StreamSession
from ffgym.deployment.streams.emulators import EmulatedController, EmulatedRobot, Faults, run_in_lock_step
from ffgym.robot import RigidArm, RobotDescription


@pytest.fixture(scope="module")
def wire(axes: JointAxes) -> RsiWire:
    return RsiWire(axes)


def feedback_at(position: np.ndarray, **change) -> Feedback:
    return replace(Feedback(sequence=0, time=4208163.634, position=position), **change)


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "cp037"])
def test_a_declaration_in_another_encoding_is_no_telegram(wire: RsiWire, encoding: str) -> None:
    plain = wire.encode_feedback(feedback_at(np.zeros(6)), np.zeros(6)).decode()
    assert wire.decode_feedback(plain.encode()).token == 4208163634
    declared = b'<?xml version="1.0" encoding="cp037"?>' if encoding == "cp037" else b""
    entity = '<!DOCTYPE Rob [<!ENTITY run "1">]>' + plain.replace("<Run>1<", "<Run>&run;<")
    with pytest.raises(PacketError, match="not a message"):
        wire.decode_feedback(declared + entity.encode(encoding))


def test_telegrams_are_those_of_kuka(wire: RsiWire) -> None:
    position = np.deg2rad([10.0, 20.0, -30.0, 40.0, -50.0, 60.0])
    root = ET.fromstring(wire.encode_feedback(feedback_at(position), position))
    assert (root.tag, root.get("Type")) == ("Rob", "KUKA")
    assert root.findtext("IPOC") == "4208163634"
    assert [float(root.find("AIPos").get(f"A{j}")) for j in range(1, 7)] == pytest.approx([10, 20, -30, 40, -50, 60])
    command = StreamCommand(
        sequence=0,
        time=0.0,
        position=position,
        correction=np.deg2rad([0.1, 0, 0, 0, 0, -0.2]),
        velocity=position,
        effort=position,
        token=4208163634,
    )
    assert wire.encode_command(command).decode() == (
        '<Sen Type="ImFree"><AKorr A1="0.100000000" A2="0.000000000" A3="0.000000000" A4="0.000000000" '
        'A5="0.000000000" A6="-0.200000000"/><IPOC>4208163634</IPOC></Sen>'
    )


def test_a_telegram_as_controllers_write_it_is_read(wire: RsiWire) -> None:
    text = (
        '<Rob Type="KUKA"><RIst X="0.0" Y="0.0" Z="0.0" A="0.0" B="0.0" C="0.0"/>\r\n'
        '<AIPos A1="1.5" A2="-90.0" A3="60.0" A4="0.0" A5="90.0" A6="0.0"/><Delay D="0"/><Run>1</Run>'
        "<IPOC>123645634563</IPOC></Rob>"
    )
    with pytest.raises(PacketError, match="no sequence number"):  # longer than a clock of 32 bit
        wire.decode_feedback(text.encode())
    feedback = wire.decode_feedback(text.replace("123645634563", "123645634").encode())
    assert feedback.time == pytest.approx(123645.634)
    assert feedback.token == 123645634
    assert feedback.started
    assert np.rad2deg(feedback.position) == pytest.approx([1.5, -90, 60, 0, 90, 0])


def test_a_telegram_of_another_kind_is_refused(wire: RsiWire) -> None:
    data = wire.encode_feedback(feedback_at(np.zeros(6)), np.zeros(6)).replace(b"Rob", b"Bob")
    with pytest.raises(PacketError, match="kind of message"):
        wire.decode_feedback(data)


def test_corrections_of_linear_axes_are_in_millimetres_and_those_that_are_none_refused() -> None:
    axes = JointAxes(names=("track", "a"), units=("m", "rad"), low=np.full(2, -1.0), high=np.full(2, 1.0))
    wire, none, correction = RsiWire(axes), np.zeros(2), np.array([0.0015, 0.01])
    command = StreamCommand(
        sequence=0, time=0.0, position=none, correction=correction, velocity=none, effort=none, token=4
    )
    data = wire.encode_command(command)
    assert b'A1="1.500000000"' in data
    assert np.allclose(wire.decode_command(data).correction, correction, atol=1e-10)
    with pytest.raises(PacketError, match="not finite"):
        wire.decode_command(data.replace(b"1.500000000", b"nan"))


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("<Rob", "<Bob", "not a message"),
        ('A3="', 'B3="', "number of joints"),
        ('<AIPos A1="0', '<AIPos A1="nan', "not a number|not finite"),
        ('<AIPos A1="0', '<AIPos A1="9999', "out of range"),
        ("<Run>1</Run>", "", "no Run"),
        ("<Run>1</Run>", "<Run>7</Run>", "no Run"),
        ("<IPOC>4", "<IPOC>-4", "no sequence number"),
        ("<Rob", '<!DOCTYPE r [<!ENTITY e "e">]><Rob', "not a message"),
        ("</Rob>", "</Rob>" + " " * 9000, "not a message"),
    ],
)
def test_a_telegram_that_says_nothing_to_trust_is_refused(wire: RsiWire, old: str, new: str, reason: str) -> None:
    data = wire.encode_feedback(feedback_at(np.zeros(6)), np.zeros(6)).replace(old.encode(), new.encode())
    with pytest.raises(PacketError, match=reason):
        wire.decode_feedback(data)


@pytest.mark.parametrize("cycle", [0.004, 0.012])
def test_corrections_reach_the_program_that_the_controller_runs(
    cycle: float, wave: SetpointPlan, axes: JointAxes, envelope: Envelope, irb4600: RobotDescription, arm: RigidArm
) -> None:
    wire, response = RsiWire(axes, cycle=cycle), SetpointResponse.low_pass(20.0, delay=0.0153)
    envelope = replace(envelope, patience=cycle + 0.004, ramp=0.002)
    session = StreamSession(wave, wire, envelope, irb4600.drive)
    rows = np.stack([np.interp(np.arange(0, 2.0 + 1e-9, cycle), wave.t, column) for column in wave.program.T], axis=1)
    robot = EmulatedRobot(irb4600, rows[0], cycle=cycle, response=response, arm=arm, program=rows)
    run_in_lock_step(session, EmulatedController(robot, wire))
    assert session.state == "ended"
    assert session.lost_after is None
    assert robot.missed == 0
    # the servo gets the program of the controller, and the correction after its delay and filter
    truth = irb4600.drive.joint_angle(robot.truth("wave").joint_array("reference.position"))
    beside = truth - _moving(truth, rows, robot)
    late = response.total_delay
    t = np.arange(len(truth)) * robot.plant.physics_dt
    began = t[np.flatnonzero(np.abs(truth[:, 0] - rows[0, 0]) > 0)[0]]
    expected = np.interp(t - began - late, wave.t, wave.correction[:, 0], left=0.0, right=0.0)
    assert np.abs(beside[:, 0] - expected).max() < 6e-5
    assert np.abs(beside[:, 0]).max() == pytest.approx(1e-3, rel=0.02)


def _moving(truth: np.ndarray, rows: np.ndarray, robot: EmulatedRobot) -> np.ndarray:
    """Program at the physics steps of a run, which begins with the first step that moves."""
    first = np.flatnonzero(np.abs(truth[:, 0] - rows[0, 0]) > 0)[0]
    t = (np.arange(len(truth)) - first + 1) * robot.plant.physics_dt
    return np.stack([np.interp(t, np.arange(len(rows)) * robot.cycle, column) for column in rows.T], axis=1)


def test_a_correction_of_a_lost_answer_is_held_and_late_answers_are_refused(
    wire: RsiWire, wave: SetpointPlan, envelope: Envelope, irb4600: RobotDescription, arm: RigidArm
) -> None:
    session = StreamSession(wave, wire, envelope, irb4600.drive)
    robot = EmulatedRobot(
        irb4600, wave.program[0], cycle=0.004, response=SetpointResponse(delay=0.004), arm=arm, program=wave.program
    )
    controller = EmulatedController(robot, wire)
    run_in_lock_step(session, controller, to_controller=Faults(drop=0.05, late=0.05, seed=3))
    assert session.state == "ended"
    assert robot.missed > 20
    assert set(controller.refused) == {"late", "out of order"}
    assert sum(controller.refused.values()) > 10
    assert session.lost_after is None


def test_a_program_that_is_broken_off_loses_its_correction(
    wire: RsiWire, wave: SetpointPlan, envelope: Envelope, irb4600: RobotDescription
) -> None:
    session = StreamSession(wave, wire, envelope, irb4600.drive)
    sent = []
    for k in range(300):
        feedback = feedback_at(wave.program[0], time=10 + 0.004 * k, started=20 <= k < 120)
        data = session.receive(wire.encode_feedback(feedback, feedback.position), 0.004 * k)
        sent.append(wire.decode_command(data).position[0])
    fade = round(envelope.fade / 0.004)
    assert np.array_equal(sent[:20], np.zeros(20))
    assert sent[119] > 1e-4
    assert all(value == 0.0 for value in sent[121 + fade :])


def test_a_cycle_that_is_longer_than_the_patience_is_refused(axes, wave, envelope, irb4600) -> None:
    with pytest.raises(FFGymError, match=r"patience = 10 ms must be longer than the controller's cycle of 12 ms"):
        StreamSession(wave, RsiWire(axes, cycle=0.012), envelope, irb4600.drive)
