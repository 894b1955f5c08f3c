"""Rows of a residual as patterns are sought in them: all motions of one channel, cut into halves and blocks."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy

from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.diagnosis.residual import Channel, MotionResidual, Residual, components
from ffgym.diagnosis.settings import settings

TO_HALF = np.sqrt(np.log(2.0)) / (2 * np.pi)
"""Standard deviation of a Gaussian low-pass times its cut-off, where it keeps half of the power."""

_STATES = {
    "angle": "motor_angle",
    "speed": "motor_speed",
    "sign": "friction_sign",
    "load": "load_at_motor",
    "torque": "motor_torque",
    "temperature": "temperature",
}
_OF_MOTION = {"acceleration": "motor_acceleration", "travel": "since_reversal", "rest": "at_rest_for"}
"""Field of a motion's residual for each variable of did."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PatternRows:
    """Residuals of one channel in R rows of M motions, each component less its mean over each motion."""

    channel: Channel
    components: tuple[str, ...]
    joints: tuple[str, ...]
    dt: float
    """Time between rows [s]."""
    highest: float
    """Frequency up to which rows show a vibration [Hz]."""
    values: Array
    """Residuals (R, C); 0 where a component is not judged."""
    judged: BoolArray
    """Rows in which the model claims to know a component, shape (R, C)."""
    floor: Array
    """RMS of noise alone in each motion, shape (M, C)."""
    t: Array
    """Time since the motion began [s], shape (R,)."""
    did: Mapping[str, Array]
    """States and past of the motors by name, (R, N) each, motor side: `angle` [rad], `speed`, its size and its smoothed
    `sign`, `acceleration`, `load`, `torque`, `power`, `temperature` [degC], `travel` since the last reversal and `way`
    there and back since the motion began [rad], and `rest` before the present move [s]."""
    motion_starts: IntArray
    """First row of each motion, shape (M,)."""
    block_starts: IntArray
    """First row of each block, shape (B,)."""
    half: IntArray
    """0 or 1 for each row, shape (R,): what is fitted on one half is judged on the other."""

    @cached_property
    def motion(self) -> IntArray:
        """Number of each row's motion, shape (R,)."""
        counts = np.diff([*self.motion_starts, len(self.values)])
        return np.repeat(np.arange(len(counts)), counts)

    @cached_property
    def noise(self) -> Array:
        """Energy of noise alone in each motion, shape (M, C); that of a log without noise is tiny, not zero."""
        counts = np.add.reduceat(self.judged.astype(np.float64), self.motion_starts, axis=0)
        return np.maximum(counts * np.square(self.floor), np.finfo(np.float64).tiny)

    def loud(self, values: Array) -> list[int]:
        """Find components of which values (R, C) have more energy than noise in a motion."""
        energy = np.add.reduceat(values**2, self.motion_starts, axis=0)
        return np.flatnonzero(np.any(energy > settings().significance.quiet * self.noise, axis=0)).tolist()

    def centre(self, columns: Array) -> Array:
        """Subtract the mean over each motion from columns (R, P): differences between motions show no dependence."""
        if not columns.size:
            return columns
        means = np.add.reduceat(columns, self.motion_starts, axis=0) / np.bincount(self.motion)[:, None]
        centred: Array = columns - means[self.motion]
        return centred

    def redraw(self, rng: np.random.Generator) -> "PatternRows":
        """Draw other halves of the same rows."""
        limits = settings().patterns
        return replace(
            self, half=_draw_halves(self.motion, np.rint(self.t / self.dt) // (limits.chunk * limits.block), rng)
        )

    def by_block(self, columns: Array) -> Array:
        """Sum columns over each block, shape (B, P)."""
        sums: Array = np.add.reduceat(columns, self.block_starts, axis=0)
        return sums

    @cached_property
    def block_half(self) -> IntArray:
        """Half of each block, shape (B,)."""
        return self.half[self.block_starts]


def collect_pattern_rows(residual: Residual, channel: Channel, rng: np.random.Generator) -> PatternRows | None:
    """Collect rows of a channel that count, with halves drawn by `rng`; None without such rows."""
    limits = settings().patterns
    pairs, there = [], []
    for i, of in enumerate(residual.motions):
        # every component of the channel is known, and some are judged
        known = of.valid & np.isfinite(of.measured[channel] - of.predicted[channel]).all(axis=1)
        known &= np.isfinite(of.residual[channel]).any(axis=1)
        if known.any():
            pairs.append((of, known))
            there.append(i)
    if not pairs:
        return None
    # all motions one after the other
    t = np.concatenate([m.t[k] for m, k in pairs])
    counts = [int(k.sum()) for _, k in pairs]
    motion = np.repeat(np.arange(len(pairs)), counts)
    dt = float(np.median(np.concatenate([np.diff(m.t) for m, _ in pairs])))
    number = np.rint(t / dt)
    return PatternRows(
        channel=channel,
        components=components(channel, residual.robot),
        joints=tuple(residual.robot.joints),
        dt=dt,
        highest=limits.passed * residual.cutoff,
        values=np.concatenate([_centre(m.residual[channel][k]) for m, k in pairs]),
        judged=np.concatenate([np.isfinite(m.residual[channel][k]) for m, k in pairs]),
        floor=residual.floor[channel][there],
        t=t,
        did=_collect_states(pairs),
        motion_starts=np.cumsum([0, *counts[:-1]]),
        block_starts=_find_starts(motion, number // limits.block),
        half=_draw_halves(motion, number // (limits.chunk * limits.block), rng),
    )


def remove_slow(rows: PatternRows, values: Array) -> Array:
    """Remove from values (R, C) what changes slowly in each motion, and the mean of each motion."""
    width = TO_HALF / (settings().patterns.slow * rows.highest * rows.dt)
    smooth = np.empty_like(values)
    for motion in range(len(rows.motion_starts)):
        own = rows.motion == motion
        smooth[own] = scipy.ndimage.gaussian_filter1d(values[own], width, axis=0, mode="nearest")
    return rows.centre(values - smooth)


def _centre(values: Array) -> Array:
    """Subtract their mean from rows (R, C); 0 where they are not judged."""
    judged = np.isfinite(values)
    known = np.where(judged, values, 0.0)
    mean = known.sum(axis=0) / np.maximum(judged.sum(axis=0), 1)
    return np.where(judged, known - mean, 0.0)


def _collect_states(pairs: list[tuple[MotionResidual, BoolArray]]) -> dict[str, Array]:
    """Collect states of the motors in the rows that count."""
    parts = []
    for motion, rows in pairs:
        shape = motion.motor_acceleration.shape
        did = {name: np.broadcast_to(getattr(motion.state, of), shape) for name, of in _STATES.items()}
        did |= {name: getattr(motion, of) for name, of in _OF_MOTION.items()}
        did["way"] = np.cumsum(np.abs(np.diff(did["angle"], axis=0, prepend=did["angle"][:1])), axis=0)
        did |= {"size of speed": np.abs(did["speed"]), "power": did["speed"] * did["torque"]}
        parts.append({name: values[rows] for name, values in did.items()})
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _find_starts(motion: IntArray, number: Array) -> IntArray:
    """Find rows at which another motion or another number begins."""
    changes = (np.diff(motion) != 0) | (np.diff(number) != 0)
    return np.concatenate([[0], 1 + np.flatnonzero(changes)])


def _draw_halves(motion: IntArray, chunk: Array, rng: np.random.Generator) -> IntArray:
    """Draw one half of the chunks of each motion, so that no rhythm of the motion falls in step with the halves."""
    starts = _find_starts(motion, chunk)
    counts = np.diff([*starts, len(motion)])
    of_chunk = np.concatenate([rng.permutation(np.arange(n) % 2) for n in np.bincount(motion[starts])])
    return np.repeat(of_chunk, counts)
