"""Universal Robots RTDE: packages, connections, the program on the robot, set-points and torques."""

import socket
import struct
import threading
from dataclasses import replace

import numpy as np
import pytest
from stream_samples import FollowingRobot

from ffgym.control import SetpointResponse
from ffgym.core.errors import FFGymError
from ffgym.deployment import SetpointPlan
from ffgym.deployment.streams import (
    Envelope,
    Feedback,
    JointAxes,
    PacketError,
    RtdeWire,
    ServoProgram,
    StreamCommand,
    StreamSession,
    TorqueProgram,
    record_session,
    write_urscript,
)
from ffgym.deployment.streams.emulators import DirectTorque, EmulatedController, EmulatedRobot, run_in_lock_step
from ffgym.deployment.streams.emulators.live import serve_live
from ffgym.deployment.streams.live import run_live
from ffgym.deployment.streams.rtde_ports import RtdePort, accept_rtde, connect_rtde
from ffgym.robot import RigidArm, RobotDescription


@pytest.fixture(scope="module")
def wire(axes: JointAxes) -> RtdeWire:
    return RtdeWire(axes)


def command_at(position: np.ndarray, time: float = 0.004) -> StreamCommand:
    return StreamCommand(
        sequence=9,
        time=time,
        position=position,
        correction=np.zeros(6),
        velocity=position / 2,
        effort=100 * position,
    )


def test_packages_have_the_layout_of_the_protocol(wire: RtdeWire) -> None:
    position = np.linspace(-0.5, 0.5, 6)
    data = wire.encode_command(command_at(position))
    assert struct.unpack_from(">HBBi", data) == (len(data), ord("U"), 1, 3)
    assert np.allclose(struct.unpack_from(">18d", data, 8), [*position, *position / 2, *100 * position])
    feedback = Feedback(sequence=0, time=12.346, position=position)
    back = wire.decode_feedback(wire.encode_feedback(feedback, position))
    assert (back.sequence, back.time, back.ready) == (6173, 12.346, True)
    assert np.array_equal(back.position, position)


def test_setpoints_whose_speed_or_torque_is_no_number_are_refused(wire: RtdeWire) -> None:
    for part in ("velocity", "effort"):
        wrong = replace(command_at(np.zeros(6)), **{part: np.array([0.0, 0.0, np.nan, 0.0, 0.0, 0.0])})
        with pytest.raises(PacketError, match="not finite"):
            wire.decode_command(wire.encode_command(wrong))


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda data: data[:-1], "length"),
        (lambda data: data + b"\0", "length"),
        (lambda data: data[:2] + b"M" + data[3:], "kind of message"),
        (lambda data: data[:4] + struct.pack(">d", float("nan")) + data[12:], "no sequence number"),
        (lambda data: data[:12] + struct.pack(">d", float("inf")) + data[20:], "not finite"),
        (lambda data: data[:12] + struct.pack(">d", 99.0) + data[20:], "out of range"),
    ],
)
def test_a_package_that_says_nothing_to_trust_is_refused(wire: RtdeWire, change, reason: str) -> None:
    data = wire.encode_feedback(Feedback(sequence=0, time=1.0, position=np.zeros(6)), np.zeros(6))
    with pytest.raises(PacketError, match=reason):
        wire.decode_feedback(change(data))


def test_a_robot_that_is_not_running_or_whose_program_is_not_takes_no_setpoints(wire: RtdeWire) -> None:
    data = wire.encode_feedback(Feedback(sequence=0, time=1.0, position=np.zeros(6)), np.zeros(6))
    for offset, value in ((-12, 3), (-8, 2), (-4, 0)):  # robot mode, safety mode, register of the program
        end = offset + 4 or len(data)
        changed = data[:offset] + struct.pack(">i", value) + data[end:]
        assert not wire.decode_feedback(changed).ready


def test_positions_are_sent_at_500_hz_from_a_plan_at_250(
    wire: RtdeWire, wave: SetpointPlan, envelope: Envelope, irb4600: RobotDescription, arm: RigidArm
) -> None:
    robot = EmulatedRobot(irb4600, wave.program[0], cycle=0.002, response=SetpointResponse(delay=0.004), arm=arm)
    session = StreamSession(wave, wire, envelope, irb4600.drive)
    run_in_lock_step(session, EmulatedController(robot, wire))
    assert session.state == "ended"
    log = record_session(session, irb4600)
    sent = irb4600.drive.joint_angle(log.joint_array("reference.position"))
    assert np.abs(sent[:1001:2] - wave.setpoints).max() < 1e-9
    assert robot.missed < 20


@pytest.mark.parametrize("scale", [0.0, 0.8])
def test_torques_replace_corrections_and_add_to_what_the_robot_compensates(
    scale: float, axes: JointAxes, wave: SetpointPlan, envelope: Envelope, irb4600: RobotDescription, arm: RigidArm
) -> None:
    wire = RtdeWire(axes, torques=True)
    robot = EmulatedRobot(irb4600, wave.program[0], cycle=0.002, response=SetpointResponse(delay=0.002), arm=arm)
    given = []
    advance = robot.advance

    def note(setpoint, torque):
        given.append((robot.motor_speed, torque))
        advance(setpoint, torque)

    robot.advance = note
    controller = EmulatedController(robot, wire, direct_torque=DirectTorque(viscous_scale=scale, coulomb_scale=scale))
    session = StreamSession(wave, wire, envelope, irb4600.drive)
    run_in_lock_step(session, controller)
    assert session.state == "ended"
    log = record_session(session, irb4600)
    assert not any(log[f"correction.position.{joint}"].any() for joint in irb4600.joints)
    sent = irb4600.drive.joint_angle(log.joint_array("reference.position"))
    assert np.abs(sent[:1001:2] - wave.program).max() < 1e-9
    # the torque of the plan reaches the motors, beside the friction that the robot knows
    speeds, torques = (np.stack(part) for part in zip(*given, strict=True))
    friction = irb4600.friction
    known = scale * (friction.viscous * speeds + friction.coulomb * np.sign(speeds))
    rows = (torques - known)[9 : 9 + 1001 : 2]
    assert np.abs(rows - wave.torque).max() < 1e-6


def test_setpoints_carry_the_speed_of_the_program(wire: RtdeWire, wave: SetpointPlan, envelope, irb4600) -> None:
    session = StreamSession(wave, wire, envelope, irb4600.drive)
    sent = []
    for k in range(300):
        feedback = Feedback(sequence=0, time=5 + 0.002 * k, position=wave.program[0])
        data = session.receive(wire.encode_feedback(feedback, feedback.position), 0.002 * k)
        sent += [] if data is None else [wire.decode_command(data)]
    speeds = [0.02 * np.pi * np.sin(np.pi * command.time) for command in sent]
    assert len(sent) > 250
    assert np.abs(np.stack([command.velocity for command in sent]) - np.array(speeds)[:, None]).max() < 1e-3
    assert np.abs(speeds).max() > 0.06


def test_torques_beyond_the_motors_are_cut(axes: JointAxes, wave: SetpointPlan, envelope, irb4600) -> None:
    wire = RtdeWire(axes, torques=True)
    loud = replace(wave, torque=1e3 * wave.torque)
    session = StreamSession(loud, wire, envelope, irb4600.drive)
    efforts = []
    for k in range(600):
        feedback = Feedback(sequence=0, time=5 + 0.002 * k, position=wave.program[0])
        data = session.receive(wire.encode_feedback(feedback, feedback.position), 0.002 * k)
        if data is not None:
            efforts.append(irb4600.drive.motor_torque(wire.decode_command(data).effort))
    largest = np.abs(efforts).max(axis=0)
    assert np.allclose(largest, envelope.torque)


@pytest.mark.parametrize(
    ("program", "line"),
    [
        (ServoProgram(), "servoj(q, t=0.002, lookahead_time=0.03, gain=2000)"),
        (
            TorqueProgram(stiffness=[900.0] * 6, damping=[60.0] * 6, coulomb_scale=[0.5] * 6),
            "direct_torque(torque, viscous_scale=[0.0, 0.0, 0.0, 0.0, 0.0, 0.0], "
            "coulomb_scale=[0.5, 0.5, 0.5, 0.5, 0.5, 0.5])",
        ),
        (TorqueProgram(stiffness=np.full(6, 900.0), damping=np.ones(6)), "stiffness = [900.0, 900.0, 900.0, 900.0,"),
    ],
)
def test_the_program_of_the_robot_reads_the_registers_and_ends_in_silence(program, line: str) -> None:
    text = write_urscript(program)
    assert line in text
    assert "write_output_integer_register(24, 1)" in text
    assert "q = [read_input_float_register(24), read_input_float_register(25)," in text
    assert "u = [read_input_float_register(36)," in text
    assert "while missed < 10:\n    number = read_input_integer_register(24)\n    if number == last:" in text
    assert "missed = missed + 1\n    else:\n      missed = 0\n    end\n    last = number" in text
    assert "  write_output_integer_register(24, 0)\n  stopj(4.0)\nend" in text
    openings = sum(text.count(word) for word in ("def ", "while ", "if "))
    assert openings == sum(line.strip() == "end" for line in text.splitlines())


def test_the_program_of_the_robot_adds_torques_to_a_position_control_towards_the_setpoint() -> None:
    text = write_urscript(TorqueProgram(stiffness=[900.0] * 6, damping=[60.0] * 6))
    assert "torque[j] = u[j] + stiffness[j] * (q[j] - q_now[j]) + damping[j] * (qd[j] - qd_now[j])" in text


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: ServoProgram(gain=50.0), "gain of servoj = 50.0 is out of range"),
        (lambda: ServoProgram(lookahead_time=0.3), "lookahead_time = 0.3 s is out of range"),
        (lambda: TorqueProgram(stiffness=[1.0] * 6, damping=[1.0] * 5), "damping has shape"),
        (
            lambda: TorqueProgram(stiffness=[1.0] * 6, damping=[1.0] * 6, viscous_scale=[1.5] * 6),
            "viscous_scale = .* must be within",
        ),
        (
            lambda: RtdeWire(JointAxes(names=("a",), units=("rad",), low=np.array([-1.0]), high=np.array([1.0]))),
            "robots of 6 hinges",
        ),
    ],
)
def test_programs_and_robots_that_cannot_be_are_refused(make, message: str) -> None:
    with pytest.raises(FFGymError, match=message):
        make()


def test_a_plan_is_sent_over_a_connection(
    wire: RtdeWire, brief: SetpointPlan, envelope: Envelope, irb4600: RobotDescription
) -> None:
    robot = FollowingRobot(irb4600, brief.program[0], cycle=0.002)
    address = ("127.0.0.1", free_port())

    def serve() -> None:
        port = accept_rtde(address, 20.0)
        serve_live(EmulatedController(robot, wire), port, None, longest=20.0)
        port.close()

    server = threading.Thread(target=serve)
    server.start()
    session = StreamSession(brief, wire, envelope, irb4600.drive)
    port = connect_patiently(address)
    run_live(session, port)
    port.close()
    server.join()
    assert session.state == "ended"
    assert robot.cycles > 300
    assert robot.missed < robot.cycles


@pytest.fixture
def ends():
    """Two ends of a connection."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        near = socket.create_connection(listener.getsockname())
        far, _ = listener.accept()
    ports = RtdePort(near), RtdePort(far)
    yield ports
    for port in ports:
        port.close()


def test_a_package_that_was_sent_in_part_goes_on_before_the_next(wire: RtdeWire, ends) -> None:
    class Narrow:
        """Socket with room for some bytes."""

        def __init__(self, real: socket.socket) -> None:
            self.real, self.room = real, 0

        def send(self, data: bytes) -> int:
            if self.room == 0:
                raise BlockingIOError
            taken = self.real.send(data[: self.room])
            self.room -= taken
            return taken

        def sendall(self, data: bytes) -> None:
            self.send(data)

        def close(self) -> None:
            self.real.close()

    near, far = ends
    near._socket = narrow = Narrow(near._socket)
    for k, room in enumerate([100, 20, 0, 1000]):
        narrow.room = room
        near.send(wire.encode_command(command_at(np.zeros(6), time=0.002 * k)), None)
    numbers = [wire.decode_command(far.receive(1.0)[0]).sequence for _ in range(2)]
    assert numbers == [1, 4]


def test_a_socket_that_has_nothing_after_all_is_asked_again(wire: RtdeWire, ends) -> None:
    class Hesitating:
        """Socket whose first bytes are not there yet when it says so."""

        def __init__(self, real: socket.socket) -> None:
            self.real, self.asked = real, 0

        def recv(self, count: int) -> bytes:
            self.asked += 1
            if self.asked == 1:
                raise BlockingIOError
            return self.real.recv(count)

        def close(self) -> None:
            self.real.close()

    near, far = ends
    far._socket = Hesitating(far._socket)
    near.send(wire.encode_command(command_at(np.zeros(6))), None)
    assert far.receive(5.0) is not None


REFUSALS = {
    b"\x00DOUBLE,VECTOR6D,VECTOR6D,INT32,IN_USE,INT32": r"refuses RTDE fields safety_mode \(IN_USE\)",
    b"\x02DOUBLE,VECTOR6D,VECTOR6D,INT32,INT32,INT32": "gives RTDE recipe 2 where 1 is the first",
}


@pytest.mark.parametrize(("recipe", "message"), REFUSALS.items())
def test_a_recipe_that_another_client_has_is_refused(recipe: bytes, message: str) -> None:
    address = ("127.0.0.1", free_port())

    listener = socket.create_server(address)

    def serve() -> None:
        connection, _ = listener.accept()
        port = RtdePort(connection)
        while (package := port.next_package(0.5)) is not None:
            kind = package[2]
            answer = b"\x01" if kind == ord("V") else recipe
            port.send(struct.pack(">HB", 3 + len(answer), kind) + answer, None)
        port.close()

    server = threading.Thread(target=serve)
    server.start()
    with pytest.raises(FFGymError, match=message):
        connect_rtde(address)
    server.join()
    listener.close()


def test_an_address_without_a_robot_is_one_error() -> None:
    with pytest.raises(FFGymError, match=r"Cannot connect to 127\.0\.0\.1:.*Connection refused"):
        connect_rtde(("127.0.0.1", free_port()))
    with pytest.raises(FFGymError, match="no client came"):
        accept_rtde(("127.0.0.1", free_port()), 0.05)


def connect_patiently(address: tuple[str, int]) -> RtdePort:
    """Connect once the server listens."""
    for _ in range(200):
        try:
            return connect_rtde(address)
        except FFGymError:
            threading.Event().wait(0.05)
    raise AssertionError("the server never listened")


def free_port() -> int:
    """Return a port of TCP that nobody has."""

    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
