"""Sessions packet by packet: plan time, losses, stops, ends, and plans of another sample time."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.deployment import SetpointPlan
from ffgym.deployment.streams import EgmWire, Envelope, Feedback, JointAxes, StreamSession, record_session, summarise
from ffgym.deployment.streams.session import sample_plan
from ffgym.robot import RobotDescription

CLOCK = 100.0
"""Time of the controller at the first packet [s]."""


class Bench:
    """Session with a controller that sends what a test tells it to, at the time of its stamp."""

    def __init__(self, plan: SetpointPlan, axes: JointAxes, envelope: Envelope, robot: RobotDescription) -> None:
        self.wire, self.plan = EgmWire(axes), plan
        self.session = StreamSession(plan, self.wire, envelope, robot.drive)
        self.packet = 0

    def feed(self, *, late: float = 0.0, skip: int = 0, ready: bool = True, away: float = 0.0) -> np.ndarray | None:
        """Send the next packet, of a robot so far from its program; returns the set-point that came back."""
        self.packet += skip
        time = 0.004 * self.packet
        position = self.plan.program[0] + away
        feedback = Feedback(sequence=self.packet, time=CLOCK + time, position=position, ready=ready)
        data = self.session.receive(self.wire.encode_feedback(feedback, feedback.position), time + late)
        self.packet += 1
        return None if data is None else self.wire.decode_command(data).position

    def begin(self) -> None:
        """Send packets up to the first set-point."""
        while self.feed() is None:
            assert self.packet < 20

    @property
    def now(self) -> float:
        """Time of the last packet [s]."""
        return 0.004 * (self.packet - 1)


@pytest.fixture
def bench(wave: SetpointPlan, axes: JointAxes, envelope: Envelope, irb4600: RobotDescription) -> Bench:
    made = Bench(wave, axes, envelope, irb4600)
    made.begin()
    return made


def test_ten_packets_come_before_the_first_setpoint(wave, axes, envelope, irb4600) -> None:
    bench = Bench(wave, axes, envelope, irb4600)
    answers = [bench.feed() for _ in range(11)]
    assert all(answer is None for answer in answers[:9])
    assert np.allclose(answers[9], wave.setpoints[0], atol=1e-15)
    assert np.allclose(answers[10], wave.setpoints[1], atol=1e-15)


def test_a_controller_that_takes_no_setpoints_yet_gets_none(wave, axes, envelope, irb4600) -> None:
    bench = Bench(wave, axes, envelope, irb4600)
    assert all(bench.feed(ready=False) is None for _ in range(50))
    assert bench.session.state == "waiting"
    assert bench.feed() is not None


def test_one_packet_of_another_pose_may_be_damaged_and_two_refuse_the_session(wave, axes, envelope, irb4600) -> None:
    bench = Bench(wave, axes, envelope, irb4600)
    assert all(bench.feed() is None for _ in range(9))
    assert bench.feed(away=0.1) is None
    assert bench.session.state == "waiting"
    assert bench.feed() is not None

    other = Bench(wave, axes, envelope, irb4600)
    assert all(other.feed(away=0.1) is None for _ in range(10))
    assert other.session.state == "refused"


def test_the_program_keeps_its_time_over_lost_and_late_packets(bench: Bench, wave: SetpointPlan) -> None:
    bench.feed()
    assert np.allclose(bench.feed(skip=1), wave.setpoints[3], atol=1e-15)
    assert np.allclose(bench.feed(late=0.003), wave.setpoints[4], atol=1e-15)
    assert np.allclose(bench.feed(late=0.001), wave.setpoints[5], atol=1e-15)


def test_silence_is_filled_with_the_setpoints_of_its_time(bench: Bench, wave: SetpointPlan) -> None:
    start = bench.now
    assert bench.session.tick(start + 0.005) is None
    for k in (1, 2, 3):
        data = bench.session.tick(start + 0.0021 + 0.004 * k)
        sent = bench.wire.decode_command(data)
        assert sent.time == pytest.approx(0.004 * k)
        share = min(1.0, 1 - (0.0021 + 0.004 * k - 0.010) / 0.010)  # of the correction, which leaves
        assert np.allclose(sent.position, wave.program[k] + share * wave.correction[k], atol=1e-15)


def test_a_stream_that_is_lost_and_comes_back_goes_on_without_correction(bench: Bench, wave: SetpointPlan) -> None:
    for _ in range(100):
        bench.feed()
    back = bench.feed(skip=25)
    assert np.allclose(back, wave.program[126], atol=1e-15)
    assert not np.allclose(back, wave.setpoints[126], atol=1e-5)
    while not bench.session.is_over:
        last = bench.feed()
    assert bench.session.state == "ended"
    assert np.allclose(last, wave.program[-1], atol=1e-15)
    assert bench.session.lost_after == pytest.approx(0.4 + 0.010)


def test_a_session_is_given_up_after_half_a_second_of_silence_or_of_motors_that_are_off(bench: Bench) -> None:
    for _ in range(30):
        bench.feed(ready=False)
    assert bench.session.refused["not ready"] == 30
    start = bench.now
    for k in range(150):
        bench.session.tick(start + 0.004 * k)
    assert bench.session.state == "lost"
    assert bench.feed() is None


def test_a_stop_lets_the_correction_leave_and_the_program_go_on(bench: Bench, wave: SetpointPlan, envelope) -> None:
    for _ in range(100):
        bench.feed()
    bench.session.stop(bench.now)
    after = np.array([bench.feed() for _ in range(100)]) - wave.program[101:201]
    share = after[:, 0] / wave.correction[101:201, 0]
    assert np.allclose(np.diff(share[:49]), -0.004 / envelope.fade, atol=1e-9)
    assert np.allclose(after[50:], 0.0, atol=1e-15)


def test_the_correction_leaves_at_the_end_and_the_last_pose_is_held(wave, axes, envelope, irb4600) -> None:
    ending = replace(wave, correction=np.minimum(wave.t[:, None] * 0.005, 1e-3) * np.ones(6))
    bench = Bench(ending, axes, envelope, irb4600)
    bench.begin()
    sent = []
    while not bench.session.is_over:
        sent.append(bench.feed() - ending.program[min(len(sent) + 1, 500)])
    assert bench.session.state == "ended"
    assert len(sent) == 500 + round(envelope.fade / 0.004)
    assert np.allclose(sent[499], 1e-3, atol=1e-12)
    assert np.abs(np.diff(sent[499:], axis=0)).max() <= 1e-3 * 0.004 / envelope.fade + 1e-12
    assert np.array_equal(sent[-1], np.zeros(6))


def test_what_exceeds_the_limits_is_cut_and_said(wave, axes, envelope, irb4600) -> None:
    loud = replace(wave, correction=3 * wave.correction)
    bench = Bench(loud, axes, envelope, irb4600)
    assert bench.session.cut_share == pytest.approx(0.5, rel=1e-3)
    bench.begin()
    sent = np.array([bench.feed() for _ in range(499)]) - wave.program[1:500]
    assert np.abs(sent).max() == pytest.approx(2e-3, rel=1e-3)
    assert np.abs(sent).max() <= 2e-3 + 1e-12


def test_plans_of_another_sample_time_are_sent_at_the_cycle(wave, axes, envelope, irb4600) -> None:
    t = np.arange(1001) * 0.002
    fine = replace(
        wave,
        dt=0.002,
        **{name: np.stack([np.interp(t, wave.t, x) for x in getattr(wave, name).T], axis=1) for name in ("torque",)},
        program=wave.program[0] + 0.02 * np.outer(1 - np.cos(np.pi * t), np.ones(6)),
        correction=1e-3 * np.outer(np.sin(np.pi * t) ** 2, [1, -1, 0.5, 1, -1, 0.5]),
    )
    bench = Bench(fine, axes, envelope, irb4600)
    bench.begin()
    sent = np.array([bench.feed() for _ in range(499)])
    assert np.abs(sent - wave.setpoints[1:500]).max() < 1e-9
    short = replace(fine, **{name: getattr(fine, name)[:3] for name in ("program", "correction", "torque")})
    with pytest.raises(FFGymError, match="too short for a cycle"):
        StreamSession(short, bench.wire, envelope, irb4600.drive)


def test_samples_of_a_plan_end_before_it_does(wave: SetpointPlan) -> None:
    program, correction, _ = sample_plan(wave, 0.012)
    t = np.arange(len(program)) * 0.012
    assert 2.0 - 0.012 < t[-1] <= 2.0
    assert np.abs(program[:, 0] - wave.program[0, 0] - 0.02 * (1 - np.cos(np.pi * t))).max() < 1e-8
    assert np.abs(correction[:, 1] + 1e-3 * np.sin(np.pi * t) ** 2).max() < 1e-8


def test_a_summary_tells_how_a_session_ended(bench: Bench, irb4600: RobotDescription) -> None:
    with pytest.raises(FFGymError, match="there is no log of it"):
        record_session(bench.session, irb4600)
    while not bench.session.is_over:
        bench.feed()
    told = summarise(bench.session)
    assert told["state"] == "ended"
    assert told["refused"] == {}
    assert told["received"] == told["sent"] + 9
    assert told["correction_lost_after"] is None
    assert told["largest_correction"] == pytest.approx([1e-3, 1e-3, 5e-4, 1e-3, 1e-3, 5e-4], rel=1e-3)
