"""A session in real time: packets from a port, its answers, and Ctrl-C."""

import gc
import time
from collections.abc import Hashable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np

from ffgym.core.errors import FFGymError, check_number
from ffgym.deployment.streams.ports import Port
from ffgym.deployment.streams.session import StreamSession

_LONGEST_WAIT = 0.1
"""Time between looks at the clock [s]."""


@dataclass(eq=False)
class Timing:
    """Speed of the answers."""

    answers: list[float] = field(default_factory=list)
    """Time from a packet to its answer [s], each."""

    def summary(self) -> dict[str, float]:
        """Summarise in microseconds: median, 99 % and slowest; empty without answers."""
        if not self.answers:
            return {}
        middle, most, worst = 1e6 * np.quantile(self.answers, [0.5, 0.99, 1.0])
        return {"median_us": float(middle), "p99_us": float(most), "slowest_us": float(worst)}


def run_live(session: StreamSession, port: Port, *, wait: float = 30.0) -> Timing:
    """Run a session in real time until it is over.

    The first Ctrl-C lets the correction leave, and the program goes on to its end; the second one ends the session at
    once, and the controller stops by its own rules.

    Args:
        session: stream.
        port: where the controller's packets arrive.
        wait: longest time until the controller lets the program begin [s].

    Raises:
        FFGymError: if the controller is silent, or its pose is not that of the program.
    """
    check_number("wait", wait, unit="s", low=0.0, open_low=True)
    timing, peer = Timing(), None
    give_up = time.perf_counter() + wait
    with without_pauses():
        while not session.is_over:
            try:
                peer = _step(session, port, peer, timing)
                if session.state == "waiting" and time.perf_counter() > give_up:
                    raise FFGymError(_describe_silence(session, wait))
            except KeyboardInterrupt:
                if session.state == "waiting" or session.is_stopped:
                    raise
                session.stop(time.perf_counter())
    if session.refusal:
        raise FFGymError(session.refusal)
    return timing


def _step(session: StreamSession, port: Port, peer: Hashable, timing: Timing) -> Hashable:
    """Wait for one packet and answer it, or for the time at which something is due; returns the controller's address.

    Once the program runs, packets of anybody else are refused.
    """
    arrived = port.receive(min(session.due - time.perf_counter(), _LONGEST_WAIT))
    now = time.perf_counter()
    if arrived is None:
        data = session.tick(now)
        if data is not None:
            port.send(data, peer)
        return peer
    packet, sender = arrived
    if session.state == "running" and sender != peer:
        session.refused["another sender"] += 1
        return peer
    data = session.receive(packet, now)
    if data is not None:
        port.send(data, sender)
        timing.answers.append(time.perf_counter() - now)
        return sender
    return peer


def _describe_silence(session: StreamSession, wait: float) -> str:
    if not session.received:
        return (
            f"No packet came within {wait:g} s. Check the address that the controller sends to, its program, and "
            f"firewalls."
        )
    refused = ", ".join(f"{count} {reason}" for reason, count in session.refused.most_common()) or "none"
    return (
        f"The controller sent {session.received} packets within {wait:g} s, but does not take set-points yet (refused: "
        f"{refused}). Motors must be on, and its program must run."
    )


@contextmanager
def without_pauses() -> Iterator[None]:
    """Keep Python from looking for unused objects while a block runs in real time."""
    was_on = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
