"""A stream and an emulator in lock-step: one clock that nobody waits for, the same result every time."""

import heapq
from collections.abc import Callable
from itertools import count

from ffgym.core.errors import FFGymError
from ffgym.deployment.streams.emulators.controller import EmulatedController
from ffgym.deployment.streams.emulators.network import Faults, Network
from ffgym.deployment.streams.session import StreamSession

READ = 0.5
"""Share of a cycle in which the controller waits for an answer (chosen); what comes later counts for the next one."""


def run_in_lock_step(
    session: StreamSession,
    controller: EmulatedController,
    *,
    to_stream: Faults | None = None,
    to_controller: Faults | None = None,
    longest: float = 600.0,
    watch: Callable[[float, bytes], None] | None = None,
) -> float:
    """Run a session against an emulator until it is over; returns the time that took, on their clock [s].

    Args:
        session: stream.
        controller: emulator.
        to_stream: faults on the way from the controller; None is none.
        to_controller: faults on the way to it.
        longest: time after which a session that does not end is an error [s].
        watch: called with time and bytes of every packet that the stream sends.

    Raises:
        FFGymError: if the session refused to begin, or did not end in time.
    """
    there, back = Network(to_stream or Faults(), 0), Network(to_controller or Faults(), 1)
    cycle, order = session.wire.cycle, count()
    events: list[tuple[float, int, bool, bytes]] = []  # time, order, for the stream or not, packet

    def send(packet: bytes | None, now: float) -> None:
        if packet is not None:
            if watch is not None:
                watch(now, packet)
            for arrival, data in back.carry(packet, now):
                heapq.heappush(events, (arrival, next(order), False, data))

    def run_until(end: float) -> None:
        while True:
            next_event = events[0][0] if events else float("inf")
            if min(next_event, session.due) > end:
                return
            if session.due < next_event:
                due = session.due
                send(session.tick(due), due)
                continue
            now, _, for_stream, data = heapq.heappop(events)
            if for_stream:
                send(session.receive(data, now), now)
            else:
                controller.receive(data)

    k = 0
    while not session.is_over:
        now = k * cycle
        if now > longest:
            raise FFGymError(f"The session is {session.state} after {longest:g} s, and should have ended.")
        for arrival, data in there.carry(controller.feedback(), now):
            heapq.heappush(events, (arrival, next(order), True, data))
        run_until(now + READ * cycle)
        controller.advance()
        k += 1
        run_until(k * cycle - 1e-9)
    if session.refusal:
        raise FFGymError(session.refusal)
    return k * cycle
