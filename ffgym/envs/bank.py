"""Rows of all motions that a batch follows, in one table, so that each step looks all of them up at once."""

import numpy as np

from ffgym.control.setpoints import interpolate_motion
from ffgym.core.types import Array, IntArray
from ffgym.envs.motion import Columns, Motion
from ffgym.simulation.plant import Plant

LARGEST = 64 * 2**20
"""Size beyond which nothing is kept [bytes]: room for all motions of the thesis' circle test."""


class SetpointTable:
    """Position and velocity at every physics step of every control step, in MuJoCo's order of controls.

    What it holds is computed as it would be at every step, bit for bit; docs/performance.md says what it saves.
    """

    def __init__(self, plant: Plant, fractions: Array) -> None:
        self._plant, self._fractions = plant, fractions
        self._rows = np.zeros((0, plant.n_substeps, plant.model.nu))

    def take(self, rows: IntArray) -> Array:
        """Controls of the control steps that begin at `rows` (B,), shape (B, S, 3 N), torque 0; a copy."""
        return self._rows.take(rows, axis=0)

    def write(self, start: int, position: Array, velocity: Array) -> None:
        """Compute the rows from `start` on, of motor-side samples [rad], [rad/s], shape (T, N) each; the last is 0."""
        steps = self._rows[start : start + len(position) - 1]
        out_position, out_velocity, _ = self._plant.split_controls(steps[None])
        dt = self._plant.robot.servo.control_dt
        self._rows[start + len(steps)] = 0.0
        interpolate_motion(position[None], velocity[None], dt, self._fractions, (out_position, out_velocity))

    def move(self, start: int, to: int, length: int) -> None:
        """Move `length` rows towards the front."""
        self._rows[to : to + length] = self._rows[start : start + length]

    def resize(self, length: int) -> bool:
        """Make room for `length` rows; False if that would be too large."""
        if length * self._rows[:0].itemsize * self._plant.n_substeps * self._plant.model.nu > LARGEST:
            self._rows = self._rows[:0].copy()
            return False
        if length > len(self._rows):
            self._rows.resize((length, *self._rows.shape[1:]), refcheck=False)
        return True


_KEEP_ROWS = 200_000
"""Motions that nobody follows any more are kept up to this number of rows in all: 50 MB, several times the thesis'
circle test."""


class MotionBank:
    """Assigns motions to B sub-environments; each motion is stored once, however many follow it."""

    def __init__(self, n: int, columns: Columns, padding: int, setpoints: SetpointTable | None = None) -> None:
        self.columns = columns
        self._setpoints = setpoints
        self._padding = padding
        self._table = np.zeros((0, columns.width))
        self._filled = 0
        self._place: dict[int, tuple[Motion, int]] = {}
        """By identity: motion and its first row."""
        self.motions: list[Motion | None] = [None] * n
        self._offset = np.zeros(n, dtype=np.int64)

    def assign(self, i: int, motion: Motion) -> None:
        """Let sub-environment `i` follow `motion`."""
        self.motions[i] = motion
        if id(motion) not in self._place:
            self._store(motion)
        self._offset[i] = self._place[id(motion)][1]

    def window(self, step: IntArray, width: int) -> Array:
        """Rows of `width` samples from sample `step` (B,) on, shape (B, width, W); a copy."""
        first: IntArray = self._offset + step
        return self._table.take(first[:, None] + np.arange(width), axis=0)

    def setpoints(self, step: IntArray, ids: IntArray | None) -> Array | None:
        """Controls of the control step from sample `step` (B,) on, torque still open, for sub-environments `ids`.

        Shape (B', S, 3 N), a copy; None is all sub-environments. Returns None where they are not kept, because there
        are too many motions.
        """
        if self._setpoints is None:
            return None
        first: IntArray = self._offset + step
        return self._setpoints.take(first if ids is None else first[ids])

    def _store(self, motion: Motion) -> None:
        rows = motion.rows(self._padding)
        if self._filled + len(rows) > len(self._table):
            self._make_room(len(rows))
        self._table[self._filled : self._filled + len(rows)] = rows
        if self._setpoints is not None:
            self._setpoints.write(self._filled, rows[:, self.columns.position], rows[:, self.columns.velocity])
        self._place[id(motion)] = (motion, self._filled)
        self._filled += len(rows)

    def _make_room(self, wanted: int) -> None:
        """Move what is followed (and, if it is little, what was) to the front of the table, and make it long enough."""
        followed = {id(motion) for motion in self.motions if motion is not None}
        keep_all = self._filled <= _KEEP_ROWS
        kept = [(m, at) for key, (m, at) in self._place.items() if keep_all or key in followed]
        self._place, self._filled = {}, 0
        for motion, at in kept:  # as they stand in the table, so that none is overwritten before it has moved
            length = motion.n_steps + 1 + self._padding
            self._table[self._filled : self._filled + length] = self._table[at : at + length]
            if self._setpoints is not None:
                self._setpoints.move(at, self._filled, length)
            self._place[id(motion)] = (motion, self._filled)
            self._filled += length
        if self._filled + wanted > len(self._table):  # in place: a second table would double the memory
            self._table.resize((int((self._filled + wanted) * 1.25), self.columns.width), refcheck=False)
        if self._setpoints is not None and not self._setpoints.resize(len(self._table)):
            self._setpoints = None
        for i, followed_now in enumerate(self.motions):
            if id(followed_now) in self._place:
                self._offset[i] = self._place[id(followed_now)][1]


def path_error(tcp: Array, rows: Array, columns: Columns, centre: Array, normal: Array) -> Array:
    """Distance of the TCP from its path [m], shape (B,).

    On a circle it is the distance to its nearest point, in its plane, as `ffgym.recordings.metrics.path_errors`;
    elsewhere the part of TCP - reference across the direction of motion, all of it at rest. Where a motion tells how
    its path bends, what the path leaves its tangent by, s^2 / 2 times the curvature, is taken off at the TCP's distance
    s along it.

    Args:
        tcp: without the offset at standstill [m], shape (B, 3).
        rows: rows of the motions now, shape (B, W).
        columns: what stands where in them.
        centre: of the circles [m], shape (B, 3).
        normal: of their plane, shape (B, 3).
    """
    radius = rows[:, columns.radius]
    circle = (radius > 0)[:, None]
    arm = tcp - np.where(circle, centre, rows[:, columns.tcp])
    drop = np.where(circle, normal, rows[:, columns.tangent])
    along = _dot(arm, drop)[:, None]
    left = arm - along * drop - 0.5 * along**2 * rows[:, columns.bend]
    return np.abs(np.sqrt(_dot(left, left)) - radius)  # the radius is 0 elsewhere


def _dot(a: Array, b: Array) -> Array:
    product: Array = (a * b).sum(axis=1)
    return product
