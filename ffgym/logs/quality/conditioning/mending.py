"""The steps of conditioning, in an order in which none sees what an earlier one repairs."""

from collections.abc import Callable
from weakref import WeakSet

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.logs.quality.conditioning.bursts import without_bursts
from ffgym.logs.quality.conditioning.copies import without_copies
from ffgym.logs.quality.conditioning.ends import trimmed
from ffgym.logs.quality.conditioning.even import on_even_clock
from ffgym.logs.quality.conditioning.spikes import without_spikes
from ffgym.logs.quality.conditioning.stops import without_stops
from ffgym.logs.quality.conditioning.stretches import without_stuck
from ffgym.recordings import Recording

_BEFORE: tuple[Callable[[Recording], Recording], ...] = (without_copies, without_spikes)
"""Steps on the rows as they came. Each step returns the recording itself where there is nothing to do."""

_AFTER: tuple[Callable[[Recording], Recording], ...] = (without_stops, without_stuck, without_bursts, trimmed)
"""Steps on rows of an even clock."""

_PASSES = 8
"""Passes after which steps that find more each time are given up; two are usual: one that works, one that finds
nothing left."""

SHORTEST = 30
"""Rows from which on a log is conditioned: fewer do not tell what is usual in it."""


_IN_ORDER: "WeakSet[Recording]" = WeakSet()
"""Logs that need nothing; a recording does not change."""


def conditioned(recording: Recording, *, period: float | None = None) -> Recording:
    """The log at an even clock, without copies and single bad rows, and with a mask over what does not count.

    Repeated rows are dropped; rows of an uneven clock are brought to an even one; missing rows are bridged; values that
    stick out or are stuck are interpolated. What was bridged or interpolated, bursts of noise, and the robot's own
    stops are left out by the mask `valid.<joint>`. `meta["conditioning"]` of the header has a sentence for each.

    A log that needs nothing is returned as it is, and so is one that was conditioned.

    Args:
        recording: the log.
        period: of the even clock that an uneven one is brought to [s]; None is the median of its intervals.
    """
    if not isinstance(recording, Recording):
        raise FFGymError(f"recording must be a Recording, got {type(recording).__name__}; read_recording makes one.")
    if len(recording) < SHORTEST or recording in _IN_ORDER:
        return recording
    with np.errstate(over="ignore", invalid="ignore"):  # a bit that flipped in an exponent is repaired here
        for _ in range(_PASSES):
            before = recording
            for step in _BEFORE:
                recording = step(recording)
            recording = on_even_clock(recording, period)
            for step in _AFTER:
                recording = step(recording)
            if recording is before:
                _IN_ORDER.add(recording)
                break
    return recording
