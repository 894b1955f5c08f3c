"""Positions, turns and poses as RAPID gives them, in metres and rotation matrices."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.paths.rapid.records import Value

MILLIMETRE = 1e-3
"""RAPID's unit of length [m]."""

LARGEST_NORM_ERROR = 1e-3
"""How far the norm of a quaternion may be from 1; chosen: quaternions that are printed with three digits pass."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Frame:
    """Where a coordinate system stands in another."""

    position: Array
    """Its origin [m], shape (3,)."""
    rotation: Array
    """Its orientation, shape (3, 3)."""

    def place(self, inner: "Frame") -> "Frame":
        """A frame that is given in this one, in the system in which this one is given."""
        return Frame(position=self.position + self.rotation @ inner.position, rotation=self.rotation @ inner.rotation)


def point(pos: Value) -> Array:
    """Position [m], shape (3,), of a pos [mm]."""
    return np.array(pos) * MILLIMETRE


def turn(orient: Value, name: str) -> Array:
    """Rotation matrix, shape (3, 3), of an orient: a quaternion, scalar first.

    Raises:
        FFGymError: if its norm is not 1; `name` says whose it is.
    """
    norm = float(np.linalg.norm(orient))
    if not abs(norm - 1) <= LARGEST_NORM_ERROR:
        raise FFGymError(f"{name} = {list(orient)} has norm {norm:.6g}, must be a quaternion of norm 1.")
    q1, q2, q3, q4 = orient
    matrix: Array = Rotation.from_quat([q2, q3, q4, q1]).as_matrix()
    return matrix


def frame(pose: Value, name: str) -> Frame:
    """Frame of a pose [mm]; `name` says whose it is."""
    position, orient = pose
    return Frame(position=point(position), rotation=turn(orient, f"{name}.rot"))
