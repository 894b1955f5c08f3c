"""Computations that a trial model may fail in: whatever of it cannot be computed loses, and ends nothing."""

import numpy as np

from ffgym.core.errors import FFGymError

FAILED = (FFGymError, np.linalg.LinAlgError, FloatingPointError)
"""An arm that flies away, a simulation that becomes unstable, a machine that cannot be so; equations without solution;
numbers beyond those that a computer has."""
