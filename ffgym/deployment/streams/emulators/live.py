"""An emulator in real time: a controller that sends its packets to a port and takes what comes back."""

import heapq
import time
from collections.abc import Hashable
from itertools import count

from ffgym.deployment.streams.emulators.controller import EmulatedController
from ffgym.deployment.streams.emulators.lock_step import READ
from ffgym.deployment.streams.emulators.network import Faults, FaultyNetwork
from ffgym.deployment.streams.live import without_pauses
from ffgym.deployment.streams.ports import Port, sleep_until


def serve_live(
    controller: EmulatedController,
    port: Port,
    receiver: Hashable,
    *,
    to_stream: Faults | None = None,
    to_controller: Faults | None = None,
    longest: float = float("inf"),
) -> int:
    """Run an emulated controller in real time until a stream has come and gone; returns the cycles that began late.

    Args:
        controller: emulator.
        port: its port.
        receiver: address of the stream.
        to_stream: faults on the way to the stream; None is none.
        to_controller: faults on the way back.
        longest: time after which it ends in any case [s].
    """
    there, back = FaultyNetwork(to_stream or Faults(), 0), FaultyNetwork(to_controller or Faults(), 1)
    events: list[tuple[float, int, bool, bytes]] = []  # time, order, for the stream or not, packet
    order, late, cycle = count(), 0, controller.wire.cycle
    with without_pauses():
        start, k = time.perf_counter(), 0
        while not controller.stopped and k * cycle < longest:
            begin = start + k * cycle
            late += time.perf_counter() > begin + READ * cycle
            for arrival, data in there.carry(controller.feedback(), begin):
                heapq.heappush(events, (arrival, next(order), True, data))
            # deliver what is due, and take what comes, until the controller reads its set-point
            while (now := time.perf_counter()) < begin + READ * cycle:
                while events and events[0][0] <= now:
                    _, _, for_stream, data = heapq.heappop(events)
                    if for_stream:
                        port.send(data, receiver)
                    else:
                        controller.receive(data)
                until = min(begin + READ * cycle, events[0][0] if events else float("inf"))
                arrived = port.receive(until - time.perf_counter())
                if arrived is not None:
                    for arrival, data in back.carry(arrived[0], time.perf_counter()):
                        heapq.heappush(events, (arrival, next(order), False, data))
            controller.advance()
            k += 1
            sleep_until(start + k * cycle)
    return late
