"""Differences of two engines, and how large they may be."""

import numpy as np

ROUNDING = 2e-14
"""Largest difference of two engines, as a share of the largest value among all poses; most are below 1e-15."""


def relative(found, known, least=0.0):
    """Largest difference as a share of the largest value, or of `least` where all are smaller; of 1 where all are 0."""
    known = np.asarray(known)
    return np.abs(found - known).max() / (max(np.abs(known).max(), least) or 1.0)
