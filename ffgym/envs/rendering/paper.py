"""Lines, balls and plates beside what the model has, and the sheet with a millimetre grid behind a close-up."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import final

import mujoco
import numpy as np

from ffgym.core.types import Array
from ffgym.envs.rendering.camera import Camera
from ffgym.recordings.metrics import round_down

Colour = tuple[float, float, float, float]
"""Red, green, blue and opacity, 0 to 1."""

_IDENTITY = np.eye(3).ravel()


class Mark(ABC):
    """Something to draw."""

    @abstractmethod
    def moved(self, turn: Array, origin: Array, target: Array) -> "Mark":
        """Copy with `origin` at `target`, turned and scaled about it by the matrix `turn` (3, 3)."""

    @abstractmethod
    def add_to(self, scene: mujoco.MjvScene, scale: float = 1.0) -> None:
        """Append its geoms to a scene, as many as there is room for; lines are `scale` as wide as they say."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Curve(Mark):
    """Points joined by lines."""

    points: Array
    """[m], shape (T, 3)."""
    colour: Colour
    width: float = 1.0
    """Of the lines [pixel], in a picture of the usual size."""

    def moved(self, turn: Array, origin: Array, target: Array) -> "Curve":
        """See base class."""
        return replace(self, points=target + (self.points - origin) @ turn.T)

    def add_to(self, scene: mujoco.MjvScene, scale: float = 1.0) -> None:
        """See base class."""
        kind = mujoco.mjtGeom.mjGEOM_LINE
        for start, end in zip(self.points[:-1], self.points[1:], strict=True):
            geom = _next(scene, kind, self.colour)
            if geom is None:
                return
            mujoco.mjv_connector(geom, kind, scale * self.width, start, end)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Ball(Mark):
    """A ball."""

    centre: Array
    radius: float
    colour: Colour

    def moved(self, turn: Array, origin: Array, target: Array) -> "Ball":
        """See base class."""
        scale = float(np.linalg.norm(turn[:, 0]))
        return replace(self, centre=target + turn @ (self.centre - origin), radius=scale * self.radius)

    def add_to(self, scene: mujoco.MjvScene, scale: float = 1.0) -> None:
        """See base class."""
        _next(scene, mujoco.mjtGeom.mjGEOM_SPHERE, self.colour, np.full(3, self.radius), self.centre)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Plate(Mark):
    """A box with sides along the columns of `rotation`."""

    centre: Array
    half_size: Array
    rotation: Array
    """Shape (3, 3)."""
    colour: Colour

    def moved(self, turn: Array, origin: Array, target: Array) -> "Plate":
        """See base class."""
        scale = float(np.linalg.norm(turn[:, 0]))
        return replace(
            self,
            centre=target + turn @ (self.centre - origin),
            half_size=scale * self.half_size,
            rotation=turn @ self.rotation / scale,
        )

    def add_to(self, scene: mujoco.MjvScene, scale: float = 1.0) -> None:
        """See base class."""
        kind = mujoco.mjtGeom.mjGEOM_BOX
        _next(scene, kind, self.colour, self.half_size, self.centre, np.ascontiguousarray(self.rotation).ravel())


def _next(
    scene: mujoco.MjvScene,
    kind: mujoco.mjtGeom,
    colour: Colour,
    size: Array | None = None,
    centre: Array | None = None,
    rotation: Array = _IDENTITY,
) -> mujoco.MjvGeom | None:
    """A new geom of the scene; None if it is full."""
    if scene.ngeom >= scene.maxgeom:
        return None
    geom = scene.geoms[scene.ngeom]
    scene.ngeom += 1
    nothing = np.zeros(3)
    mujoco.mjv_initGeom(
        geom, kind, nothing if size is None else size, nothing if centre is None else centre, rotation, np.array(colour)
    )
    geom.category = mujoco.mjtCatBit.mjCAT_DECOR.value
    geom.emission, geom.specular, geom.shininess = 0.5, 0.1, 0.1
    return geom


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
