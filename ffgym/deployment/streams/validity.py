"""Packets of a controller in order and in time, and counts of all that are not."""

from collections import Counter
from typing import final

from ffgym.deployment.streams.wire import Feedback, PacketError, Wire

FIRST = 10
"""Packets that must agree with each other before any is trusted (chosen): they tell the difference of the clocks."""
_OLDEST = 0.010
"""Age at which a packet is of no use [s]: beyond it the next ones have come (chosen)."""
_AHEAD = 0.005
"""How far packets may be ahead of those that agreed first [s] (chosen): the controller's clock jumped if it is more."""
_QUEUED = 0.5
"""Share of a cycle by which a packet follows the one before so closely that both waited in a queue (chosen)."""
_ANOTHER = 0.1
"""Disagreement of clocks that no network explains [s] (chosen)."""
_DRIFT = 1e-3
"""Largest difference in rate of the two clocks [1]; crystals differ by 1e-4 at most."""


@final
class Order:
    """Judge of sequence numbers and times; what is refused changes nothing.

    Until `FIRST` packets have agreed, one that contradicts those before it takes their place, as any of them may be
    the wrong one.
    """

    def __init__(self, wire: Wire) -> None:
        """Begin before the first packet of `wire`."""
        self._wire = wire
        self._last: Feedback | None = None
        self._offset = 0.0
        self._floor = 0.0
        self._heard = 0.0
        self.agreed = 0
        """Packets that agreed with those before them."""
        self.refused: Counter[str] = Counter()
        """Packets that were refused, by reason."""

    def read(self, data: bytes, now: float) -> Feedback | None:
        """Read a packet; None, and a count, if nothing in it can be trusted.

        Args:
            data: the packet.
            now: the receiver's clock [s].
        """
        try:
            feedback = self._wire.decode_feedback(data)
            self._check(feedback, now)
        except PacketError as error:
            self.refused[str(error)] += 1
            return None
        return feedback

    def _check(self, feedback: Feedback, now: float) -> None:
        last, offset = self._last, now - feedback.time
        if last is None:
            self._begin_with(feedback, now)
            return
        # newer than the last one, by number and by time
        newer = (feedback.sequence - last.sequence) % self._wire.wrap
        if newer == 0:
            raise PacketError("duplicate")
        before = newer > self._wire.wrap // 2
        if before or feedback.time <= last.time:
            contradicts = before != (feedback.time <= last.time) or last.time - feedback.time > _ANOTHER
            self._doubt(feedback, now, contradicts)
            raise PacketError("out of order" if before else "old time")
        if newer * self._wire.number_step > feedback.time - last.time + self._wire.cycle + self._wire.clock_step:
            self._doubt(feedback, now, True)
            raise PacketError("number ahead of its time")
        # its clock agrees with ours: the fastest packet so far tells the difference between the two
        drift = _DRIFT * (now - self._heard)
        late = offset - self._offset - drift
        if late > _OLDEST:
            self._doubt(feedback, now, late > _ANOTHER)
            raise PacketError("late")
        if offset < self._floor - drift - _AHEAD - self._wire.clock_step:
            self._doubt(feedback, now, True)
            raise PacketError("ahead of its time")
        self._agree(feedback, now, offset, drift)

    def _agree(self, feedback: Feedback, now: float, offset: float, drift: float) -> None:
        """Take note of a packet in order and in time.

        Those that come out of a queue are faster one by one. Until `FIRST` packets came at their own rate, they tell
        the difference of the clocks; later, the floor under which they are ahead of their time goes with drift alone.
        """
        faster = self._offset - offset
        self._last, self._offset, self._heard = feedback, min(offset, self._offset + drift), now
        if self.agreed >= FIRST:
            self.agreed += 1
            self._floor = max(self._offset, self._floor - drift)
            return
        waited = faster > _QUEUED * self._wire.cycle + self._wire.clock_step
        self.agreed = 1 if waited else self.agreed + 1
        self._floor = self._offset

    def _doubt(self, feedback: Feedback, now: float, contradicts: bool) -> None:
        """Begin anew with a packet that contradicts those before it, unless these have agreed often enough."""
        if contradicts and self.agreed < FIRST:
            self._begin_with(feedback, now)

    def _begin_with(self, feedback: Feedback, now: float) -> None:
        self._last, self._heard, self.agreed = feedback, now, 1
        self._offset = self._floor = now - feedback.time
