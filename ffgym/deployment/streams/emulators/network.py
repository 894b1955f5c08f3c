"""A network that loses, delays, repeats, reorders and corrupts packets."""

import random
from collections import Counter
from dataclasses import dataclass
from typing import final

from ffgym.core.errors import check_number, check_whole

_SPACING = 1e-4
"""Time between a packet and its copy [s] (chosen)."""


@final
@dataclass(frozen=True, kw_only=True)
class Faults:
    """Faults of a network; the default is none."""

    drop: float = 0.0
    """Share of packets that are lost."""
    corrupt: float = 0.0
    """Share of packets with wrong bytes, too few or too many."""
    duplicate: float = 0.0
    """Share of packets that arrive twice."""
    late: float = 0.0
    """Share of packets that arrive later, up to `lateness`; those behind them overtake them."""
    lateness: float = 0.02
    """Largest delay of a late packet [s]."""
    latency: float = 0.0
    """Delay of every packet [s]."""
    jitter: float = 0.0
    """Further delay, evenly between 0 and this [s]."""
    seed: int = 0
    """Seed of all that is random."""

    def __post_init__(self) -> None:
        for name in ("drop", "corrupt", "duplicate", "late"):
            check_number(f"share of packets: {name}", getattr(self, name), low=0.0, high=1.0)
        for name in ("lateness", "latency", "jitter"):
            check_number(f"network {name}", getattr(self, name), unit="s", low=0.0)
        check_whole("seed", self.seed, low=0)


@final
class FaultyNetwork:
    """One direction of a network with faults."""

    def __init__(self, faults: Faults, stream: int = 0) -> None:
        """Begin with the random numbers of a `stream` of the seed, another for each direction."""
        self.faults = faults
        self._random = random.Random(f"{faults.seed}/{stream}")
        self.happened: Counter[str] = Counter()
        """Faults so far, by kind."""

    def carry(self, packet: bytes, now: float) -> list[tuple[float, bytes]]:
        """Send a packet at `now` [s]; returns when what arrives, in no order."""
        faults, draw = self.faults, self._random.random
        if draw() < faults.drop:
            self.happened["drop"] += 1
            return []
        arrival = now + faults.latency + faults.jitter * draw()
        if draw() < faults.late:
            self.happened["late"] += 1
            arrival += faults.lateness * draw()
        if draw() < faults.corrupt:
            self.happened["corrupt"] += 1
            packet = self._corrupt(packet)
        arrivals = [(arrival, packet)]
        if draw() < faults.duplicate:
            self.happened["duplicate"] += 1
            arrivals.append((arrival + _SPACING, packet))
        return arrivals

    def _corrupt(self, packet: bytes) -> bytes:
        """Change, cut off or add bytes."""
        rng = self._random
        kind = rng.randrange(4)
        if kind == 0:
            return packet[: rng.randrange(len(packet) + 1)]
        if kind == 1:
            return packet + rng.randbytes(rng.randint(1, 64))
        if kind == 2:
            return rng.randbytes(rng.randint(0, 2 * len(packet)))
        changed = bytearray(packet)
        for _ in range(rng.randint(1, 4)):
            if changed:
                changed[rng.randrange(len(changed))] = rng.randrange(256)
        return bytes(changed)
