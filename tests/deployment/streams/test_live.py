"""Streams and emulators in real time, over sockets of the loopback interface."""

import gc
import threading

import numpy as np
import pytest
from stream_samples import FollowingRobot

from ffgym.control import SetpointResponse
from ffgym.core.errors import FFGymError
from ffgym.deployment import SetpointPlan
from ffgym.deployment.streams import EgmWire, Envelope, JointAxes, StreamSession, record_session
from ffgym.deployment.streams.emulators import EmulatedController, EmulatedRobot, Faults
from ffgym.deployment.streams.emulators.live import serve_live
from ffgym.deployment.streams.live import run_live
from ffgym.deployment.streams.ports import UdpPort, parse_address
from ffgym.robot import RigidArm, RobotDescription


class Served:
    """Emulated controller that runs in a thread while a test streams to it."""

    def __init__(self, controller: EmulatedController, receiver: tuple[str, int], faults: Faults | None = None) -> None:
        self.port = UdpPort(("127.0.0.1", 0))
        options = {"to_stream": faults, "longest": 20.0}
        self.thread = threading.Thread(target=serve_live, args=(controller, self.port, receiver), kwargs=options)

    def __enter__(self) -> None:
        self.thread.start()

    def __exit__(self, *_: object) -> None:
        self.thread.join()
        self.port.close()


@pytest.fixture
def controller(axes: JointAxes, wave: SetpointPlan, irb4600: RobotDescription) -> EmulatedController:
    wire = EgmWire(axes)
    return EmulatedController(FollowingRobot(irb4600, wave.program[0], wire.cycle), wire)


def test_a_plan_is_sent_over_sockets_as_in_lock_step(
    axes: JointAxes, wave: SetpointPlan, envelope: Envelope, irb4600: RobotDescription, arm: RigidArm
) -> None:
    response = SetpointResponse.low_pass(20.0, delay=0.0093)
    robot = EmulatedRobot(irb4600, wave.program[0], cycle=EgmWire.cycle, response=response, arm=arm)
    controller = EmulatedController(robot, EgmWire(axes))
    session = StreamSession(wave, controller.wire, envelope, irb4600.drive)
    with UdpPort(("127.0.0.1", 0)) as port, Served(controller, port.address):
        timing = run_live(session, port)
    assert session.state == "ended"
    assert set(timing.summary()) == {"median_us", "p99_us", "slowest_us"}
    log = record_session(session, irb4600)
    # every set-point is one of the plan, and but for pauses of the machine that runs the test the one of its time
    sent = irb4600.drive.joint_angle(log.joint_array("reference.position"))
    index = np.minimum(np.round(log.t / 0.004).astype(int), 500)
    program = sent - irb4600.drive.joint_angle(log.joint_array("correction.position"))
    assert np.abs(program[:, :1] - wave.program[:, 0]).min(axis=1).max() < 1e-12
    assert np.median(np.abs(program - wave.program[index]).max(axis=1)) < 1e-12
    assert controller.robot.cycles > 500


def test_a_controller_that_is_silent_or_elsewhere_ends_a_session_with_the_reason(
    controller: EmulatedController, wave: SetpointPlan, envelope: Envelope, irb4600: RobotDescription
) -> None:
    session = StreamSession(wave, controller.wire, envelope, irb4600.drive)
    with UdpPort(("127.0.0.1", 0)) as port:
        with pytest.raises(FFGymError, match=r"No packet came within 0\.05 s"):
            run_live(session, port, wait=0.05)
        with pytest.raises(FFGymError, match=r"Cannot listen at 127\.0\.0\.1:\d+: Address already in use"):
            UdpPort(port.address)
        with UdpPort(("127.0.0.1", 0)) as stranger:
            stranger.send(b"hello", port.address)
            with pytest.raises(FFGymError, match=r"sent 1 packets .* \(refused: 1 not a message\)"):
                run_live(session, port, wait=0.05)


def test_an_emulator_does_not_pause_to_collect_garbage(controller: EmulatedController, monkeypatch) -> None:
    seen, advance = [], controller.advance

    def watched() -> None:
        seen.append(gc.isenabled())
        advance()

    monkeypatch.setattr(controller, "advance", watched)
    with UdpPort(("127.0.0.1", 0)) as port, UdpPort(("127.0.0.1", 0)) as stream:
        serve_live(controller, port, stream.address, longest=0.02)
    assert seen == [False] * 5
    assert gc.isenabled()


def test_packets_of_another_sender_are_refused_while_a_program_runs(
    controller: EmulatedController,
    brief: SetpointPlan,
    envelope: Envelope,
    irb4600: RobotDescription,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    session = StreamSession(brief, controller.wire, envelope, irb4600.drive)
    stranger, receive, sent = UdpPort(("127.0.0.1", 0)), session.receive, []
    with UdpPort(("127.0.0.1", 0)) as port, Served(controller, port.address):

        def send_once_it_runs(data: bytes, now: float) -> bytes | None:
            if session.state == "running" and not sent:
                sent.append(now)
                stranger.send(controller.feedback(), port.address)
            return receive(data, now)

        monkeypatch.setattr(session, "receive", send_once_it_runs)
        run_live(session, port)
    stranger.close()
    assert session.refused["another sender"] == 1
    assert session.state == "ended"


def test_ctrl_c_lets_the_correction_leave_and_the_program_end(
    controller: EmulatedController,
    wave: SetpointPlan,
    envelope: Envelope,
    irb4600: RobotDescription,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    session = StreamSession(wave, controller.wire, envelope, irb4600.drive)
    receive, interrupted = session.receive, []

    def interrupt_once(data: bytes, now: float) -> bytes | None:
        if session.log.time and session.log.time[-1] > 0.4 and not interrupted:
            interrupted.append(session.log.time[-1])
            raise KeyboardInterrupt
        return receive(data, now)

    monkeypatch.setattr(session, "receive", interrupt_once)
    with UdpPort(("127.0.0.1", 0)) as port, Served(controller, port.address):
        run_live(session, port)
    log = record_session(session, irb4600)
    assert session.is_stopped
    assert session.state == "ended"
    assert log.t[-1] > wave.t[-1] - 0.2  # less if this machine paused at the end
    # the fade is of our clock, the rows of the controller's
    assert np.all(log["correction.position.j1"][log.t > interrupted[0] + envelope.fade + 0.05] == 0.0)


def test_a_second_ctrl_c_ends_a_session_at_once(
    wave: SetpointPlan, envelope: Envelope, irb4600: RobotDescription, axes: JointAxes
) -> None:
    session = StreamSession(wave, EgmWire(axes), envelope, irb4600.drive)
    session.state = "running"

    class Interrupted:
        """Port at which a user presses Ctrl-C again and again."""

        pressed = 0

        def receive(self, timeout: float) -> None:
            self.pressed += 1
            assert self.pressed < 4
            raise KeyboardInterrupt

    port = Interrupted()
    with pytest.raises(KeyboardInterrupt):
        run_live(session, port)
    assert session.is_stopped
    assert port.pressed == 2


@pytest.mark.parametrize(
    ("text", "address"),
    [("10.0.0.2:7000", ("10.0.0.2", 7000)), ("10.0.0.2", ("10.0.0.2", 6510)), (":7000", ("127.0.0.1", 7000))],
)
def test_addresses_are_read(text: str, address: tuple[str, int]) -> None:
    assert parse_address(text, 6510) == address


@pytest.mark.parametrize("text", ["host:port", "host:0", "host:70000"])
def test_addresses_that_cannot_be_are_refused(text: str) -> None:
    with pytest.raises(FFGymError, match=f"port of '{text}'"):
        parse_address(text, 6510)
