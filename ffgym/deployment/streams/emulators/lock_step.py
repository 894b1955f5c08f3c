"""A stream and an emulator in lock-step: one clock that nobody waits for, the same result every time."""

import heapq
from collections.abc import Callable
from itertools import count

from ffgym.core.errors import FFGymError
from ffgym.deployment.streams.emulators.controller import EmulatedController
from ffgym.deployment.streams.emulators.network import Faults, FaultyNetwork
from ffgym.deployment.streams.session import StreamSession
from ffgym.simulation.run import Progress

READ = 0.5
"""Share of a cycle in which the controller waits for an answer (chosen); what comes later counts for the next one."""
_TOLD = 50
"""Cycles from one call of `progress` to the next."""


def run_in_lock_step(
    session: StreamSession,
    controller: EmulatedController,
    *,
    to_stream: Faults | None = None,
    to_controller: Faults | None = None,
    longest: float = 600.0,
    watch: Callable[[float, bytes], None] | None = None,
    progress: Progress | None = None,
) -> float:
    """Run a session against an emulator until it is over; returns the time that took, on their clock [s].

    Args:
        session: stream.
        controller: emulator.
        to_stream: faults on the way from the controller; None is none.
        to_controller: faults on the way to it.
        longest: time after which a session that does not end is an error [s].
        watch: called with time and bytes of every packet that the stream sends.
        progress: called with the seconds of the plan that are done and all of them.

    Raises:
        FFGymError: if the session refused to begin, or did not end in time.
    """
    there = FaultyNetwork(to_stream or Faults(), 0)
    exchange = _Exchange(session, controller, FaultyNetwork(to_controller or Faults(), 1), watch)
    cycle, duration, k = session.wire.cycle, float(session.plan.t[-1]), 0
    while not session.is_over:
        now = k * cycle
        if now > longest:
            raise FFGymError(f"The session is {session.state} after {longest:g} s, and should have ended.")
        if progress is not None and k % _TOLD == 0:
            progress(min(now, duration), duration)
        for arrival, data in there.carry(controller.feedback(), now):
            exchange.deliver(arrival, data, for_stream=True)
        exchange.run_until(now + READ * cycle)
        controller.advance()
        k += 1
        exchange.run_until(k * cycle - 1e-9)
    if session.refusal:
        raise FFGymError(session.refusal)
    return k * cycle


class _Exchange:
    """Packets on their way between a session and a controller, in the order in which they arrive."""

    def __init__(
        self,
        session: StreamSession,
        controller: EmulatedController,
        back: FaultyNetwork,
        watch: Callable[[float, bytes], None] | None,
    ) -> None:
        self._session, self._controller, self._back, self._watch = session, controller, back, watch
        self._order = count()
        self._events: list[tuple[float, int, bool, bytes]] = []  # time, order, for the stream or not, packet

    def deliver(self, arrival: float, data: bytes, *, for_stream: bool) -> None:
        """Let a packet arrive at a time [s]."""
        heapq.heappush(self._events, (arrival, next(self._order), for_stream, data))

    def run_until(self, end: float) -> None:
        """Let everything happen that is due until `end` [s]."""
        session = self._session
        while True:
            arrival = self._events[0][0] if self._events else float("inf")
            due = session.due
            if min(arrival, due) > end:
                return
            if due < arrival:
                self._send(session.tick(due), due)
                continue
            now, _, for_stream, data = heapq.heappop(self._events)
            if for_stream:
                self._send(session.receive(data, now), now)
            else:
                self._controller.receive(data)

    def _send(self, packet: bytes | None, now: float) -> None:
        if packet is None:
            return
        if self._watch is not None:
            self._watch(now, packet)
        for arrival, data in self._back.carry(packet, now):
            self.deliver(arrival, data, for_stream=False)
