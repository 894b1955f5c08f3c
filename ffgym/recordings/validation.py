"""What makes columns and a header one recording."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.recordings.header import Header
from ffgym.recordings.phase import Phase
from ffgym.recordings.schema import FAMILIES, VALID, check_columns, family_named

LATEST_TIME = 1e11
"""Largest timestamp [s], the year 5138 as seconds since 1970: anything above is in another unit."""


def checked_columns(columns: Mapping[str, Any], header: Header) -> dict[str, Array]:
    """Return read-only float64 copies of `columns`, checked against the schema and `header`.

    Every NaN becomes the one NaN that NumPy writes, so that files in every format keep each bit.

    Raises:
        FFGymError: if a column is unknown, missing, not one-dimensional numbers, of another length or not finite,
            or the timestamps do not increase.
    """
    check_columns(columns, header.joints, header.units)
    if "timestamp" not in columns:
        raise FFGymError(f"Column 'timestamp' [s] is required. Present: {', '.join(columns) or 'none'}.")
    arrays = {name: _as_column(name, value) for name, value in columns.items()}
    n_rows = len(arrays["timestamp"])
    for name, array in arrays.items():
        if len(array) != n_rows:
            raise FFGymError(f"Column {name!r} has {len(array)} rows, must be {n_rows} as in timestamp.")
    if n_rows < 2:
        raise FFGymError(f"A recording needs at least 2 rows, got {n_rows}.")
    for name, array in arrays.items():
        _check_finite(name, array)
        _check_mask(name, array)
        array.flags.writeable = False
    _check_time(arrays["timestamp"])
    return arrays


def check_phases(phases: tuple[Phase, ...], t: Array) -> None:
    """Check that `phases` lie within [t_0, t_last + dt], up to rounding.

    Args:
        phases: phases [s], on the clock of `t`.
        t: timestamps [s], shape (T,); dt is their median period.

    Raises:
        FFGymError: if one starts before or ends after it.
    """
    dt = float(np.median(np.diff(t)))
    first, last = float(t[0]), float(t[-1]) + dt
    for phase in phases:
        if phase.start < first - 1e-3 * dt or phase.end > last + 1e-3 * dt:
            raise FFGymError(
                f"Phase {phase.label!r} [{phase.start}, {phase.end}] s lies outside the recording, [{first}, {last}] s."
            )


def may_miss(column: str) -> bool:
    """Whether NaN in `column` stands for a missing sample."""
    family = FAMILIES.get(column) or FAMILIES.get(column.rpartition(".")[0])
    return family is not None and family.may_miss


def unit_of(column: str, units: Mapping[str, str]) -> str:
    """Unit of a valid `column`, with `units` for the user's own."""
    if column in units:
        return units[column]
    return family_named(column if column in FAMILIES else column.rpartition(".")[0]).unit


def _as_column(name: str, value: Any) -> Array:
    try:
        array = np.asarray(value)
    except ValueError as error:
        raise FFGymError(f"Column {name!r} must be numbers, one per row: {error}.") from error
    if array.dtype.kind not in "biuf" or array.ndim != 1:
        raise FFGymError(
            f"Column {name!r} must be real numbers of shape (T,), got {array.dtype} of shape {array.shape}."
        )
    with np.errstate(over="ignore"):  # a long double beyond float64 becomes inf, which is refused below
        copy = np.array(array, dtype=np.float64)
    copy[np.isnan(copy)] = np.nan
    return copy


def _check_finite(name: str, array: Array) -> None:
    good = ~np.isinf(array) if may_miss(name) else np.isfinite(array)
    if not good.all():
        row = int(np.argmin(good))
        hint = (
            "must be finite"
            if may_miss(name)
            else "must be finite; only tcp.* and temperature.* may miss samples (NaN)"
        )
        raise FFGymError(f"Column {name!r} row {row} is {array[row]}, {hint}. Drop or repair the row.")


def _check_mask(name: str, array: Array) -> None:
    if not name.startswith(f"{VALID}."):
        return
    other = (array != 0.0) & (array != 1.0)
    if other.any():
        row = int(np.argmax(other))
        raise FFGymError(f"Column {name!r} row {row} is {array[row]}, must be 1 where the row counts, or 0.")


def _check_time(t: Array) -> None:
    late = np.abs(t) > LATEST_TIME
    if late.any():
        row = int(np.argmax(late))
        raise FFGymError(f"timestamp row {row} is {t[row]} s, beyond {LATEST_TIME:g} s. Convert it to seconds.")
    stalled = t[1:] <= t[:-1]
    if stalled.any():
        row = int(np.argmax(stalled)) + 1
        raise FFGymError(
            f"timestamp must increase strictly, but row {row} is {t[row]} s after {t[row - 1]} s. Sort or drop rows."
        )
