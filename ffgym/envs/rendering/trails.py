"""What has been seen of every episode so far, at every control step."""

import numpy as np

from ffgym.core.types import Array, IntArray


class Trails:
    """One row per control step and sub-environment, of float64; room grows with the longest episode."""

    def __init__(self, n: int, width: int) -> None:
        self._rows = np.zeros((n, 256, width))
        self._length = np.zeros(n, dtype=np.int64)

    def begin(self, ids: IntArray) -> None:
        """Forget the rows of sub-environments `ids`."""
        self._length[ids] = 0

    def add(self, ids: IntArray, rows: Array) -> None:
        """Append rows (B', W) to those of sub-environments `ids`."""
        if self._length[ids].max(initial=0) == self._rows.shape[1]:
            self._rows = np.concatenate([self._rows, np.zeros_like(self._rows)], axis=1)
        self._rows[ids, self._length[ids]] = rows
        self._length[ids] += 1

    def of(self, i: int) -> Array:
        """Rows of sub-environment `i` since its episode began, shape (T, W); a view."""
        return self._rows[i, : self._length[i]]
