"""Stretches of a recording: some of its rows, which keep their time on the clock of the session."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ffgym.core.types import Array
from ffgym.recordings.header import Header, clip_phases
from ffgym.recordings.io import Stored
from ffgym.recordings.recording import Recording
from ffgym.recordings.schema import VALID

STRETCH = "stretch"
"""Key of `meta` in the header: its recording, where it begins there, and how long that is [s]."""

SESSION_START = "session_start"
"""Key of `meta`: when a recording began on the clock of its session [s]."""

SETTLING = 0.25
"""Time [s] that does not count where a stretch was cut while joints moved; chosen: bristles, springs and low-passes,
which are taken to begin at rest, settle in it."""

_DIGITS = 6
"""Digits of times in the header [s], which differences of large time stamps would leave unround."""


Source = Recording | Stored
"""A recording in memory or in a file."""


@dataclass(frozen=True, kw_only=True)
class Span:
    """Interval of time of a recording."""

    start: float
    """First time stamp of the interval [s]."""
    end: float
    """Rows are before this time [s]."""
    at_rest: tuple[bool, bool] = (True, True)
    """True if joints rest at its start and at its end, or the recording itself starts or ends there."""


def is_stretch(recording: Recording) -> bool:
    """Tell if a recording is a stretch of another one."""
    return STRETCH in recording.header.meta


def read_session_start(header: Header) -> float:
    """Read the start of a recording on the clock of its session [s], as `ffgym record` writes it; 0 if unknown."""
    said = header.meta.get(SESSION_START, 0.0)
    return float(said) if isinstance(said, int | float) else 0.0


def stretches_of(source: Source, spans: Sequence[Span]) -> list[Recording]:
    """Cut out stretches of at least 2 rows, each named by its start; columns are read one by one."""
    t = source.t
    rows = [slice(*np.searchsorted(t, (span.start, span.end)).tolist()) for span in spans]
    parts: list[dict[str, Array]] = [{} for _ in spans]
    for name in source.columns:
        values = source[name]
        for part, own in zip(parts, rows, strict=True):
            part[name] = values[own].copy()  # a view would keep the whole column
    return [_stretch(source.header, t, part, span) for part, span in zip(parts, spans, strict=True)]


def _stretch(header: Header, t: Array, columns: dict[str, Array], span: Span) -> Recording:
    own = columns["timestamp"]
    first, period = float(own[0]), float(np.median(np.diff(own)))
    since = round(first - float(t[0]), _DIGITS)
    meta = header.meta | {
        SESSION_START: round(read_session_start(header) + since, _DIGITS),
        STRETCH: {"of": header.segment, "from_s": since, "of_s": round(float(t[-1] - t[0]), _DIGITS)},
    }
    # rows that do not count: joints moved where the stretch was cut
    unsettled = np.zeros(len(own), dtype=np.bool_)
    if not span.at_rest[0]:
        unsettled |= own < first + SETTLING
    if not span.at_rest[1]:
        unsettled |= own > float(own[-1]) - SETTLING
    if unsettled.any():
        for joint in header.joints:
            mask = columns.get(f"{VALID}.{joint}", np.ones(len(own)))
            columns[f"{VALID}.{joint}"] = np.where(unsettled, 0.0, mask)
    phases = clip_phases(header.phases, first, float(own[-1]) + period)
    whole = int(since + 1e-6)
    clock = f"{whole // 3600}:{whole // 60 % 60:02d}:{whole % 60:02d}"  # such as 0:57:20
    return Recording(columns, replace(header, segment=f"{header.segment} {clock}".strip(), phases=phases, meta=meta))
