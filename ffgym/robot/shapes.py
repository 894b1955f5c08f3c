"""Shapes that a robot is drawn with; they weigh nothing and touch nothing."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, kw_only=True, eq=False)
class Mesh:
    """A surface of triangles."""

    vertices: NDArray[np.float32]
    """Corners [m], shape (V, 3)."""
    faces: NDArray[np.int32]
    """Three corners each, counter-clockwise from outside, shape (F, 3)."""


@dataclass(frozen=True, kw_only=True)
class Geom:
    """One shape of the robot's looks, in the frame of its body."""

    body: str
    type: str
    """'box', 'sphere', 'ellipsoid', 'cylinder', 'capsule' or 'mesh'."""
    size: tuple[float, ...]
    """Radius, or half sizes of a box or ellipsoid [m]; empty for a mesh."""
    pos: tuple[float, float, float]
    """Centre, or first end of a cylinder or capsule [m]."""
    end: tuple[float, float, float] | None
    """Second end of a cylinder or capsule [m]."""
    colour: tuple[float, ...]
    """Red, green, blue, opacity."""
    rotation: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    """Unit quaternion, scalar first; of no use to a cylinder or capsule."""
    mesh: Mesh | None = None
    """Surface of a mesh."""
