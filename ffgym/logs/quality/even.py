"""An even clock: when rows were sampled, what lies between them, and rows at even times."""

from dataclasses import dataclass, replace

import numpy as np
import scipy

from ffgym.core.measures import rms
from ffgym.core.types import Array, BoolArray
from ffgym.logs.quality.log import CheckedLog
from ffgym.logs.quality.rows import long_intervals
from ffgym.logs.quality.signals import TINY, grid_step, has_two_rates, is_even, longest_interval
from ffgym.recordings import Header, Recording, clip_phases
from ffgym.recordings.schema import VALID, family_of

KEY = "conditioning"
"""Key of `meta` in the header: a list of sentences."""

NEAR = 8
"""Known rows on either side from which a bridge is built: a cubic spline forgets by 0.27 from row to row."""

LONG = 0.1
"""Time [s] from which on a bridge is monotone: a spline over a gap in which a joint turned round may go anywhere."""

BRIDGED = 0.005
"""Time [s] by which an interval may be longer than a period without being left out: a tenth of the low-pass that
residuals are seen through (40 Hz), in which a monotone cubic knows what lies between."""

PAUSE = 10.0
"""Interval [s] that is not bridged but ends a log: its longest part is kept."""

_FAR = 5.0
"""Sample periods of a sensor of its own over which its samples are joined, as the diagnosis does."""

_NO_WORSE = 1.02
"""Roughness of the motion, over that at the time stamps, up to which even times are taken: they leave values as they
are. Noise alone makes both alike."""

_BATCHES = 1.5
"""Mean interval over the median from which on rows come in batches, and the mean is the period."""


def is_smooth(name: str) -> bool:
    """Tell whether a column is of a quantity that cannot jump: positions, speeds, set-points; not torques."""
    family = family_of(name)
    return family is not None and family.name.endswith(("position", "velocity", "acceleration"))


def between(s: Array, values: Array, t: Array, *, smooth: bool) -> Array:
    """Values (S,), known at times `s` (S,), at times `t`.

    A cubic spline for what is smooth: on rows every 10 or 12 ms it errs by 0.02 % of the accelerations below 10 Hz,
    straight lines by 0.7 %. Torques jump with the sign of a speed: a monotone cubic errs by 0.4 % of them, straight
    lines by 0.6 %, and overshoots nowhere, as a spline does (a test has the figures). Beyond the ends values are held.
    """
    t = np.clip(t, s[0], s[-1])
    if len(s) < 4:
        return np.asarray(np.interp(t, s, values))
    monotone = scipy.interpolate.PchipInterpolator(s, values)(t)
    if not smooth:
        return np.asarray(monotone)
    after = np.clip(np.searchsorted(s, t), 1, len(s) - 1)
    return np.where(s[after] - s[after - 1] > LONG, monotone, scipy.interpolate.CubicSpline(s, values)(t))


def bridge_gaps(t: Array, values: Array, bad: BoolArray, *, smooth: bool) -> Array:
    """Values (T,) with those in rows `bad` (T,) replaced by what lies between the others; held beyond the last.

    Values on the grid of an encoder are replaced by such.
    """
    known, holes = np.flatnonzero(~bad), np.flatnonzero(bad)
    if len(known) < 2 or not len(holes):
        return values
    filled = values.copy()
    starts = holes[np.concatenate([[True], np.diff(holes) > 1])]
    for start in starts:
        place = int(np.searchsorted(known, start))
        around = known[max(0, place - NEAR) : place + NEAR]
        stop = int(known[place]) if place < len(known) else len(t)
        rows = np.arange(start, stop)
        filled[rows] = between(t[around], values[around], t[rows], smooth=smooth)
    if step := grid_step(values[~bad]):
        origin = values[~bad][0]
        filled[bad] = origin + step * np.round((filled[bad] - origin) / step)
    return filled


@dataclass(frozen=True, kw_only=True, eq=False)
class Times:
    """Times of S rows."""

    s: Array
    """[s], increasing, shape (S,)."""
    period: float
    """Period of the even clock that they are to be brought to [s]."""
    kept: bool
    """True if they are the time stamps."""
    stepped: bool = False
    """True if steps of the clock were taken out."""


def times_of(log: CheckedLog) -> Times:
    """When the rows of a log were sampled, as its positions say: of possible times, those at which they are smooth.

    A controller that stamps its rows right is believed, however unevenly it is read. Stamps of a clock that is coarse,
    or of the arrival of a message, scatter about even times, and make the motion rough that is smooth at those. Steps
    of the clock over which the joints move on as in one interval are taken out before.
    """
    rows, moved = long_intervals(log)
    t, stepped = log.t, not moved.all()
    if stepped:
        excess = np.zeros(len(t))
        excess[rows[~moved] + 1] = np.diff(t)[rows[~moved]] - log.dt
        t = np.asarray(t - np.cumsum(excess))
    # even times: the straight line through the stamps, over the numbers of the rows with those that are missing
    steps, longest = np.diff(t), longest_interval(t)
    usual = float(np.mean(steps[steps <= longest]))
    missing = np.where(steps > longest, np.maximum(np.round(steps / usual) - 1, 0), 0)
    numbers = np.concatenate([[0.0], np.cumsum(1 + missing)])
    slope, first = (float(x) for x in np.polyfit(numbers, t - t[0], 1))
    period = _round_times(slope)
    even = Times(s=t[0] + first + period * numbers, period=period, kept=False, stepped=stepped)
    if not log.excited.any():
        return even
    q = log.q[:, log.excited]
    rough = float(np.exp(np.mean(np.log(_roughness(even.s, q) / _roughness(t, q)))))
    if rough <= _NO_WORSE:
        return even
    median, mean = float(np.median(steps)), float(t[-1] - t[0]) / len(steps)
    return Times(s=t, period=_round_times(mean if mean > _BATCHES * median else median), kept=True, stepped=stepped)


def _round_times(period: float) -> float:
    """Period [s] without the digits that rounding of large times leaves."""
    return float(f"{period:.9g}")


def _roughness(s: Array, q: Array) -> Array:
    """Size of what positions (T, N) are off the cubic through two neighbours on either side, (N,)."""
    rows = [slice(k, len(s) - 4 + k) for k in range(5)]
    middle, around = s[rows[2]], [0, 1, 3, 4]
    guess = np.zeros((len(s) - 4, q.shape[1]))
    for i in around:
        weight = np.ones(len(s) - 4)
        for k in around:
            if k != i:
                weight *= (middle - s[rows[k]]) / (s[rows[i]] - s[rows[k]])
        guess += weight[:, None] * q[rows[i]]
    size: Array = rms(q[rows[2]] - guess, 0)
    return np.maximum(size, TINY)


def on_even_clock(recording: Recording, period: float | None = None) -> Recording:
    """The log at an even clock of a period [s], or its own; the log itself if its clock is even."""
    if is_even(recording.t) or has_two_rates(recording.t):  # of two clocks either may be right
        return recording
    recording = _longest_part(recording)
    if len(recording) < 8 or is_even(recording.t):
        return recording
    times = times_of(CheckedLog(recording))
    times = times if period is None else replace(times, period=period)
    n = int(np.floor((times.s[-1] - times.s[0]) / times.period * (1 + 1e-12) + 1e-6)) + 1
    t = times.s[0] + times.period * np.arange(n)
    # strictly within intervals that are longer than a period by more than what is bridged
    s, period = times.s, times.period
    after = np.clip(np.searchsorted(s, t - 1e-6 * period), 1, len(s) - 1)
    near = np.minimum(np.abs(t - s[after]), np.abs(t - s[after - 1])) < 1e-3 * period
    gaps = (s[after] - s[after - 1] - period > max(BRIDGED, 0.5 * period)) & ~near
    # a row counts if those on either side of it do
    after = np.clip(np.searchsorted(s, t - 1e-9), 0, len(s) - 1)
    before = np.where(s[after] - t > 1e-9, np.maximum(after - 1, 0), after)
    valid = recording.valid[after] & recording.valid[before] & ~gaps[:, None]
    columns, header = _at(recording, s, t)
    if recording.has(VALID) or gaps.any():
        columns |= mask_columns(header, valid)
    phases = clip_phases(header.phases, float(t[0]), float(t[-1]) + times.period)
    notes = _notes(recording, times, gaps)
    if header.hold != recording.header.hold:
        notes.append("Held torques act in the middle of their intervals; they are now samples at the rows (hold).")
    header = add_note(replace(header, phases=phases), *notes)
    return Recording({"timestamp": t, **columns}, header)


def _longest_part(recording: Recording) -> Recording:
    """Rows between pauses, of which there may be several."""
    t = recording.t
    breaks = np.flatnonzero(np.diff(t) > max(PAUSE, longest_interval(t))) + 1
    if not breaks.size:
        return recording
    borders = [0, *breaks.tolist(), len(t)]
    first = int(np.argmax(np.diff(borders)))
    start, stop = borders[first], borders[first + 1]
    note = (
        f"The clock pauses for more than {PAUSE:g} s {count(len(breaks), 'time')}: only the longest part, from "
        f"{t[start]:.4g} to {t[stop - 1]:.4g} s, is used. Give the other parts as logs of their own."
    )
    part = recording.slice(float(t[start]), float(t[stop]) if stop < len(t) else None)
    return part.derive(part.columns, add_note(part.header, note))


def _at(recording: Recording, s: Array, t: Array) -> tuple[dict[str, Array], Header]:
    """Columns, known at `s`, at `t`; and a header that says when their torque acts."""
    header, columns = recording.header, {}
    rows = np.round((s - t[0]) / (t[1] - t[0])).astype(np.intp)
    inside = bool(np.all((rows >= 0) & (rows < len(t))))
    if inside and np.all(np.abs(t[rows] - s) <= 1e-9 + 1e-6 * (t[1] - t[0])):  # every row lies at one of `t`
        holes = np.ones(len(t), dtype=np.bool_)
        holes[rows] = False
        for name, values in _resample(recording):
            columns[name] = np.full(len(t), np.nan)
            columns[name][rows] = values
            if np.isfinite(values).all():
                columns[name] = bridge_gaps(t, columns[name], holes, smooth=is_smooth(name))
        return columns, header
    middles = s + 0.5 * np.append(np.diff(s), s[-1] - s[-2])  # when held torques have acted for half their time
    header = replace(header, encoder_bits=None)  # what is between two readings is on no grid
    for name, values in _resample(recording):
        known = np.isfinite(values)
        if not known.all():
            columns[name] = _seldom(s[known], values[known], t, is_smooth(name))
            continue
        held = recording.header.hold == "zoh" and _is_torque(name)
        columns[name] = between(middles if held else s, values, t, smooth=is_smooth(name))
    if header.hold == "zoh" and any(map(_is_torque, columns)):
        header = replace(header, hold="sampled")
    return columns, header


def _resample(recording: Recording) -> list[tuple[str, Array]]:
    """Columns without clock and mask."""
    return [(n, x) for n, x in recording.columns.items() if n != "timestamp" and not n.startswith(f"{VALID}.")]


def _is_torque(name: str) -> bool:
    family = family_of(name)
    return family is not None and family.decided_by == "torque_semantics"


def _seldom(s: Array, values: Array, t: Array, smooth: bool) -> Array:
    """Samples of a sensor of its own, NaN where they are far apart."""
    if len(s) < 2:
        return np.full(len(t), np.nan)
    found = between(s, values, t, smooth=smooth)
    after = np.clip(np.searchsorted(s, t), 1, len(s) - 1)
    far = s[after] - s[after - 1] > _FAR * np.median(np.diff(s))
    return np.where(far | (t < s[0]) | (t > s[-1]), np.nan, found)


def _notes(recording: Recording, times: Times, gaps: BoolArray) -> list[str]:
    steps = 1e3 * np.diff(recording.t)
    span = f"{steps.min():.4g} to {steps.max():.4g} ms apart"
    every = f"every {1e3 * times.period:.6g} ms"
    if times.stepped:
        notes = [f"The clock steps while the joints move on as in one interval: the rows, {span}, are {every} now."]
    elif not times.kept:
        notes = [f"Time stamps are {span}, and the motion is as smooth at even times: rows were taken as {every}."]
    else:
        notes = [f"Rows {span} were brought to an even clock, {every}: a spline of motion, a monotone one of torque."]
    missing = len(gaps) - len(recording)
    if gaps.any():
        starts = np.flatnonzero(np.diff(gaps.astype(np.int8), prepend=0) > 0)
        notes.append(
            f"{count(len(starts), 'gap')} in the rows {'were' if len(starts) > 1 else 'was'} bridged and left out, "
            f"{gaps.sum() * times.period:.3g} s in all."
        )
    elif not times.kept and np.isclose(times.period, np.median(np.diff(times.s))) and missing > 0:
        notes.append(f"{count(missing, 'missing row')} in gaps of up to {1e3 * BRIDGED:g} ms were bridged.")
    return notes


def notes_of(recording: Recording) -> tuple[str, ...]:
    """Sentences on what conditioning did to a recording, empty if it did nothing."""
    notes = recording.header.meta.get(KEY, [])
    return tuple(map(str, notes)) if isinstance(notes, list) else (str(notes),)


def add_note(header: Header, *notes: str) -> Header:
    """The header with more notes."""
    before = header.meta.get(KEY, [])
    return replace(header, meta={**header.meta, KEY: [*(before if isinstance(before, list) else [before]), *notes]})


def mask_columns(header: Header, valid: BoolArray) -> dict[str, Array]:
    """Columns of the mask `valid` (T, N), by name."""
    return {f"{VALID}.{joint}": rows.astype(np.float64) for joint, rows in zip(header.joints, valid.T, strict=True)}


def count(number: int, one: str) -> str:
    """A number with its noun: 1 row, 2 rows."""
    return f"{number} {one}" if number == 1 else f"{number} {one}s"
