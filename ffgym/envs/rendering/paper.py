"""The sheet with a millimetre grid behind a close-up, and curves thinned out to what can be seen."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.core.types import Array
from ffgym.envs.rendering.camera import Camera
from ffgym.envs.rendering.marks import Colour, Curve, Mark, Plate
from ffgym.recordings.metrics import round_down

WHITE: Colour = (0.97, 0.97, 0.96, 1.0)
GREY: Colour = (0.80, 0.81, 0.83, 1.0)
SQUARES = 7
"""Grid lines along the shorter side, at least."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Sheet:
    """A blank sheet behind what a camera looks at, square to its view."""

    camera: Camera

    @property
    def reach(self) -> float:
        """How far the grid goes from the middle [m]."""
        return 6.0 * self.camera.radius

    @property
    def middle(self) -> Array:
        """Its centre [m], shape (3,)."""
        return self.camera.centre - 2.0 * self.camera.radius * self.camera.backward

    def marks(self) -> list[Mark]:
        """The sheet."""
        camera = self.camera
        half_size = np.array([10 * self.reach, 10 * self.reach, 1e-3 * self.reach])  # narrow panels see far
        return [Plate(centre=self.middle, half_size=half_size, rotation=camera.axes, colour=WHITE)]


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class GridSheet(Sheet):
    """A sheet with a grid, which stays where it is when the camera moves."""

    @property
    def step(self) -> float:
        """Of the grid [m]."""
        return round_down(2 * self.camera.radius / SQUARES)

    def marks(self) -> list[Mark]:
        """Sheet and grid."""
        camera, n = self.camera, int(self.reach / self.step)
        start = self.middle + 0.05 * camera.radius * camera.backward
        marks = super().marks()
        for along, across in ((camera.right, camera.up), (camera.up, camera.right)):
            first = -np.fmod(start @ across, self.step)
            for k in range(-n, n + 1):
                middle = start + (first + k * self.step) * across
                ends = np.stack([middle - self.reach * along, middle + self.reach * along])
                marks.append(Curve(points=ends, colour=GREY))
        return marks


def spaced(points: Array, step: float) -> Array:
    """Points (T, 3) of a curve about `step` [m] apart or more, with its first and last."""
    if len(points) < 3:
        return points
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    kept = np.flatnonzero(np.diff(np.floor(length / step))) + 1
    return points[np.unique(np.concatenate([[0], kept, [len(points) - 1]]))]
