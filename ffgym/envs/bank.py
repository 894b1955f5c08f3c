"""Bank of motions: rows of all motions that a batch follows in one table, looked up at once in each step."""

import numpy as np

from ffgym.control import FeedForwardLaw, ObservationLayout
from ffgym.control.setpoints import interpolate_motion
from ffgym.core.types import Array, IntArray
from ffgym.envs.motion import EpisodeMotion, MotionColumns
from ffgym.simulation.plant import Plant

LARGEST = 64 * 2**20
"""Size beyond which no controls are kept [bytes]: room for all motions of the thesis' circle test."""
_KEEP_ROWS = 200_000
"""Motions that are no longer followed are kept up to this number of rows in all: 50 MB, several times the thesis'
circle test."""


class MotionBank:
    """Assigns motions to B sub-environments; each motion is stored once, however many follow it.

    With a plant, position and velocity at every physics step of every control step are kept too, in MuJoCo's order of
    controls, as they would be computed at every step, bit for bit; docs/performance.md has the time that this saves.
    With a layout of observations, samples of the reference are kept as observations have them.

    Args:
        n: number of sub-environments B.
        columns: columns of the rows.
        padding: number of copies of the last row of a motion behind it.
        plant: plant whose controls are kept; None keeps none.
        base: law whose torque is in the rows; None for none.
        layout: layout of observations; None keeps no samples of them.
    """

    def __init__(
        self,
        n: int,
        columns: MotionColumns,
        padding: int,
        plant: Plant | None = None,
        base: FeedForwardLaw | None = None,
        layout: ObservationLayout | None = None,
    ) -> None:
        self.columns, self._plant, self._padding, self._base, self._layout = columns, plant, padding, base, layout
        self._table = np.zeros((0, columns.width))
        self._torques = np.zeros((0, columns.n_joints))
        self._samples = np.zeros((0, 0 if layout is None else layout.sample_size))
        self._controls = None if plant is None else np.zeros((0, plant.n_substeps, plant.model.nu))
        self._filled = 0
        self._place: dict[int, tuple[EpisodeMotion, int]] = {}
        """Motion and its first row, by identity."""
        self.motions: list[EpisodeMotion | None] = [None] * n
        self._offset = np.zeros(n, dtype=np.int64)
        self._ahead = np.zeros((0, 1), dtype=np.int64)
        self.has_bends = False
        """True if a motion has the curvature of its path."""

    def assign(self, i: int, motion: EpisodeMotion) -> None:
        """Let sub-environment `i` follow `motion`."""
        self.motions[i] = motion
        if id(motion) not in self._place:
            self._store(motion)
        self._offset[i] = self._place[id(motion)][1]

    def places(self, step: IntArray, width: int) -> IntArray:
        """Return the places of `width` samples from sample `step` (B,) on, (width, B), until motions are assigned."""
        if len(self._ahead) != width:
            self._ahead = np.arange(width)[:, None]
        return self._ahead + (self._offset + step)

    def rows(self, places: IntArray) -> Array:
        """Look up rows at `places` (...), shape (..., W); a copy."""
        return self._table.take(places, axis=0)

    def torques(self, places: IntArray) -> Array:
        """Look up torques [N m] of rigid feed-forward and base, motor side, at `places` (...), (..., N); a copy.

        Those of a base that corrects set-points are none.
        """
        return self._torques.take(places, axis=0)

    def samples(self, places: IntArray) -> Array:
        """Look up samples of observations at `places` (...), shape (..., K); a copy."""
        return self._samples.take(places, axis=0)

    def write_setpoints(self, places: IntArray, out: Array) -> bool:
        """Write controls of the control steps that begin at `places` (B',), without torque, into `out` (B', S, 3 N).

        Returns:
            False where they are not kept, because there are too many motions.
        """
        if self._controls is None:
            return False
        self._controls.take(places, axis=0, out=out, mode="clip")  # a mode that needs no copy of `out`; all are inside
        return True

    def _store(self, motion: EpisodeMotion) -> None:
        corrects = self._layout is not None and self._layout.channel == "setpoint"
        rows, start = motion.rows(self._padding, self._base, corrects=corrects), self._filled
        if start + len(rows) > len(self._table):
            self._make_room(len(rows))
            start = self._filled
        self._filled = end = start + len(rows)
        self._table[start:end] = rows
        feedforward = rows[:, self.columns.feedforward]
        self._torques[start:end] = (
            feedforward if self._base is None or corrects else feedforward + rows[:, self.columns.base]
        )
        self.has_bends = self.has_bends or bool(rows[:, self.columns.bend].any())
        if self._layout is not None:
            self._samples[start:end] = self._layout.encode_samples(rows[:, self.columns.reference])
        self._place[id(motion)] = (motion, start)
        if self._controls is None or self._plant is None:
            return
        position, velocity, _ = self._plant.split_controls(self._controls[None, start : end - 1])
        samples = rows[None, :, self.columns.position], rows[None, :, self.columns.velocity]
        fractions = np.arange(self._plant.n_substeps) / self._plant.n_substeps
        interpolate_motion(*samples, self._plant.robot.servo.control_dt, fractions, (position, velocity))
        self._controls[end - 1] = 0.0

    def _make_room(self, wanted: int) -> None:
        """Move motions that are followed (all, if they are few) to the front of the tables, and make these longer."""
        followed = {id(motion) for motion in self.motions if motion is not None}
        keep_all = self._filled <= _KEEP_ROWS
        kept = [(m, at) for key, (m, at) in self._place.items() if keep_all or key in followed]
        self._place, self._filled = {}, 0
        # in the order of the table, so that no motion is overwritten before it has moved
        for motion, at in kept:
            length = motion.n_steps + 1 + self._padding
            for table in (self._table, self._torques, self._samples, self._controls):
                if table is not None:
                    table[self._filled : self._filled + length] = table[at : at + length]
            self._place[id(motion)] = (motion, self._filled)
            self._filled += length
        for i, followed_now in enumerate(self.motions):
            if id(followed_now) in self._place:
                self._offset[i] = self._place[id(followed_now)][1]
        # longer tables, in place: a second table would double the memory
        if self._filled + wanted > len(self._table):
            length = int((self._filled + wanted) * 1.25)
            for table in (self._table, self._torques, self._samples):
                table.resize((length, table.shape[1]), refcheck=False)
        if self._controls is not None:
            shape = (len(self._table), *self._controls.shape[1:])
            if np.prod(shape) * self._controls.itemsize > LARGEST:
                self._controls = None
            elif len(self._controls) < len(self._table):
                self._controls.resize(shape, refcheck=False)


def path_error(tcp: Array, rows: Array, columns: MotionColumns, *, has_bends: bool = True) -> Array:
    """Compute the distance of the TCP from its path [m], shape (B,).

    On a circle it is the distance to its nearest point, in its plane, as `ffgym.recordings.metrics.path_errors`;
    elsewhere the part of TCP - reference across the direction of motion, all of it at rest. Where a motion has the
    curvature of its path, the path's distance from its tangent, s^2 / 2 times the curvature, is subtracted at the TCP's
    distance s along it.

    The `tcp` (B, 3) is without its offset at standstill [m], `rows` (B, W) are those of the motions now. False for
    `has_bends` leaves out curvatures, all of which are zero.
    """
    # components first, so that each operation runs along the batch
    anchor, axis, bend = np.ascontiguousarray(rows[:, columns.geometry].T).reshape(3, 3, -1)
    arm = tcp.T - anchor
    along = _dot(arm, axis)
    left = arm - along * axis
    if has_bends:
        left -= 0.5 * along**2 * bend
    return np.abs(np.sqrt(_dot(left, left)) - rows[:, columns.radius])  # the radius is 0 but on circles


def _dot(a: Array, b: Array) -> Array:
    """Scalar products of vectors (3, B), shape (B,)."""
    product: Array = np.add.reduce(a * b, axis=0)
    return product
