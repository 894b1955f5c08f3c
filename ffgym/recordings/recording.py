"""Recording: columns of one motion, simulated or measured, with a header that gives their meaning."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any, NoReturn, final

import numpy as np

from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.types import Array, BoolArray
from ffgym.recordings.header import PHASE_KINDS, Header, Phase, PhaseKind, clip_phases
from ffgym.recordings.schema import FAMILIES, USER_PREFIX, VALID, Family, check_columns, family_named, family_of

_READERS = {
    "one": "recording[{!r}]",
    "joint": "recording.joint_array({!r})",
    "xyz": "recording.vector({!r})",
    "quaternion": "recording.quaternion({!r})",
}

LATEST_TIME = 1e11
"""Largest timestamp [s], the year 5138 as seconds since 1970: anything above is in another unit."""


@final
@dataclass(frozen=True, eq=False)
class Recording:
    """One motion, one row per sample. Complete and valid once built; nothing in it changes afterwards.

    Raises:
        FFGymError: if the columns do not follow the schema, differ in length, hold values that are not finite, or do
            not fit the header. NaN is allowed in `tcp.*` and `temperature.*` only, where it marks a missing sample.
    """

    columns: Mapping[str, Array]
    """Column name -> samples, shape (T,), float64, read-only; T >= 2."""
    header: Header
    """Meaning of the columns."""

    def __post_init__(self) -> None:
        if not isinstance(self.header, Header):
            raise FFGymError(f"header must be a Header, got {type(self.header).__name__}.")
        if not isinstance(self.columns, Mapping):
            raise FFGymError(f"columns must map names to arrays, got {type(self.columns).__name__}.")
        known = self.columns.known if isinstance(self.columns, _Derived) else {}
        columns = _check_columns(self.columns, self.header, known)
        object.__setattr__(self, "columns", MappingProxyType(columns))
        # phases lie within [t_0, t_last + dt], up to rounding
        first, last = float(self.t[0]), float(self.t[-1]) + self.dt
        for phase in self.header.phases:
            if phase.start < first - 1e-3 * self.dt or phase.end > last + 1e-3 * self.dt:
                raise FFGymError(
                    f"Phase {phase.label!r} [{phase.start}, {phase.end}] s lies outside the recording, [{first}, "
                    f"{last}] s."
                )

    def __getitem__(self, column: str) -> Array:
        """Samples of one column, shape (T,); FFGymError if the recording has none."""
        if column not in self.columns:
            raise FFGymError(
                f"No column {column!r} in this recording. Available: {', '.join(self.families)} with joints "
                f"{', '.join(self.header.joints)}."
            )
        return self.columns[column]

    def __iter__(self) -> NoReturn:
        """Refuse to be taken for a list of recordings."""
        raise FFGymError("This is one recording, not a list of them: put it in one, [recording], or name a column.")

    def __len__(self) -> int:
        return len(self.t)

    def __repr__(self) -> str:
        span = f"t = {self.t[0]:g} to {self.t[-1]:g} s"
        return f"Recording({self.header.robot!r}, {self.header.segment!r}, {len(self)} rows, {span}, {self.families})"

    def __reduce__(self) -> tuple[Any, ...]:
        return Recording, (dict(self.columns), self.header)  # a mapping proxy cannot be pickled

    def derive(self, columns: Mapping[str, Any], header: Header | None = None) -> "Recording":
        """Return a recording of these columns (T,), with the same header unless another is given.

        Columns of this recording that keep their name are shared with it, and not checked again.
        """
        return Recording(_Derived(columns, self.columns), self.header if header is None else header)

    def rename(self, segment: str) -> "Recording":
        """Return the recording with another name of its segment."""
        return self.derive(self.columns, replace(self.header, segment=segment))

    @property
    def t(self) -> Array:
        """Controller clock [s], shape (T,), strictly increasing."""
        return self.columns["timestamp"]

    @cached_property
    def dt(self) -> float:
        """Median sample period [s]."""
        return float(np.median(np.diff(self.t)))

    @cached_property
    def valid(self) -> BoolArray:
        """Mask of rows that count for each joint, shape (T, N): `valid.<joint>`, or all rows without that family."""
        if not self.has(VALID):
            return np.ones((len(self), len(self.header.joints)), dtype=np.bool_)
        return self.joint_array(VALID) > 0.5

    @property
    def families(self) -> tuple[str, ...]:
        """Families and user columns that are present, in the order of the schema."""
        held = tuple(name for name, family in FAMILIES.items() if self._holds(family))
        return held + tuple(name for name in self.columns if name.startswith(USER_PREFIX))

    def has(self, family: str) -> bool:
        """Tell if the `family` (for example `motor.position`) or the user column of that name is present.

        Raises:
            FFGymError: if the schema knows no such family, so that a misspelt name is not taken for an absent one.
        """
        if family.startswith(USER_PREFIX):
            return family in self.columns
        return self._holds(family_named(family))

    def _holds(self, family: Family) -> bool:
        return any(column in self.columns for column in family.columns(self.header.joints))

    def unit(self, column: str) -> str:
        """Return the unit of a column that is present."""
        self[column]
        units = self.header.units
        family = family_of(column)
        return units[column] if family is None else family.unit

    def joint_array(self, family: str) -> Array:
        """Stack columns of a per-joint `family`, shape (T, N), in the order of `header.joints`.

        If only some joints have the sensor, as for `link.position`, the others are NaN.

        Raises:
            FFGymError: if the family is not per joint, or the recording does not have it.
        """
        return self._stack(family, "joint")

    def vector(self, family: str) -> Array:
        """Stack columns x, y, z of a Cartesian `family`, shape (T, 3); errors as `joint_array`."""
        return self._stack(family, "xyz")

    def quaternion(self, family: str) -> Array:
        """Stack columns qw, qx, qy, qz of an orientation `family`, shape (T, 4); errors as `joint_array`."""
        return self._stack(family, "quaternion")

    def phases_of(self, kind: PhaseKind) -> tuple[Phase, ...]:
        """Return all phases of that `kind`, in order."""
        check_choice("phase kind", kind, PHASE_KINDS)
        return tuple(phase for phase in self.header.phases if phase.kind == kind)

    def mask(self, *, kind: PhaseKind | None = None, label: str | None = None) -> BoolArray:
        """Return the mask of phases, shape (T,): start <= t < end. They must match both arguments, if given.

        Raises:
            FFGymError: if `kind` is unknown, or no phase has this `label`. A kind that does not occur has no rows.
        """
        phases = self.header.phases if kind is None else self.phases_of(kind)
        if label is not None:
            check_choice("phase label", label, tuple(dict.fromkeys(phase.label for phase in self.header.phases)))
            phases = tuple(phase for phase in phases if phase.label == label)
        inside = np.zeros(len(self), dtype=np.bool_)
        for phase in phases:
            inside |= self.during(phase)
        return inside

    def during(self, phase: Phase) -> BoolArray:
        """Return the mask of one phase, shape (T,): start <= t < end."""
        return np.asarray((self.t >= phase.start) & (self.t < phase.end))

    def slice(self, start: float | None = None, end: float | None = None) -> "Recording":
        """Cut out rows with start <= t < end [s], 2 or more; None leaves that side open. Phases are cut, too."""
        low, high = (-np.inf if start is None else start), (np.inf if end is None else end)
        first, last = np.searchsorted(self.t, (low, high)).tolist()
        count = max(0, last - first)
        if count < 2:
            span = f"[{self.t[0]}, {self.t[-1]}] s"
            raise FFGymError(f"slice({start}, {end}) keeps {count} rows of {span}, must keep at least 2.")
        # rows of columns that were checked need no check; a view would keep the whole column
        columns = {name: values[first:last].copy() for name, values in self.columns.items()}
        t = columns["timestamp"]
        phases = clip_phases(self.header.phases, float(t[0]), float(t[-1] + np.median(np.diff(t))))
        return Recording(_Derived(columns, columns), replace(self.header, phases=phases))

    def with_columns(
        self, columns: Mapping[str, Any] | None = None, /, *, units: Mapping[str, str] | None = None, **more: Any
    ) -> "Recording":
        """Return a recording with these columns (T,) added or replaced, and `units` of new `user.` columns.

        Columns may be keywords too, `**{"user.x": x}`.
        """
        header = replace(self.header, units={**self.header.units, **(units or {})})
        return self.derive({**self.columns, **(columns or {}), **more}, header)

    def equals(self, other: "Recording") -> bool:
        """Compare headers, and names and bits of columns in any order."""
        return (
            self.header == other.header
            and self.columns.keys() == other.columns.keys()
            and all(values.tobytes() == other.columns[name].tobytes() for name, values in self.columns.items())
        )

    def _stack(self, name: str, parts: str) -> Array:
        family = family_named(name)
        if family.parts != parts:
            raise FFGymError(f"{family.name} is read with {_READERS[family.parts].format(family.name)}.")
        columns = family.columns(self.header.joints)
        if family.may_lack and self._holds(family):
            nowhere = np.full(len(self), np.nan)
            return np.stack([self.columns.get(column, nowhere) for column in columns], axis=1)
        return np.stack([self[column] for column in columns], axis=1)


class _Derived(dict[str, Any]):
    """Columns, and those among them that are known to follow the schema, as they are of a recording."""

    def __init__(self, columns: Mapping[str, Any], known: Mapping[str, Array]) -> None:
        super().__init__(columns)
        self.known = known


def _check_columns(columns: Mapping[str, Any], header: Header, known: Mapping[str, Array]) -> dict[str, Array]:
    """Copy `columns` as read-only float64, checked against the schema and `header`; those `known` are kept."""
    check_columns(columns, header.joints, header.units)
    if "timestamp" not in columns:
        raise FFGymError(f"Column 'timestamp' [s] is required. Present: {', '.join(columns) or 'none'}.")
    fresh = {name: _as_column(name, value) for name, value in columns.items() if known.get(name) is not value}
    arrays = {name: fresh.get(name, value) for name, value in columns.items()}
    n_rows = len(arrays["timestamp"])
    for name, array in arrays.items():
        if len(array) != n_rows:
            raise FFGymError(f"Column {name!r} has {len(array)} rows, must be {n_rows} as in timestamp.")
    if n_rows < 2:
        raise FFGymError(f"A recording needs at least 2 rows, got {n_rows}.")
    for name, array in fresh.items():
        _check_values(name, array)
    if "timestamp" in fresh:
        _check_time(fresh["timestamp"])
    for array in arrays.values():
        array.flags.writeable = False
    return arrays


def _as_column(name: str, value: Any) -> Array:
    try:
        array = np.asarray(np.ma.filled(value.astype(np.float64), np.nan) if np.ma.is_masked(value) else value)
    except ValueError as error:
        raise FFGymError(f"Column {name!r} must be numbers, one per row: {error}.") from error
    if array.dtype.kind not in "biuf" or array.ndim != 1:
        raise FFGymError(
            f"Column {name!r} must be real numbers of shape (T,), got {array.dtype} of shape {array.shape}."
        )
    with np.errstate(over="ignore"):  # a long double beyond float64 becomes inf, which is refused below
        return np.array(array, dtype=np.float64)


def _check_values(name: str, array: Array) -> None:
    """Check that numbers are finite, unless the family may miss samples, and that a mask is 0 or 1.

    Every NaN becomes the one NaN that NumPy writes, so that files in every format keep each bit.
    """
    good = np.isfinite(array)
    if not good.all():
        family = family_of(name)
        may_miss = family is not None and family.may_miss
        if may_miss:
            missing = np.isnan(array)
            array[missing] = np.nan
            good |= missing
        if not good.all():
            row = int(np.argmin(good))
            hint = "" if may_miss else "; only tcp.* and temperature.* may miss samples (NaN)"
            raise FFGymError(
                f"Column {name!r} row {row} is {array[row]}, must be finite{hint}. Drop or repair the row."
            )
    if name.startswith(f"{VALID}."):
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
