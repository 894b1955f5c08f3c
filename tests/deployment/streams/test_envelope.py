"""The safety envelope by itself: size, rate, and how corrections leave."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ffgym.control import CorrectionLimits
from ffgym.core.errors import FFGymError
from ffgym.deployment.streams import Envelope, Guard

DT = 0.004
SIZE, RATE = 1e-3, 0.02
ENVELOPE = Envelope(
    correction=CorrectionLimits.even(2, size=SIZE, rate=RATE, acceleration=3.0), torque=np.array([5.0, 1.0])
)


def full_guard(now: float = 0.0) -> Guard:
    """Guard that lets a whole correction of the largest size pass at `now`."""
    guard = Guard(ENVELOPE, DT)
    for k in range(-20, 1):
        guard.hear(now + k * DT)
        sent = guard.correct(np.array([SIZE, -SIZE]), 1, now + k * DT)
    assert np.allclose(sent, [SIZE, -SIZE], rtol=1e-12)
    return guard


def test_nothing_is_sent_before_the_first_valid_packet() -> None:
    guard = Guard(ENVELOPE, DT)
    assert np.array_equal(guard.correct(np.full(2, SIZE), 10, 0.0), np.zeros(2))
    assert np.array_equal(guard.torque(np.ones(2), 0.0), np.zeros(2))


@settings(max_examples=100)
@given(
    wanted=arrays(np.float64, (30, 2), elements=st.floats(allow_nan=True, allow_infinity=True)),
    samples=st.lists(st.integers(0, 3), min_size=30, max_size=30),
    waits=st.lists(st.floats(0.0, 0.03), min_size=30, max_size=30),
    valid=st.lists(st.booleans(), min_size=30, max_size=30),
    closed=st.integers(0, 60),
)
def test_no_sample_leaves_the_envelope_whatever_comes(wanted, samples, waits, valid, closed) -> None:
    guard, now, before = Guard(ENVELOPE, DT), 0.0, np.zeros(2)
    guard.hear(now)
    last_valid, gate = now, 1.0
    for k in range(30):
        now += waits[k]
        if k == closed:
            guard.close(now)
        if valid[k]:
            guard.hear(now)
        lost = now - last_valid > ENVELOPE.patience
        last_valid = now if valid[k] and not lost and guard.lost_at is None else last_valid
        sent = guard.correct(wanted[k], samples[k], now)
        assert np.all(np.abs(sent) <= SIZE)
        most = RATE * DT * samples[k] + SIZE * waits[k] / ENVELOPE.ramp
        assert np.all(np.abs(sent - before) <= most + 1e-15)
        assert guard.gate(now) <= gate
        if now - last_valid > 0.020:
            assert np.array_equal(sent, np.zeros(2))
        before, gate = sent, guard.gate(now)


def test_a_correction_that_is_wanted_too_large_stops_at_the_largest_size() -> None:
    guard = Guard(ENVELOPE, DT)
    guard.hear(0.0)
    sent = [guard.correct(np.array([1.0, -1.0]), 1, 0.0) for _ in range(30)]
    assert np.allclose(sent[0], [RATE * DT, -RATE * DT])
    assert np.array_equal(sent[-1], [SIZE, -SIZE])


def test_a_correction_is_out_20_ms_after_the_last_valid_packet_and_begins_to_leave_after_10() -> None:
    guard = full_guard()
    wanted = np.array([SIZE, -SIZE])
    times = np.arange(21) * 1e-3
    shares = np.array([guard.correct(wanted, 0, t)[0] / SIZE for t in times])
    assert np.allclose(shares[:11], 1.0)
    assert np.allclose(np.diff(shares[10:]), -1 / 10)
    assert shares[20] == 0.0


def test_a_stream_that_comes_back_gets_no_correction_again() -> None:
    guard = full_guard()
    for t in (0.0105, 0.011, 0.013, 0.020, 0.024, 1.0):
        guard.hear(t)
        sent = guard.correct(np.array([SIZE, -SIZE]), 1, t)
    assert guard.lost_at == 0.010
    assert np.array_equal(sent, np.zeros(2))


def test_a_stop_lets_the_correction_leave_within_the_fade_and_a_loss_faster() -> None:
    guard = full_guard()
    guard.close(0.0)
    gates = []
    for k in range(51):
        guard.hear(k * DT)
        gates.append(guard.gate(k * DT))
    assert np.allclose(np.diff(gates), -DT / ENVELOPE.fade)
    assert gates[-1] < 1e-12
    guard = full_guard()
    guard.close(0.0)
    assert guard.gate(0.020) == 0.0


def test_a_packet_whose_time_was_read_late_makes_no_silence() -> None:
    guard = full_guard()
    guard.hear(0.009)
    guard.hear(0.001)
    assert guard.gate(0.0185) == 1.0


def test_a_gate_is_never_wider_than_open_though_a_clock_is_read_late() -> None:
    guard = full_guard()
    guard.close(0.004)
    assert guard.gate(0.002) == 1.0


def test_torque_keeps_its_limit_and_leaves_with_the_correction() -> None:
    guard = full_guard()
    assert np.array_equal(guard.torque(np.array([9.0, -9.0]), 0.0), [5.0, -1.0])
    assert np.array_equal(guard.torque(np.array([np.nan, np.inf]), 0.0), [0.0, 0.0])
    assert np.allclose(guard.torque(np.array([4.0, 0.5]), 0.015), [2.0, 0.25])
    assert np.array_equal(guard.torque(np.array([4.0, 0.5]), 0.020), [0.0, 0.0])


def test_plans_within_the_limits_pass_unchanged_and_others_are_cut_to_them() -> None:
    t = np.arange(200) * DT
    within = 5e-4 * np.outer(np.sin(5 * t) ** 2, [1, -1])
    assert np.array_equal(ENVELOPE.limit(within, DT), within)
    assert ENVELOPE.cut_share(within, DT) == 0.0
    beyond = 4 * within
    cut = ENVELOPE.limit(beyond, DT)
    assert ENVELOPE.cut_share(beyond, DT) == pytest.approx(1.0, rel=1e-3)
    assert np.abs(cut).max() <= SIZE
    assert np.abs(np.diff(cut, axis=0)).max() <= RATE * DT * (1 + 1e-12)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"patience": 0.012}, r"patience \+ ramp = 22 ms: a correction must be out 20 ms after"),
        ({"ramp": 0.0}, "ramp = 0.0 s"),
        ({"torque": np.array([-1.0, 1.0])}, "must be >= 0"),
        ({"torque": np.ones(3)}, r"shape \(3,\), must be \(2\)"),
        ({"correction": CorrectionLimits.even(2, size=1e-3)}, "largest rate of the correction must be finite"),
    ],
)
def test_an_envelope_that_holds_nothing_back_is_refused(change: dict, message: str) -> None:
    with pytest.raises(FFGymError, match=message):
        replace(ENVELOPE, **change)
