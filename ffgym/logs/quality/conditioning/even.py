"""An even clock: rows at uneven times brought to even ones, missing rows bridged and left out."""

from dataclasses import replace

import numpy as np

from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.logs.quality.conditioning.bridge import between, bridged, is_smooth
from ffgym.logs.quality.conditioning.notes import count, mask_columns, noted
from ffgym.logs.quality.conditioning.times import Times, in_gaps, times_of
from ffgym.logs.quality.log import Log
from ffgym.logs.quality.signals import has_two_rates, is_even, longest_interval
from ffgym.recordings import FAMILIES, Header, Recording, clipped
from ffgym.recordings.schema import VALID

BRIDGED = 0.005
"""Time [s] by which an interval may be longer than a period without being left out: a tenth of the low-pass that
residuals are seen through (40 Hz), in which a monotone cubic knows what lies between."""

PAUSE = 10.0
"""Interval [s] that is not bridged but ends a log: its longest part is kept."""

_FAR = 5.0
"""Sample periods of a sensor of its own over which its samples are joined, as the diagnosis does."""


def on_even_clock(recording: Recording, period: float | None = None) -> Recording:
    """The log at an even clock of a period [s], or its own; the log itself if its clock is even."""
    if is_even(recording.t) or has_two_rates(recording.t):  # of two clocks nobody knows which one is right
        return recording
    recording = _longest_part(recording)
    if len(recording) < 8 or is_even(recording.t):
        return recording
    times = times_of(Log(recording))
    times = times if period is None else replace(times, period=period)
    n = int(np.floor((times.s[-1] - times.s[0]) / times.period * (1 + 1e-12) + 1e-6)) + 1
    t = times.s[0] + times.period * np.arange(n)
    gaps = in_gaps(times.s, t, times.period, BRIDGED)
    columns, header = _at(recording, times.s, t)
    valid = _valid_at(recording.valid, times.s, t) & ~gaps[:, None]
    if recording.has(VALID) or gaps.any():
        columns |= mask_columns(header, valid)
    phases = clipped(header.phases, float(t[0]), float(t[-1]) + times.period)
    notes = _notes(recording, times, gaps)
    if header.hold != recording.header.hold:
        notes.append("Held torques act in the middle of their intervals; they are now samples at the rows (hold).")
    header = noted(replace(header, phases=phases), *notes)
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
    return Recording(part.columns, noted(part.header, note))


def _at(recording: Recording, s: Array, t: Array) -> tuple[dict[str, Array], Header]:
    """Columns, known at `s`, at `t`; and a header that says when their torque acts."""
    header, columns = recording.header, {}
    placed = _placed(s, t)
    if placed is None:
        header = replace(header, encoder_bits=None)  # what is between two readings is on no grid
    for name, values in recording.columns.items():
        if name == "timestamp" or name.startswith(f"{VALID}."):
            continue
        if placed is not None:
            columns[name] = _bridged_at(s, values, t, placed, smooth=is_smooth(name))
            continue
        known = np.isfinite(values)
        if not known.all():
            columns[name] = _seldom(s[known], values[known], t, is_smooth(name))
            continue
        held = header.hold == "zoh" and _is_torque(name)
        columns[name] = between(_middles(s) if held else s, values, t, smooth=is_smooth(name))
    if placed is None and header.hold == "zoh" and any(map(_is_torque, columns)):
        header = replace(header, hold="sampled")
    return columns, header


def _placed(s: Array, t: Array) -> IntArray | None:
    """Rows of `t` at which those of `s` lie, if all do."""
    rows = np.round((s - t[0]) / (t[1] - t[0])).astype(np.intp)
    inside = (rows >= 0) & (rows < len(t))
    if not inside.all() or np.any(np.abs(t[rows] - s) > 1e-9 + 1e-6 * (t[1] - t[0])):
        return None
    return rows


def _bridged_at(s: Array, values: Array, t: Array, rows: IntArray, *, smooth: bool) -> Array:
    """Values in their rows, and what lies between them in the others; NaN there, where some are missing."""
    found = np.full(len(t), np.nan)
    found[rows] = values
    holes = np.ones(len(t), dtype=np.bool_)
    holes[rows] = False
    return bridged(t, found, holes, smooth=smooth) if np.isfinite(values).all() else found


def _is_torque(name: str) -> bool:
    family = FAMILIES.get(name.rpartition(".")[0])
    return family is not None and family.decided_by == "torque_semantics"


def _middles(s: Array) -> Array:
    """When held torques have acted for half their time."""
    return s + 0.5 * np.append(np.diff(s), s[-1] - s[-2])


def _seldom(s: Array, values: Array, t: Array, smooth: bool) -> Array:
    """Samples of a sensor of its own, NaN where they are far apart."""
    if len(s) < 2:
        return np.full(len(t), np.nan)
    found = between(s, values, t, smooth=smooth)
    after = np.clip(np.searchsorted(s, t), 1, len(s) - 1)
    far = s[after] - s[after - 1] > _FAR * np.median(np.diff(s))
    return np.where(far | (t < s[0]) | (t > s[-1]), np.nan, found)


def _valid_at(valid: BoolArray, s: Array, t: Array) -> BoolArray:
    """The mask at `t`: a row counts if those on either side of it do."""
    after = np.clip(np.searchsorted(s, t - 1e-9), 0, len(s) - 1)
    before = np.where(s[after] - t > 1e-9, np.maximum(after - 1, 0), after)
    return np.asarray(valid[after] & valid[before])


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
