"""Order of packets: what is refused, why, and that it changes nothing."""

import numpy as np
import pytest

from ffgym.deployment.streams import EgmWire, Feedback, JointAxes
from ffgym.deployment.streams.validity import FIRST, Order


@pytest.fixture(scope="module")
def wire(axes: JointAxes) -> EgmWire:
    return EgmWire(axes)


def packet(wire: EgmWire, number: int, time: float) -> bytes:
    return wire.encode_feedback(Feedback(sequence=number, time=time, position=np.zeros(6)), np.zeros(6))


@pytest.fixture
def order(wire: EgmWire) -> Order:
    """Order that has heard packets 0 to 19, the last one at 0.076 s."""
    made = Order(wire)
    for k in range(20):
        assert made.read(packet(wire, k, 50 + 0.004 * k), 0.004 * k) is not None
    return made


@pytest.mark.parametrize(
    ("number", "stamp", "now", "reason"),
    [
        (19, 50.076, 0.077, "duplicate"),
        (18, 50.072, 0.077, "out of order"),
        (20, 50.076, 0.080, "old time"),
        (20, 50.080, 0.092, "late"),
        (21, 50.092, 0.084, "ahead of its time"),
        (40, 50.080, 0.080, "number ahead of its time"),
    ],
)
def test_a_packet_that_does_not_fit_is_counted_and_the_next_one_taken(
    order: Order, wire: EgmWire, number: int, stamp: float, now: float, reason: str
) -> None:
    assert order.read(packet(wire, number, stamp), now) is None
    assert order.refused == {reason: 1}
    assert order.read(packet(wire, 24, 50.096), 0.096) is not None


def test_packets_are_taken_over_the_end_of_the_numbers(wire: EgmWire) -> None:
    order = Order(wire)
    for k in range(20):
        assert order.read(packet(wire, 2**32 - 10 + k, 50 + 0.004 * k), 0.004 * k) is not None
    assert not order.refused


def test_a_slow_drift_of_the_clocks_is_followed(wire: EgmWire) -> None:
    order = Order(wire)
    for k in range(50_000):  # 200 s, in which the clocks come apart by 20 ms
        now = 0.004 * k
        if k % 50 == 0:
            assert order.read(packet(wire, k, round(50 + now * (1 - 1e-4), 3)), now) is not None
    assert not order.refused


@pytest.mark.parametrize(("number", "stamp"), [(7, 9000.0), (7, 1.0), (100_000, 50.0), (0, 50.2)])
def test_a_first_packet_that_is_wrong_does_not_lock_the_others_out(wire: EgmWire, number: int, stamp: float) -> None:
    order = Order(wire)
    order.read(packet(wire, number, stamp), 0.0)
    taken = [order.read(packet(wire, 10 + k, 50 + 0.004 * k), 0.004 * k) for k in range(1, 40)]
    assert all(feedback is not None for feedback in taken[2:])
    assert order.agreed >= FIRST


def test_packets_out_of_a_queue_do_not_run_ahead_of_the_clock(order: Order, wire: EgmWire) -> None:
    taken = [order.read(packet(wire, k, 50 + 0.004 * k), 0.080) for k in range(20, 100)]
    assert sum(feedback is not None for feedback in taken) <= 3
    assert order.refused["ahead of its time"] >= 77


def test_packets_that_waited_before_the_start_do_not_agree(wire: EgmWire) -> None:
    order = Order(wire)
    for k in range(100):  # 0.4 s in a queue, read at once
        assert order.read(packet(wire, k, 50 + 0.004 * k), 0.4) is not None
    assert order.agreed < FIRST
    for k in range(100, 100 + FIRST):
        assert order.read(packet(wire, k, 50 + 0.004 * k), 0.004 * k) is not None
    assert order.agreed >= FIRST
