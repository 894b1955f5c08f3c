"""A recording on coarse rows and in cells of a second, with what each of them tells of the torque."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.settings import settings
from ffgym.logs.quality.signals import stretches
from ffgym.recordings.stretch import Source

POSITION = "motor.position"
"""Family that says how joints move; other families follow it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CoarseMotion:
    """Motion of one recording on S coarse rows, on the side of its columns."""

    t: Array
    """Times of the rows [s], shape (S,)."""
    period: float
    """Usual time between them [s]."""
    q: Array
    """Positions, shape (S, N)."""
    dq: Array
    """Their rate."""
    ddq: Array
    """Its rate."""


def take_medians(source: Source) -> CoarseMotion:
    """Take medians of the positions of a recording, which single bad rows leave; without positions, it stands still."""
    t = source.t
    every = min(max(1, round(settings().blocks.coarse_period / float(np.median(np.diff(t))))), len(t) // 2)
    names = [f"{POSITION}.{joint}" for joint in source.header.joints]
    there = all(name in source.columns for name in names)
    at = _reduce(t, every)
    q = np.stack([_reduce(source[name] if there else np.zeros(len(t)), every) for name in names], axis=1)
    dq = np.gradient(q, at, axis=0)
    return CoarseMotion(t=at, period=float(np.median(np.diff(at))), q=q, dq=dq, ddq=np.gradient(dq, at, axis=0))


def _reduce(values: Array, every: int) -> Array:
    n = len(values) // every
    return np.asarray(np.median(values[: n * every].reshape(n, every), axis=1))


@dataclass(frozen=True, kw_only=True, eq=False)
class MotionRegressor:
    r"""Columns of which friction, inertia and gravity of any serial arm are roughly made, each of RMS 1 over a log.

    Of each joint, with its speed u and acceleration a over their tops, its place x in its range, and the smooth sign s
    of its speed:

    .. math:: s,\; u,\; u |u|,\; s e^{-(u / 0.1)^2},\; a,\; \cos \pi x,\; \sin \pi x,\; s \cos \pi x,\; s \sin \pi x

    and a constant. Speeds and accelerations beyond their tops count as those, so that no glitch counts for more.
    """

    speed: Array
    """Top speed of each joint, shape (N,); inf if it never moves."""
    acceleration: Array
    """Its top acceleration."""
    low: Array
    """Its lowest position."""
    reach: Array
    """Range of its positions."""
    scale: Array
    """RMS of the columns, shape (K,); inf for those that are 0."""

    @classmethod
    def of(cls, log: Sequence[CoarseMotion]) -> "MotionRegressor":
        """Scale it to all recordings of a log."""
        # sizes that hardly any row exceeds; inf where all are 0
        limits = settings().blocks
        rates = [np.concatenate([getattr(one, name) for one in log]) for name in ("dq", "ddq")]
        tops = [np.quantile(np.abs(values), limits.top_speed, axis=0) for values in rates]
        speed, acceleration = (np.where(top > 0, top, np.inf) for top in tops)
        low, high = np.quantile(
            np.concatenate([one.q for one in log]),
            [1 - limits.top_speed, limits.top_speed],
            axis=0,
        )
        reach = np.where(high > low, high - low, np.inf)
        rough = cls(speed=speed, acceleration=acceleration, low=low, reach=reach, scale=np.ones(1))
        energy = sum(np.sum(rough.rows(one) ** 2, axis=0) for one in log)
        rms = np.sqrt(energy / sum(len(one.t) for one in log))
        return replace(rough, scale=np.where(rms > 0, rms, np.inf))

    def rests(self, motion: CoarseMotion) -> BoolArray:
        """Rows in which no joint moves, shape (S,)."""
        return np.asarray((np.abs(motion.dq) <= settings().blocks.resting * self.speed).all(axis=1))

    def rows(self, motion: CoarseMotion) -> Array:
        """Rows of a recording, shape (S, K)."""
        limits = settings().blocks
        u, a = np.clip(motion.dq / self.speed, -1, 1), np.clip(motion.ddq / self.acceleration, -1, 1)
        x = np.clip((motion.q - self.low) / self.reach, 0, 1)
        sign = np.tanh(u / limits.resting)
        place = np.cos(np.pi * x), np.sin(np.pi * x)
        columns = (
            sign,
            u,
            u * np.abs(u),
            sign * np.exp(-((u / limits.low_speed) ** 2)),
            a,
            *place,
            *(sign * p for p in place),
        )
        return np.asarray(np.concatenate([np.ones((len(u), 1)), *columns], axis=1) / self.scale)


@dataclass(frozen=True, kw_only=True, eq=False)
class Cells:
    """C cells of one recording, one after the other."""

    edges: Array
    """Times at which they begin and end [s], shape (C + 1,)."""
    at_rest: BoolArray
    """True if the joints rest there, or the recording itself begins or ends, shape (C + 1,)."""
    information: Array
    """Products of the regressor's columns over each cell [s], shape (C, K, K)."""
    moving: Array
    """Share of each cell in which a joint moves, shape (C,)."""
    there: BoolArray
    """Cells that have their rows, shape (C,)."""

    def __len__(self) -> int:
        return len(self.moving)


def cut_cells(motion: CoarseMotion, regressor: MotionRegressor) -> Cells:
    """Cut a recording into cells, at rest where there is one within half a cell."""
    # times with pauses of the clock shortened
    limits = settings().blocks
    period, pauses = motion.period, np.cumsum(np.maximum(np.diff(motion.t) - limits.longest_pause, 0.0))
    t = motion.t - np.concatenate([[0.0], pauses])
    first, last = float(t[0] - period / 2), float(t[-1] + period / 2)
    count = max(1, int((last - first) / limits.cell))
    rests = regressor.rests(motion)
    # even edges, each moved to the longest rest within half a cell
    edges, at_rest = np.linspace(first, last, count + 1), np.ones(count + 1, dtype=np.bool_)
    for k in range(1, count):
        near = slice(*np.searchsorted(t, (edges[k] - limits.cell / 2, edges[k] + limits.cell / 2)).tolist())
        runs = stretches(rests[near], max(1, round(limits.rest / period)))
        at_rest[k] = bool(runs)
        if runs:
            longest = max(runs, key=lambda rows: rows.stop - rows.start)
            edges[k] = t[near][(longest.start + longest.stop) // 2]
    # information and motion of each cell
    rows, ends = regressor.rows(motion), np.searchsorted(t, edges)
    own = [slice(a, b) for a, b in zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True)]
    there = period * np.array([cell.stop - cell.start for cell in own]) >= limits.cell_rows * np.diff(edges)
    edges[-1] += period  # the last rows may be too few for a coarse one
    return Cells(
        edges=edges + np.interp(edges, t, motion.t - t),
        at_rest=at_rest,
        information=period * np.stack([rows[cell].T @ rows[cell] for cell in own]),
        moving=np.array([1.0 - rests[cell].mean() if cell.stop > cell.start else 0.0 for cell in own]),
        there=there,
    )
