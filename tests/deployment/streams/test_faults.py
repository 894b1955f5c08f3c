"""Streams over networks that lose, delay, repeat, reorder and corrupt packets.

10^5 packets for EGM; for the other protocols in `make test-all`, and a tenth of them in `make test`.
"""

from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np
import pytest

from ffgym.deployment import SetpointPlan
from ffgym.deployment.streams import (
    EgmWire,
    Envelope,
    JointAxes,
    PacketError,
    Ros2Wire,
    RsiWire,
    RtdeWire,
    StreamSession,
    Wire,
)
from ffgym.deployment.streams.emulators import EmulatedController, Faults, run_in_lock_step
from ffgym.robot import RobotDescription

PACKETS = 100_000
RUNS = [
    ("egm", PACKETS),
    *(
        pytest.param(protocol, packets, marks=[pytest.mark.slow] * (packets == PACKETS))
        for protocol in ("rsi", "rtde", "ros2")
        for packets in (PACKETS // 10, PACKETS)
    ),
]
ROUNDING = 1e-11
"""Rounding of positions on the wire [rad]."""
CYCLES = 400
"""Length of the plan of one session."""

WIRES = {"egm": EgmWire, "rsi": RsiWire, "rtde": RtdeWire, "ros2": Ros2Wire}


class StillRobot:
    """Robot that stays where it is, so that all of a set-point beside its pose is correction."""

    def __init__(self, cycle: float, position: np.ndarray) -> None:
        self.cycle, self.position, self.planned = cycle, position, position
        self.cycles = 0
        self.has_ended = False

    @property
    def runs(self) -> bool:
        """Tell if a controller with a program of its own runs it."""
        return 12 <= self.cycles < CYCLES + 100

    @property
    def time(self) -> float:
        return self.cycles * self.cycle

    def advance(self, setpoint: np.ndarray | None, torque: np.ndarray | None) -> None:
        self.cycles += 1


@dataclass
class Witness:
    """Notes on what goes in and out of a session, judged by its bytes alone."""

    wire: Wire
    made: dict[bytes, int]
    """Packets as the controller made them, and their order."""
    arrivals: int = 0
    newest: int = -1
    last_valid: float = float("nan")
    """Last time of a packet that may be valid: whole and newer than those before, or changed and readable."""
    lost: bool = False
    """True if there was no such packet for 20 ms after the first set-point."""
    sent: list[tuple[float, bool, bytes]] = field(default_factory=list)
    """Time, whether the correction has to be out, and bytes."""

    def watch(self, session: StreamSession) -> None:
        """Stand between a session and its network."""
        receive, tick = session.receive, session.tick

        def note_arrival(data: bytes, now: float) -> bytes | None:
            self._judge(data, now)
            return note_answer(receive(data, now), now)

        def note_answer(data: bytes | None, now: float) -> bytes | None:
            if data is not None and session.state != "waiting":
                self.sent.append((now, self.lost or now - self.last_valid > 0.020, data))
            return data

        session.receive, session.tick = note_arrival, lambda now: note_answer(tick(now), now)

    def _judge(self, data: bytes, now: float) -> None:
        self.arrivals += 1
        number = self.made.get(data)
        if number is None:
            with suppress(PacketError):
                self.wire.decode_feedback(data)
                self._hear(now)
        elif number > self.newest:
            self.newest = number
            self._hear(now)

    def _hear(self, now: float) -> None:
        self.lost |= bool(self.sent) and now - self.last_valid > 0.020
        self.last_valid = now


class RepeatedController(EmulatedController):
    """Controller that sends the same packets in every session, made once."""

    packets: list[bytes]
    made: dict[bytes, int]

    def feedback(self) -> bytes:
        number = self.robot.cycles
        if number == len(self.packets):
            self.packets.append(super().feedback())
            self.made[self.packets[-1]] = number
        return self.packets[number]

    def receive(self, data: bytes) -> None:
        """Take no set-point; they are looked at when all have been sent."""


def still_plan(wave: SetpointPlan, cycle: float) -> SetpointPlan:
    """Plan without motion, with a correction that uses all of its envelope."""
    t = np.arange(CYCLES) * cycle
    correction = 2e-3 * np.outer(np.sin(8 * t), [1, -1, 0.5, 1, -1, 0.5])
    return SetpointPlan(
        name="still",
        robot=wave.robot,
        law="made up",
        joints=wave.joints,
        units=wave.units,
        dt=cycle,
        program=np.tile(wave.program[0], (CYCLES, 1)),
        correction=correction,
        torque=0 * correction,
    )


def faults_of(seed: int) -> Faults:
    """Faults from mild to heavy."""
    strength = [0.002, 0.01, 0.05, 0.3][seed % 4]
    return Faults(drop=strength, corrupt=strength, duplicate=strength, late=strength, lateness=0.03, seed=seed)


@pytest.mark.parametrize(("protocol", "total"), RUNS)
def test_1e5_bad_packets_leave_every_correction_in_its_envelope_and_ramped_out_in_20_ms(
    protocol: str, total: int, wave: SetpointPlan, axes: JointAxes, envelope: Envelope, irb4600: RobotDescription
) -> None:
    wire = WIRES[protocol](axes)
    plan = still_plan(wave, wire.cycle)
    home, limits = plan.program[0], envelope.correction
    packets: list[bytes] = []
    made: dict[bytes, int] = {}
    count, endings, refused, uncorrected, full = 0, set(), 0, 0, 0
    for seed in range(total):
        session = StreamSession(plan, wire, envelope, irb4600.drive)
        witness = Witness(wire, made)
        witness.watch(session)
        controller = RepeatedController(StillRobot(wire.cycle, home), wire)
        controller.packets, controller.made = packets, made
        run_in_lock_step(session, controller, to_stream=faults_of(seed))
        times, out, data = zip(*witness.sent, strict=True)
        commands = [wire.decode_command(packet) for packet in data]
        correction = np.stack([command.position for command in commands]) - (0 if wire.needs_answers else home)
        clock = np.array([command.time for command in commands])
        # size, and change since the sample before; time of the plan never goes back
        assert np.all(np.abs(correction) <= limits.size + ROUNDING)
        most = np.outer(np.diff(clock), limits.rate) + np.outer(np.diff(times), limits.size / envelope.ramp)
        assert np.all(np.abs(np.diff(correction, axis=0)) <= most + 2 * ROUNDING)
        assert np.all(np.diff(clock) >= 0)
        # out in time
        assert np.all(np.abs(correction[list(out)]) < 1e-15)
        count += witness.arrivals
        endings.add(session.state)
        refused += sum(session.refused.values())
        uncorrected += any(out)
        full += session.lost_after is None
        if count >= total:
            break
    assert count >= total
    assert endings == {"ended"}
    # the test has both: sessions that lost their correction, and such that kept it to the end
    assert refused > 0.05 * total
    assert uncorrected > total / 20_000
    assert full > total / 20_000
