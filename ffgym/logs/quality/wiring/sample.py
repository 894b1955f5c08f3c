"""Columns of all recordings of one robot as a wiring fit sees them: slow, without delay, on few common rows."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ffgym.core.measures import interpolate
from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.logs.preparation import LowPass
from ffgym.logs.quality.signals import estimate_noise_by_differences
from ffgym.recordings import FAMILIES, Recording

BANDS = (5.0, 2.5, 1.2)
"""Cut-offs [Hz] of the low-pass tried, the highest first: planned motion is below, resonances of arms above."""

_OF_RATE = 0.2
"""Largest cut-off in sample rates."""

_NOISY = 0.3
"""Noise of accelerations, in accelerations, from which on a lower cut-off is taken."""

_GRID = 0.05
"""Spacing of the filtered rows, which delays are looked up on, in periods of the cut-off."""

_PERIODS = 20.0
"""Periods of the cut-off that a recording has at least: clocks in other units make recordings of a hundredth second."""

_ROWS = 900
"""Rows of all recordings together: each hypothesis of another motion computes the arm at all of them."""

_BLOCK = 1.0
"""Time [s] in one block of rows; blocks are fitted and left out in turn."""

SIGN = -1
"""Stands for the sign of the rate, filtered as all columns are, among orders of derivatives."""

SLIDES = 0.02
"""Share of the largest speed of a joint from which on it slides; slower rows carry stiction of any size."""

_ENDS = 1.0
"""Periods of the cut-off at either end of a recording that are not used."""

FAMILIES_USED = (
    *("motor.position", "motor.velocity", "motor.effort"),
    *("reference.position", "reference.velocity", "reference.acceleration"),
    *("feedforward.effort", "feedback.effort", "compensation.effort", "command.effort"),
    *("link.position", "link.velocity", "tcp.position", "tcp_reference.position"),
)
"""Families that a wiring fit looks at."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Motion:
    """One recording, filtered, on a grid of its own."""

    t: Array
    """Shape (M,)."""
    at: IntArray
    """Rows that are used."""
    values: dict[str, Array]
    """Family -> columns, (M, P); NaN where a sensor saw nothing."""


class WiringSamples:
    """Filtered columns of R rows of all recordings, with their rates, at any delay."""

    def __init__(self, recordings: Sequence[Recording]) -> None:
        """Filter and thin the columns that all of them have."""
        shared = [f for f in FAMILIES_USED if all(_complete(recording, f) for recording in recordings)]
        self.joints = recordings[0].header.joints
        self.header = recordings[0].header
        self.families = tuple(shared)
        self.present = tuple(f for f in FAMILIES if all(_complete(recording, f) for recording in recordings))
        self.period = max(recording.dt for recording in recordings)
        self.shortest = min(recording.dt for recording in recordings)
        self.band = _band(recordings, shared)
        each = max(_ROWS // len(recordings), 60)
        self._motions = [_motion(recording, shared, self.band, each) for recording in recordings]
        self.recording = np.concatenate([np.full(len(m.at), i) for i, m in enumerate(self._motions)])
        blocks = [
            ((m.t[m.at] - m.t[0]) // (_BLOCK * max(1.0, 5.0 / self.band))).astype(np.int64) for m in self._motions
        ]
        self.held_out: BoolArray = np.concatenate([(block + i) % 2 == 0 for i, block in enumerate(blocks)])
        self._column = lru_cache(maxsize=4096)(self._compute)

    @property
    def n_rows(self) -> int:
        """Number of rows R."""
        return len(self.recording)

    def has(self, family: str) -> bool:
        """Tell whether all recordings have the family."""
        return family in self.families

    def column(self, family: str, part: int, order: int = 0, delay: float = 0.0) -> Array:
        """One column, its derivative of an `order`, or the `SIGN` of its rate, as it is `delay` [s] later, (R,)."""
        return self._column(family, part, order, round(delay, 9))

    def _compute(self, family: str, part: int, order: int, delay: float) -> Array:
        pieces = [motion.values[family][:, part] for motion in self._motions]
        for _ in range(1 if order == SIGN else order):
            pieces = [np.gradient(values, motion.t) for values, motion in zip(pieces, self._motions, strict=True)]
        if order == SIGN:
            largest = max(np.abs(rate).max() for rate in pieces) or 1.0
            signs = [np.tanh(rate / (SLIDES * largest))[:, None] for rate in pieces]
            steps = [float(motion.t[1] - motion.t[0]) for motion in self._motions]
            pieces = [LowPass(cutoff=self.band)(sign, dt)[:, 0] for sign, dt in zip(signs, steps, strict=True)]
        if delay == 0.0:
            return np.concatenate([values[motion.at] for values, motion in zip(pieces, self._motions, strict=True)])
        return np.concatenate(
            [np.interp(m.t[m.at] + delay, m.t, values) for values, m in zip(pieces, self._motions, strict=True)]
        )


def _complete(recording: Recording, family: str) -> bool:
    names = FAMILIES[family].columns(recording.header.joints)
    return all(name in recording.columns for name in names)


def _band(recordings: Sequence[Recording], families: Sequence[str]) -> float:
    """The highest cut-off at which noise of the angles leaves most accelerations alone."""
    fastest = _OF_RATE / max(recording.dt for recording in recordings)
    slowest = max(_PERIODS / float(recording.t[-1] - recording.t[0]) for recording in recordings)
    bands = [band for band in BANDS if slowest <= band <= fastest] or [min(fastest, max(slowest, BANDS[-1]))]
    if "motor.position" not in families:
        return bands[0]
    for band in bands:
        shares = []  # noise of the accelerations of a typical joint, over its accelerations
        for recording in recordings:
            angle, t = recording.joint_array("motor.position"), _even(recording)
            # of the density 2 dt noise^2 up to the cut-off, times (2 pi f)^4
            noise = (
                estimate_noise_by_differences(angle) * (2 * np.pi * band) ** 2 * np.sqrt(2 * recording.dt * band / 5)
            )
            slow = LowPass(cutoff=band)(interpolate(t, recording.t, angle), recording.dt)
            there = np.std(np.gradient(np.gradient(slow, t, axis=0), t, axis=0), axis=0)
            moved = np.ptp(slow, axis=0) > 0
            shares.append(float(np.median((noise / np.maximum(there, 1e-300))[moved])) if moved.any() else 0.0)
        if np.median(shares) < _NOISY:
            return band
    return bands[-1]


def _motion(recording: Recording, families: Sequence[str], band: float, rows: int) -> _Motion:
    even = _even(recording)
    dt = recording.dt
    grid = even if dt >= _GRID / band else np.arange(even[0], even[-1], _GRID / band)
    values = {}
    for family in families:
        stack = recording.joint_array if FAMILIES[family].parts == "joint" else recording.vector
        raw = stack(family)
        seen = np.isfinite(raw).all(axis=1)
        slow = LowPass(cutoff=band)(interpolate(even, recording.t[seen], raw[seen]), dt) if seen.sum() > 30 else None
        found = np.full((len(grid), raw.shape[1]), np.nan) if slow is None else interpolate(grid, even, slow)
        if slow is not None and not seen.all():
            # rows that are far from any sample
            times = recording.t[seen]
            after = np.clip(np.searchsorted(times, grid), 1, len(times) - 1)
            nearest = np.minimum(np.abs(times[after] - grid), np.abs(times[after - 1] - grid))
            found[nearest > 1 / (4 * band)] = np.nan
        values[family] = found
    ends = min(_ENDS / band, (grid[-1] - grid[0]) / 8)
    inner = np.flatnonzero((grid >= grid[0] + ends) & (grid <= grid[-1] - ends))
    at = inner[np.unique(np.linspace(0, len(inner) - 1, min(rows, len(inner))).astype(np.int64))]
    return _Motion(t=grid, at=at, values=values)


def _even(recording: Recording) -> Array:
    t = recording.t
    return np.asarray(t[0] + recording.dt * np.arange(int((t[-1] - t[0]) / recording.dt + 1e-6) + 1))
