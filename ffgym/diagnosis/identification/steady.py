"""Times of constant speed, where friction is that of steady sliding, and records that reverse between slides."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.diagnosis.identification.friction_data import FrictionTorque
from ffgym.diagnosis.identification.resampling import Blocks, runs

WINDOW = 0.1
"""Time over which speeds are averaged to compare them [s]: an encoder of 16 bit then resolves 1e-3 rad/s."""

_DRIFT = 0.05
"""Largest change of a constant speed, relative to it [1/s]. A sine is slower than that for a few percent of its period
only, less than the shortest run."""

_SLOWEST_DRIFT = 0.02
"""Change of speed that counts as none however slow the motion is [rad/s^2]: what an encoder of 16 bit shows in windows
of 0.1 s, doubled."""

_SLOWEST = 4e-3
"""Motor speed below which a joint counts as at rest [rad/s]: four times what 16 bit resolve in a window."""

SETTLING_TRAVEL = 6.0
"""Way that bristles take to settle, in presliding lengths f_s / sigma_0: exp(-6) is 0.2 %."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SteadyFriction:
    """Friction of one joint in windows of constant speed, R windows from any number of recordings."""

    speed: Array
    """Mean motor speed [rad/s], signed, shape (R,)."""
    friction: Array
    """Mean friction torque, motor side [N m], shape (R,); offsets and errors of gravity are in it."""
    position: Array
    """Mean joint position, link side [rad or m], shape (R,)."""
    run: IntArray
    """Run at one speed that the window is part of, shape (R,)."""

    @property
    def n_rows(self) -> int:
        """Number of windows R."""
        return len(self.speed)

    @property
    def n_runs(self) -> int:
        """Number of runs."""
        return int(self.run[-1]) + 1 if len(self.run) else 0

    @property
    def blocks(self) -> Blocks:
        """Each window is a block, drawn within its run."""
        return Blocks(of_row=np.arange(self.n_rows), stratum=self.run)

    def levels(self) -> tuple[Array, Array, Array]:
        """Mean speed [rad/s], friction [N m] and position of each run, shape (n_runs,) each."""
        count = np.bincount(self.run)
        speed, friction, position = (
            np.bincount(self.run, values) / count for values in (self.speed, self.friction, self.position)
        )
        return speed, friction, position


def steady_friction(torques: Sequence[FrictionTorque], joint: int, presliding: float) -> SteadyFriction:
    """Windows in which one joint moves at constant speed, with acceleration and bristles settled.

    Bristles bend by `presliding`, f_s / sigma_0 [rad], motor side.
    """
    tables: list[Array] = []
    for torque in torques:
        means = _means(torque, joint)
        for rows in _settled(means[:, 0], SETTLING_TRAVEL * presliding):
            tables.append(np.column_stack([means[rows], np.full(len(rows), len(tables))]))
    table = np.concatenate(tables) if tables else np.zeros((0, 4))
    speed, friction, position, run = table.T
    return SteadyFriction(speed=speed, friction=friction, position=position, run=run.astype(np.intp))


def constant_share(torque: FrictionTorque, joint: int) -> float:
    """Share of a record's time in which one joint moves at constant speed."""
    return float(np.mean(_is_constant(_means(torque, joint)[:, 0])))


def _means(torque: FrictionTorque, joint: int) -> Array:
    """Mean motor speed, friction and joint position in windows, shape (n_windows, 3); NaN at the ends of a record."""
    signals = torque.signals
    length = max(1, round(WINDOW / signals.dt))
    count = len(signals.t) // length
    columns = (signals.motor_dq, torque.friction, signals.q)
    rows = np.stack([column[: count * length, joint] for column in columns], axis=1)
    rows[~torque.counts(joint)[: count * length]] = np.nan
    means: Array = rows.reshape(count, length, 3).mean(axis=1)
    return means


def _settled(speed: Array, settling: float) -> list[IntArray]:
    """Windows of each run at constant `speed` (n_windows,), from where the joint has gone `settling` [rad]."""
    found = []
    for start, stop in runs(_is_constant(speed)):
        travel = WINDOW * np.cumsum(np.abs(speed[start : stop - 1]))
        rows = start + 1 + np.flatnonzero(travel[:-1] >= settling)  # the first and the last window have a ramp in them
        if len(rows):
            found.append(rows)
    return found


def _is_constant(speed: Array) -> BoolArray:
    """Whether speed changes neither before nor after a window, shape (n_windows,)."""
    constant = np.zeros(len(speed), dtype=np.bool_)
    if len(speed) >= 3:
        change = np.abs(np.diff(speed)) / WINDOW
        drift, here = np.maximum(change[1:], change[:-1]), np.abs(speed[1:-1])  # a sine of 2 windows looks the same
        constant[1:-1] = (here > _SLOWEST) & (drift < np.maximum(_SLOWEST_DRIFT, _DRIFT * here))
    return constant


_MOVING = 0.05
"""Motor speed that a joint must reach on either side of a reversal [rad/s]: a third of the Stribeck velocity of the
thesis, well above what an encoder shows at rest."""

_SLIDES = 3.0
"""Way between two reversals, in presliding lengths f_s / sigma_0, from which on a joint slides: bristles are then bent
to 95 %. A joint that other joints only shake goes a fraction of one; the shortest of table 6.1 goes ten."""

_LEAST = 2
"""Reversals that a record must have: with one, an offset and a change of direction look alike."""

_MOSTLY = 0.2
"""Share of the time at constant speed from which a record is one of constant speeds: a sine has less than 0.02."""


def n_reversals(torque: FrictionTorque, joint: int, presliding: float) -> int:
    """Times that a joint turns back between slides, which are longer than `presliding` [rad] some times."""
    speed = torque.signals.motor_dq[torque.counts(joint), joint]
    speed = np.where(np.abs(speed) > _MOVING, speed, 0.0)
    moving = speed[speed != 0]
    if not len(moving):
        return 0
    stroke = np.concatenate([[0], np.cumsum(np.diff(np.sign(moving)) != 0)])
    way = np.bincount(stroke, np.abs(moving)) * torque.signals.dt
    slides = way > _SLIDES * presliding
    return int(np.count_nonzero(slides[1:] & slides[:-1]))


def reverses(torque: FrictionTorque, joint: int, presliding: float) -> bool:
    """Whether a record tells a joint's bristles; arguments as `n_reversals`."""
    return n_reversals(torque, joint, presliding) >= _LEAST and constant_share(torque, joint) < _MOSTLY
