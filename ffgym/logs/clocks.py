"""Clocks: times of the rows, and times of samples that come between them."""

from dataclasses import dataclass
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.logs.column_map import Column
from ffgym.logs.column_map.units import conversion
from ffgym.logs.contents import Contents
from ffgym.logs.si import to_si


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Rows:
    """The rows of one motion in time."""

    t: Array
    """Times [s], shape (T,)."""
    unit: str
    """Unit of their clock in the file."""
    zero: Any = None
    """Reading of that clock at which times begin, None for its own zero."""

    def seconds(self, clock: NDArray[Any], unit: str) -> Array:
        """Times [s] of another clock of the same epoch, on the scale of `t`.

        Raises:
            FFGymError: if `unit` is no time.
        """
        factor = conversion(unit, "s").factor
        if self.zero is None:
            return clock.astype(np.float64) * factor
        if unit == self.unit:
            return since(clock, self.zero).astype(np.float64) * factor
        return clock.astype(np.float64) * factor - float(self.zero) * conversion(self.unit, "s").factor


def rows_of(contents: Contents, timestamp: Column, clock: NDArray[Any]) -> Rows:
    """Rows whose clock reads `clock`, shape (T, 1).

    Raises:
        FFGymError: if its unit is no time.
    """
    zero = clock[0, 0] if timestamp.from_first and len(clock) else None
    readings = clock if zero is None else since(clock, zero)
    return Rows(t=to_si(readings, timestamp, ("s",), contents)[:, 0], unit=str(timestamp.unit), zero=zero)


def rows_at_rate(contents: Contents, rate_hz: float | str, n_rows: int) -> Rows:
    """Rows at a constant rate, which begin at 0.

    Raises:
        FFGymError: if the rate is not one number > 0.
    """
    numbers = contents.numbers(rate_hz).reshape(-1) if isinstance(rate_hz, str) else np.array([rate_hz])
    if numbers.size != 1 or not 0 < numbers[0] < np.inf:
        raise FFGymError(f"rate_hz = {numbers.tolist()[:3]} must be one number > 0.")
    return Rows(t=np.arange(n_rows) / float(numbers[0]), unit="s")


def since(clock: NDArray[Any], zero: Any) -> NDArray[Any]:
    """Clock readings after `zero`; whole numbers stay whole, as nanoseconds since 1970 do not fit a float64."""
    if clock.dtype.kind == "f" or isinstance(zero, float):
        return clock - zero
    return clock.astype(np.int64) - np.int64(zero)
