"""Measures of numbers, the same in every package."""

from typing import overload

import numpy as np

from ffgym.core.types import Array


@overload
def rms(values: Array, axis: None = None) -> float: ...
@overload
def rms(values: Array, axis: int | tuple[int, ...]) -> Array: ...
def rms(values: Array, axis: int | tuple[int, ...] | None = None) -> float | Array:
    """Compute the root mean square of `values`, of all or along some axes."""
    size = np.sqrt(np.mean(values**2, axis=axis))
    return float(size) if axis is None else np.asarray(size)


def interpolate(t: Array, known: Array, values: Array) -> Array:
    """Interpolate `values` (K, ...) at times `known` straight to times `t` (T,), held beyond both ends."""
    flat = values.reshape(len(values), -1)
    columns = np.stack([np.interp(t, known, column) for column in flat.T], axis=1)
    return columns.reshape(len(t), *values.shape[1:])


def rms_length(vectors: Array) -> float:
    """Root mean square of the lengths of vectors (T, m)."""
    return float(np.sqrt((vectors**2).sum(axis=1).mean()))
