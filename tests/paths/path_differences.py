"""Finite differences, for tests that compare derivatives with them."""

import numpy as np


def central(values, step):
    """Derivative of rows at all but the first and the last."""
    return (values[2:] - values[:-2]) / (2 * step)


def unit(vector):
    return np.asarray(vector, dtype=float) / np.linalg.norm(vector)


def check_curve(curve, *, kinks=(), rtol=2e-3):
    """A curve's derivatives are derivatives, and its parameter is arc length; third ones may jump at `kinks`."""
    s = np.linspace(0.0, curve.length, 4001)
    step = s[1]
    parts = curve.at(s)
    np.testing.assert_allclose(np.linalg.norm(parts[1], axis=1), 1.0, atol=1e-9)
    for k in range(3):
        slope, middle = central(parts[k], step), s[1:-1]
        smooth = np.all([np.abs(middle - kink) > 2 * step for kink in kinks] or [middle >= 0], axis=0)
        size = np.abs(parts[k + 1]).max() + 1e-3 / curve.length**k
        np.testing.assert_allclose(slope[smooth], parts[k + 1][1:-1][smooth], rtol=0, atol=rtol * size)
