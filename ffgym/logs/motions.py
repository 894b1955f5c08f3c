"""The motions in a file: one, several along an axis of its arrays, or several below each other in its rows."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ffgym.core.errors import FFGymError
from ffgym.logs.column_map import ColumnMap
from ffgym.logs.contents import Contents
from ffgym.logs.entries import Gathered


@dataclass(frozen=True, kw_only=True, eq=False)
class LoggedMotion:
    """Place of one motion in the arrays of a file."""

    segment: str
    """Its name."""
    index: int = 0
    """Its number along the axis of motions."""
    rows: slice | None = None
    """Its rows, None for all."""
    n_rows: int = 0
    """Rows that every array with the clock of the file must have if it is cut by rows."""
    meta: Mapping[str, Any]
    """Notes of the file about it."""

    def of(self, gathered: Gathered) -> NDArray[Any]:
        """Its part of an array with the clock of the file, shape (T, P)."""
        values = self.uncut(gathered)
        if self.rows is None:
            return values
        if len(values) != self.n_rows:
            raise FFGymError(f"has {len(values)} rows, but the array that splits the motions has {self.n_rows}.")
        return values[self.rows]

    def uncut(self, gathered: Gathered) -> NDArray[Any]:
        """All samples of an array with a clock of its own, shape (C, P)."""
        values: NDArray[Any] = gathered.values[self.index if gathered.stacked else 0]
        return values


def motions_of(contents: Contents, columns: ColumnMap, segment: str, arrays: Iterable[Gathered]) -> list[LoggedMotion]:
    """Motions in a file whose entries have these arrays; `segment` names a single one, and begins names of several."""
    counts = {len(gathered.values) for gathered in arrays if gathered.stacked}
    if len(counts) > 1:
        raise FFGymError(f"Arrays hold different numbers of motions along their axis 'motion': {sorted(counts)}.")
    if columns.split:
        if counts:
            raise FFGymError("[motions] split belongs to motions below each other, the axis 'motion' to stacked ones.")
        splitting = contents[columns.split]
        cuts = _cuts(columns.split, splitting)
        labels = [str(splitting[rows.start]) for rows in cuts]
        places: list[dict[str, Any]] = [{"rows": rows, "n_rows": len(splitting)} for rows in cuts]
    else:
        count = counts.pop() if counts else 1
        labels = [f"{i:0{len(str(count - 1))}d}" for i in range(count)]
        places = [{"index": i} for i in range(count)]
    if columns.names:
        names, name = np.atleast_1d(contents[columns.names]), columns.names
        if names.shape != (len(places),):
            raise FFGymError(
                f"[motions] names: {name!r} has shape {names.shape}, must be {(len(places),)}, one per motion."
            )
        labels = [str(label) for label in names.tolist()]
        if len(set(labels)) < len(labels):
            raise FFGymError(f"[motions] names: {name!r} = {labels} must be different for each motion.")
    several = len(places) > 1 or columns.names
    segments = [f"{segment}_{label}" if several else segment for label in labels]
    metas = [_meta(contents, columns.meta, k, len(places)) for k in range(len(places))]
    return [LoggedMotion(segment=s, meta=m, **place) for s, m, place in zip(segments, metas, places, strict=True)]


def _cuts(name: str, splitting: NDArray[Any]) -> list[slice]:
    """Rows of each run of equal values."""
    if splitting.ndim != 1 or not len(splitting):
        raise FFGymError(f"[motions] split: {name!r} has shape {splitting.shape}, must be one number per row.")
    borders = [0, *(np.flatnonzero(splitting[1:] != splitting[:-1]) + 1).tolist(), len(splitting)]
    starts = splitting[borders[:-1]].tolist()
    for i, start in enumerate(starts):
        if start in starts[:i]:
            raise FFGymError(f"[motions] split: {name!r} comes back to {start!r} in row {borders[i]}; sort the rows.")
    return [slice(first, end) for first, end in pairwise(borders)]


def _meta(contents: Contents, meta: Mapping[str, Any], k: int, count: int) -> dict[str, Any]:
    """Values of [meta] for motion k; an array with one entry per motion gives its own."""
    values = dict(meta)
    for key, value in meta.items():
        if not isinstance(value, dict) or "source" not in value:
            continue
        name = str(value["source"])
        if value.get("optional") is True and name not in contents.arrays:
            del values[key]
            continue
        array = contents[name]
        if value.get("since_first") is True:
            try:
                seconds = np.array([_seconds(time) for time in np.atleast_1d(array).tolist()])
            except ValueError as error:
                raise FFGymError(
                    f"[meta]: {name!r} = {array.tolist()} must be seconds, or times like '20:29'."
                ) from error
            array = seconds - seconds.min()
        own = count > 1 and array.ndim > 0 and len(array) == count
        values[key] = (array[k] if own else array).tolist()
    return values


def _seconds(time: Any) -> float:
    """Seconds of a time of day in seconds, as 'hh:mm' or as 'hh:mm:ss'."""
    parts = [float(part) for part in str(time).split(":")]
    if len(parts) == 2:
        parts.append(0.0)
    if len(parts) not in (1, 3):
        raise ValueError(time)
    return sum(part * 60.0**place for place, part in enumerate(reversed(parts)))
