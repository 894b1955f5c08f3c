"""The way of the tool beside its path, with magnified error, and trails of what was sampled."""

from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.envs.motion import Motion
from ffgym.envs.rendering.camera import Camera
from ffgym.recordings.metrics import magnification


class Trails:
    """One row per control step and sub-environment, of float64; room grows with the longest episode."""

    def __init__(self, n: int, width: int) -> None:
        self._rows = np.zeros((n, 256, width))
        self._length = np.zeros(n, dtype=np.int64)

    def begin(self, ids: IntArray) -> None:
        """Forget the rows of sub-environments `ids`."""
        self._length[ids] = 0

    def add(self, ids: IntArray, rows: Array) -> None:
        """Append rows (B', W) to those of sub-environments `ids`."""
        if self._length[ids].max(initial=0) == self._rows.shape[1]:
            self._rows = np.concatenate([self._rows, np.zeros_like(self._rows)], axis=1)
        self._rows[ids, self._length[ids]] = rows
        self._length[ids] += 1

    def of(self, i: int) -> Array:
        """Rows of sub-environment `i` since its episode began, shape (T, W); a view."""
        return self._rows[i, : self._length[i]]


FREE_RADIUS = 0.03
"""Half of what the close-up shows of a motion without circles [m]."""
TYPICAL_LAG = 0.006
"""The path error of the uncompensated robot, RMS, is 4 to 8 ms times its speed; it is drawn as a TYPICAL_SHARE of the
half width of the close-up."""
TYPICAL_SHARE = 1 / 6
CLOSE_UP = 1.75
"""Half of what the close-up shows of circles, in radii of the largest."""
RECENT = 250
"""Control steps before and after the present one that are drawn of a motion without circles: 1 s."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ToolPath:
    """TCP of a motion's reference, and how to look at it."""

    points: Array
    """[m], shape (T, 3)."""
    speed: Array
    """[m/s], shape (T,)."""
    circle: IntArray
    """Number of the circle at each sample, shape (T,); it counts on when a lead-in begins."""
    on_circle: BoolArray
    """Without leads and rests, shape (T,)."""
    is_flat: bool
    """Whether it has circles, which share a plane."""
    centre: Array
    normal: Array
    """Of the plane of the circles, upwards."""
    radius: float
    """Half of what the close-up shows [m]."""
    magnify: float
    """Round factor on the error that suits the speed."""

    @classmethod
    def of(cls, motion: Motion) -> "ToolPath":
        """Path of a motion."""
        at, rows = motion.columns, motion.rows(0)
        points, (centre, normal) = rows[:, at.tcp], motion.plane
        speed = np.linalg.norm(np.gradient(points, motion.reference.t, axis=0), axis=1)
        is_flat = bool(np.any(normal))
        radius = CLOSE_UP * float(np.linalg.norm(points - centre, axis=1).max()) if is_flat else FREE_RADIUS
        typical = TYPICAL_LAG * max(float(speed.max()), 1e-3)
        return cls(
            points=points,
            speed=speed,
            circle=np.cumsum(np.diff(rows[:, at.circle], prepend=-1.0) > 0).clip(min=1),
            on_circle=rows[:, at.radius] > 0,
            is_flat=is_flat,
            centre=centre,
            normal=normal if normal[2] >= 0 else -normal,
            radius=radius,
            magnify=magnification(TYPICAL_SHARE * radius, typical),
        )

    def camera(self, now: Array) -> Camera:
        """Of the close-up: along the normal of the circles; without them it goes with the TCP."""
        if self.is_flat:
            return Camera.along(self.normal, self.centre, self.radius)
        return Camera(centre=now, radius=self.radius, azimuth=-60, elevation=35, orthographic=True)

    @property
    def rounds(self) -> list[slice]:
        """Where the circles are."""
        return runs(self.on_circle)

    def seen(self, length: int) -> tuple[list[slice], slice]:
        """Of the first `length` samples: the circles that are over, and what belongs to the present one."""
        if not self.is_flat:
            return [], slice(max(0, length - RECENT), length)
        start = int(np.searchsorted(self.circle, self.circle[length - 1]))
        return runs(self.on_circle[:start]), slice(start, length)

    def ahead(self, length: int) -> slice:
        """The present circle with its leads; without circles the path before and after sample `length`."""
        if not self.is_flat:
            return slice(max(0, length - RECENT), length + RECENT)
        present = self.circle[length - 1]
        return slice(int(np.searchsorted(self.circle, present)), int(np.searchsorted(self.circle, present, "right")))


def runs(chosen: BoolArray) -> list[slice]:
    """Where values are True without a gap; each with the sample after it, which closes a circle."""
    edges = np.flatnonzero(np.diff(chosen.astype(np.int8), prepend=0, append=0))
    return [slice(int(start), int(end) + 1) for start, end in zip(edges[::2], edges[1::2], strict=True)]
