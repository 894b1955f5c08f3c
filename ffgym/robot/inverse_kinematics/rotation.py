"""How far one orientation is from another."""

import numpy as np

from ffgym.core.types import Array


def rotation_error(wanted: Array, actual: Array) -> Array:
    """Rotation vectors [rad] in the world from `actual` (T, 3, 3) to `wanted` (3, 3) or (T, 3, 3), shape (T, 3).

    Exact to third order near zero.
    """
    turn = wanted @ actual.swapaxes(1, 2)
    axis = 0.5 * np.stack(
        [turn[:, 2, 1] - turn[:, 1, 2], turn[:, 0, 2] - turn[:, 2, 0], turn[:, 1, 0] - turn[:, 0, 1]], 1
    )
    sine, cosine = np.linalg.norm(axis, axis=1), 0.5 * (np.trace(turn, axis1=1, axis2=2) - 1.0)
    angle = np.arctan2(sine, cosine)
    vector = axis * np.where(sine > 1e-9, angle / np.where(sine > 1e-9, sine, 1.0), 1.0)[:, None]
    for i in np.flatnonzero((sine <= 1e-9) & (cosine < 0)):  # half a turn: its axis is what turn + 1 keeps
        kept = turn[i] + np.eye(3)
        longest = kept[:, np.argmax(np.linalg.norm(kept, axis=0))]
        vector[i] = np.pi * longest / np.linalg.norm(longest)
    return vector
