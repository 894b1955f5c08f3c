"""Dahl's hysteresis, in closed form."""

import numpy as np

from ffgym.core.types import Array


def lagging(z: Array, way: Array, width: Array) -> Array:
    r"""Hysteresis z in [-1, 1] after a `way` in one direction, shape (..., N) each.

    .. math:: z_+ = \sigma + (z - \sigma)\, e^{-|\Delta x| / w}, \quad \sigma = \mathrm{sgn}(\Delta x)

    The exact solution of :math:`dz/dx = (1 - z \sigma) / w`, so that the loop is the same at any rate and step.

    Reference:
        Dahl (1968), "A solid friction model", Aerospace Corporation; Wen (1976) with exponent 1 and equal parts.
    """
    towards = np.sign(way)
    after: Array = towards + (z - towards) * np.exp(-np.abs(way) / width)
    return np.where(way == 0, z, after)
