"""Array aliases. Shapes are written in docstrings with the letters T time, N joints, K parameters, B batch."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""Floating point numbers, SI units."""

BoolArray = NDArray[np.bool_]
"""One truth value per sample, a mask."""

ComplexArray = NDArray[np.complex128]
"""Complex numbers, e.g. eigenvalues."""

IntArray = NDArray[np.intp]
"""Indices."""
