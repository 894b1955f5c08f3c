"""Lines, balls and plates that are drawn beside what the model has."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import final

import mujoco
import numpy as np

from ffgym.core.types import Array

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
