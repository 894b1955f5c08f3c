"""Conditioning: what a log needs before filters and checks, each step told in its header, nothing else changed."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from weakref import WeakSet

import numpy as np

from ffgym.core.errors import check_class
from ffgym.core.types import Array, BoolArray
from ffgym.logs.quality.cells import (
    BURST,
    BURST_REFUSED,
    COMPUTED,
    REACH,
    SPIKE,
    burst_ratios,
    columns_of,
    outlier_ratio,
)
from ffgym.logs.quality.even import add_note, bridge_gaps, count, is_smooth, mask_columns, on_even_clock
from ffgym.logs.quality.log import RESTING, CheckedLog, NotJudgedError
from ffgym.logs.quality.rows import copies
from ffgym.logs.quality.signals import stretches
from ffgym.logs.quality.values import stuck_stretches
from ffgym.recordings import FAMILIES, Recording

_SHARE, _FEW = 0.005, 3
"""Share of the rows of a column, or number if that is more, up to which rows that stick out are single ones; a column
that does so more often is noisy, or of another machine."""

_JUDGED = ("motor.position", "motor.effort", "link.position")
"""Families that residuals are made of: their bad rows do not count for the joint. Others are repaired only."""

_WINDOW = 0.02
"""Time [s] over which a change of speed counts; two rows of 100 Hz, long beside quantisation, and as long as brakes
take."""

_BRAKING = 0.2
"""Time [s] before a rest in which a stop brakes: drives stop within that from full speed."""

_REST = 0.25
"""Time [s] for which all joints rest after a stop, at least."""

_HARDER = 1.5
"""Factor by which a stop brakes harder than anything else in the log."""

_SLOW = 0.05
"""Largest sample period [s] at which braking is seen."""

_SETTLING = 0.25
"""Time [s] of what does not count that stays at either end: the low-passes of diagnosis and identification settle."""

_PASSES = 8
"""Passes after which steps that find more each time are given up; two are usual: one that works, one that finds
nothing left."""

_SHORTEST = 30
"""Rows from which on a log is conditioned: fewer do not tell what is usual in it."""


@dataclass(frozen=True)
class _Repair:
    """Change that a step of conditioning makes to a recording."""

    recording: Recording
    columns: dict[str, Array] = field(default_factory=dict)
    """Columns that are replaced."""
    texts: list[str] = field(default_factory=list)
    """Findings with their places."""

    @cached_property
    def masked(self) -> BoolArray:
        """Rows that do not count for each joint any more, shape (T, N)."""
        return np.zeros(self.recording.valid.shape, dtype=np.bool_)

    def bridge(self, name: str, bad: BoolArray) -> None:
        """Replace rows `bad` (T,) of a column by what lies between the others."""
        values = self.columns.get(name, self.recording[name])
        self.columns[name] = bridge_gaps(self.recording.t, values, bad, smooth=is_smooth(name))

    def made(self, *notes: str) -> Recording:
        """The recording with the changes and notes, or as it is if nothing was found."""
        if not self.texts:
            return self.recording
        found, recording = {**self.recording.columns, **self.columns}, self.recording
        if self.masked.any():
            found |= mask_columns(recording.header, recording.valid & ~self.masked)
        return recording.derive(found, add_note(recording.header, *notes))


def without_copies(recording: Recording) -> Recording:
    """The log without rows that repeat the one before in motion; their times stay free, as of missing rows.

    A logger writes such rows that polls faster than the controller computes.
    """
    try:
        found = copies(CheckedLog(recording))
    except NotJudgedError:
        return recording
    if not found:
        return recording
    kept = np.ones(len(recording), dtype=np.bool_)
    for rows in found:
        kept[rows] = False
    note = (
        f"{count(int((~kept).sum()), 'row')} of {len(kept)} that repeat the row before in motion were dropped, the "
        f"first at {recording.t[found[0].start]:.4g} s."
    )
    columns = {name: values[kept] for name, values in recording.columns.items()}
    return Recording(columns, add_note(recording.header, note))


def without_spikes(recording: Recording) -> Recording:
    """The log with single rows replaced that stick out of their neighbours as no sample of a machine does.

    What a controller computed is left as it is: commands may jump.
    """
    repair = _Repair(recording)
    odd = np.zeros_like(repair.masked)
    for column in columns_of(CheckedLog(recording)):
        found = np.flatnonzero(outlier_ratio(column.values, column.resolution) > SPIKE)
        # rows that stick out alone, if they are few
        apart = np.diff(found, prepend=-np.inf, append=np.inf) > REACH
        rows = column.rows[found[apart[:-1] & apart[1:]]]
        too_many = found.size > max(_FEW, _SHARE * len(column.values))
        if column.family in COMPUTED or too_many or not rows.size:
            continue
        bad = np.zeros(len(recording), dtype=np.bool_)
        bad[rows] = True
        if FAMILIES[column.family].may_miss:
            repair.columns[column.name] = np.where(bad, np.nan, recording[column.name])
        else:
            repair.bridge(column.name, bad)
        if FAMILIES[column.family].parts == "joint":
            joint = recording.header.joints.index(column.name.rpartition(".")[2])
            odd[bad, joint] = True
            repair.masked[bad, joint] |= column.family in _JUDGED
        repair.texts.append(f"{column.name} ({count(len(rows), 'row')}, the first at {recording.t[rows[0]]:.5g} s)")
    repair.masked[odd.sum(axis=1) > 1] = True  # what shakes several joints at once, as the robot's own stop, shakes all
    note = "Single rows that stick out were replaced, those of positions, torques and several joints left out: "
    return repair.made(f"{note}{', '.join(repair.texts)}.")


def without_stops(recording: Recording) -> Recording:
    """The log with a mask over abrupt stops of all joints, as of brakes, and over the rest that follows them.

    No model of the motion has the robot's own stops.
    """
    log, repair = CheckedLog(recording), _Repair(recording)
    if not log.excited.any() or log.dt > _SLOW:
        return recording
    for rows in _abrupt_stops(log):
        if recording.valid[rows].any():
            repair.masked[rows] = True
            repair.texts.append(
                f"All joints stop abruptly at {recording.t[rows.start]:.4g} s: the stop, and the rest to "
                f"{recording.t[rows.stop - 1]:.4g} s, were left out."
            )
    return repair.made(*repair.texts)


def _abrupt_stops(log: CheckedLog) -> list[slice]:
    """Rows from where an abrupt stop begins to brake to the end of the rest after it."""
    # change of the mean speed from `width` rows before to as many after each row
    q, width = log.q[:, log.excited], log.rows(_WINDOW)
    braking = np.zeros_like(q)
    if len(q) > 2 * width:
        braking[width:-width] = np.abs(q[2 * width :] - 2 * q[width:-width] + q[: -2 * width])
    speed = np.abs(log.dq[:, log.excited])
    resting = np.all(speed <= RESTING * speed.max(axis=0), axis=1)
    ahead = log.rows(_BRAKING)
    rests = [rows for rows in stretches(resting, log.rows(_REST)) if rows.start > ahead]
    elsewhere = ~resting
    for rows in rests:
        elsewhere[max(0, rows.start - 2 * ahead) : rows.start + ahead] = False
    if not rests or elsewhere.sum() < log.rows(1.0):
        return []
    most = braking[elsewhere].max(axis=0)
    found = []
    for rows in rests:
        hard = np.any(braking[rows.start - ahead : rows.start + ahead] > _HARDER * most, axis=1)
        if hard.any():
            begin = rows.start - ahead + int(np.argmax(hard)) - width
            found.append(slice(max(0, begin), rows.stop))
    return found


def without_stuck(recording: Recording) -> Recording:
    """The log with stuck columns bridged; where a position is not known, no torque counts, as it depends on all."""
    repair = _Repair(recording)
    for stretch in stuck_stretches(CheckedLog(recording)):
        bad = np.zeros(len(recording), dtype=np.bool_)
        bad[stretch.rows] = True
        repair.bridge(stretch.name, bad)
        repair.masked[bad, slice(None) if "position" in stretch.name else stretch.joint] = True
        first, last = recording.t[stretch.rows.start], recording.t[stretch.rows.stop - 1]
        repair.texts.append(f"{stretch.name} ({first:.5g} to {last:.5g} s)")
    return repair.made(f"Stuck columns were bridged and left out: {', '.join(repair.texts)}.")


def without_bursts(recording: Recording) -> Recording:
    """The log with a mask over stretches of a column that are far noisier than the rest of it."""
    repair = _Repair(recording)
    for column in columns_of(CheckedLog(recording)):
        if FAMILIES[column.family].parts != "joint" or FAMILIES[column.family].may_miss:
            continue
        j = recording.header.joints.index(column.name.rpartition(".")[2])
        loud = np.flatnonzero(burst_ratios(column, recording.valid[:, j]) > BURST_REFUSED)
        for window in loud.tolist():
            repair.masked[max(0, (window - 1) * BURST) : (window + 2) * BURST, j] = True
        if loud.size:
            repair.texts.append(f"{column.name} (around {recording.t[loud[0] * BURST]:.5g} s)")
    return repair.made(f"Bursts of noise were left out: {', '.join(repair.texts)}.")


def trim(recording: Recording) -> Recording:
    """The log without long ends that count for no joint, but for a moment that filters have to settle in."""
    counting = np.flatnonzero(recording.valid.any(axis=1))
    if not counting.size:
        return recording
    t, dt = recording.t, recording.dt
    first, last = float(t[counting[0]]) - _SETTLING, float(t[counting[-1]]) + _SETTLING
    kept = (t >= first - 0.5 * dt) & (t <= last + 0.5 * dt)
    if kept.all():
        return recording
    rows = np.flatnonzero(kept)
    part = recording.slice(float(t[rows[0]]), None if kept[-1] else float(t[rows[-1] + 1]))
    before, after = float(t[rows[0]] - t[0]), float(t[-1] - t[rows[-1]])
    texts = [f"{x:.3g} s at the {end}" for x, end in ((before, "beginning"), (after, "end")) if x > 0]
    note = f"Rows that count for no joint were dropped: {', '.join(texts)}."
    return part.derive(part.columns, add_note(part.header, note))


_BEFORE: tuple[Callable[[Recording], Recording], ...] = (without_copies, without_spikes)
"""Steps on the rows as they came, in an order in which none sees what an earlier one repairs. Each step returns the
recording itself where there is nothing to do."""

_AFTER: tuple[Callable[[Recording], Recording], ...] = (without_stops, without_stuck, without_bursts, trim)
"""Steps on rows of an even clock."""

_IN_ORDER: "WeakSet[Recording]" = WeakSet()
"""Logs that need nothing; a recording does not change."""


def condition(recording: Recording, *, period: float | None = None) -> Recording:
    """The log at an even clock, without copies and single bad rows, and with a mask over what does not count.

    Repeated rows are dropped; rows of an uneven clock are brought to an even one; missing rows are bridged; values that
    stick out or are stuck are interpolated. What was bridged or interpolated, bursts of noise, and the robot's own
    stops are left out by the mask `valid.<joint>`. `meta["conditioning"]` of the header has a sentence for each.

    A log that needs nothing is returned as it is, and so is one that was conditioned.

    Args:
        recording: the log.
        period: of the even clock that an uneven one is brought to [s]; None is the median of its intervals.
    """
    check_class("recording", recording, Recording, "read_recording makes one")
    if len(recording) < _SHORTEST or recording in _IN_ORDER:
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
