"""Long logs thinned to the stretches that a diagnosis uses.

A log that a diagnosis can afford is left as it is. Of a longer one stretches are cut, each of which is then a recording
of its own, with its place on the clock of the session: it is conditioned and judged alone, so that what is wrong in one
of them leaves the others. The choice looks at positions alone, on coarse rows, and does not depend on the order in
which recordings are given.
"""

import hashlib
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ffgym.diagnosis.one_thread import on_one_thread
from ffgym.diagnosis.thinning.bound import affordable
from ffgym.diagnosis.thinning.cells import cells_of
from ffgym.diagnosis.thinning.choose import choose
from ffgym.diagnosis.thinning.coarse import Coarse, MotionRegressor, coarse
from ffgym.recordings import Recording
from ffgym.recordings.stored import Stored
from ffgym.recordings.stretch import Span, started, stretches_of

NOTE = "thinned"
"""Key of `meta` in the header of a stretch: a sentence on how the whole log was thinned."""


def thin(recordings: Sequence[Recording]) -> list[Recording]:
    """Thin a log that is too long for a diagnosis; a shorter one is returned as it is.

    Args:
        recordings: with different names; else nothing is done, as the diagnosis refuses them.
    """
    return within_bound(recordings)


def note_of(recordings: Sequence[Recording]) -> tuple[str, ...]:
    """Tell how a log was thinned that these are stretches of; empty if it was not."""
    return tuple(dict.fromkeys(str(one.header.meta[NOTE]) for one in recordings if NOTE in one.header.meta))


@on_one_thread
def within_bound(sources: Sequence[Recording | Stored]) -> list[Recording]:
    """Recordings in memory or in files, or if they are too long together, stretches of them.

    Args:
        sources: of one machine, with different names.

    Raises:
        FFGymError: if one cannot be read.
    """
    lasting = [float(source.t[-1] - source.t[0]) for source in sources]
    names = [source.header.segment for source in sources]
    if len(set(names)) < len(names) or not _is_long(sources, lasting):
        return [source.whole() if isinstance(source, Stored) else source for source in sources]
    motions = [coarse(source) for source in sources]
    order = sorted(range(len(sources)), key=lambda i: (started(sources[i].header), names[i], _digest(motions[i])))
    regressor = MotionRegressor.of([motions[i] for i in order])
    cells = [cells_of(motions[i], regressor) for i in order]
    spans: list[list[Span]] = [[] for _ in sources]
    for one in choose(cells, _affordable(sources)):
        own = cells[one.recording]
        ends = slice(one.first, one.stop + 1, one.stop - one.first)
        (start, end), (first, last) = own.edges[ends].tolist(), own.at_rest[ends].tolist()
        spans[order[one.recording]].append(Span(start=start, end=end, at_rest=(first, last)))
    found = [part for source, own in zip(sources, spans, strict=True) if own for part in stretches_of(source, own)]
    return _with_note(found, lasting)


def _affordable(sources: Sequence[Recording | Stored]) -> float:
    """Time that all may last together [s]: that of the fastest sample rate and the most joints."""
    period = min(float(np.median(np.diff(source.t))) for source in sources)
    return affordable(period, max(len(source.header.joints) for source in sources))


def _is_long(sources: Sequence[Recording | Stored], lasting: Sequence[float]) -> bool:
    return bool(sources) and sum(lasting) > _affordable(sources)


def _digest(motion: Coarse) -> bytes:
    digest = hashlib.sha256(np.ascontiguousarray(motion.t).tobytes())
    digest.update(np.ascontiguousarray(motion.q).tobytes())
    return digest.digest()


def _with_note(found: Sequence[Recording], lasting: Sequence[float]) -> list[Recording]:
    """Stretches with a sentence on how the log was thinned."""
    used, total = sum(float(one.t[-1] - one.t[0]) for one in found), sum(lasting)
    whole = "1 recording" if len(lasting) == 1 else f"{len(lasting)} recordings"
    text = (
        f"The log was thinned: {used:.0f} of {total:.0f} s are used, {len(found)} stretches of {whole} that are spread "
        "over all of it and tell most of the joints; more would take memory and time, and tell hardly more."
    )
    return [Recording(one.columns, replace(one.header, meta=one.header.meta | {NOTE: text})) for one in found]
