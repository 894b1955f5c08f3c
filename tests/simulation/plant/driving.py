"""Controls for a plant from set-points."""

import numpy as np


def controls(plant, position=0.0, velocity=0.0, torque=0.0, *, shape=None):
    """Rows of controls (..., 3 N) from motor-side set-points (..., N), which are broadcast to `shape` (..., N)."""
    wanted = np.broadcast_shapes(*(np.shape(x) for x in (position, velocity, torque))) if shape is None else shape
    rows = np.zeros((*wanted[:-1], plant.model.nu))
    for column, values in zip(plant.split_controls(rows), (position, velocity, torque), strict=True):
        column[...] = values
    return rows


class EngineTables:
    """Arrays by name in place of those of an engine, of random numbers."""

    def __init__(self, **shapes):
        rng = np.random.default_rng(4)
        self.arrays = {name: rng.uniform(0.5, 2.0, shape) for name, shape in shapes.items()}

    def bind(self, name):
        """Return the array itself, as the engine does."""
        return self.arrays[name]
