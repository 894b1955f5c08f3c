"""Parquet files: columns of numbers, lists of one length as arrays (T, K), structures by their paths."""

from typing import Any

import lazy_loader
import numpy as np
from numpy.typing import NDArray

from ffgym.core.files import check_unpacked
from ffgym.logs.contents import Contents
from ffgym.logs.log_format import LogFormat

pa = lazy_loader.load("pyarrow")


class Parquet(LogFormat):
    """Columns; times of a calendar become whole numbers of nanoseconds since 1970."""

    title = "a Parquet file"
    suffixes = (".parquet",)
    packages = ("pyarrow",)
    extra = "ffgym[logs]"

    def decode(self, data: bytes, where: str) -> Contents:
        """Read the columns of a Parquet file."""
        return contents_of(read_table(data), where)


_ROWS = 4096
"""Rows that are read at a time."""


def read_table(data: bytes) -> Any:
    """Arrow table of a Parquet file."""
    from pyarrow.parquet import ParquetFile

    file = ParquetFile(pa.BufferReader(data))
    about = file.metadata
    check_unpacked("The file", len(data), sum(about.row_group(k).total_byte_size for k in range(about.num_row_groups)))
    # by some rows at a time, as a value that is written once may stand for many; what its columns say of themselves is
    # not asked for, as the library ends the process where that is damaged
    batches, size = [], 0
    for batch in file.iter_batches(_ROWS):
        size += batch.nbytes
        check_unpacked("The file", len(data), size)
        batches.append(batch)
    return pa.Table.from_batches(batches, file.schema_arrow)


def contents_of(table: Any, where: str) -> Contents:
    """Columns of an Arrow table."""
    while any(pa.types.is_struct(field.type) for field in table.schema):
        table = table.flatten()  # names of fields follow a dot
    arrays: dict[str, NDArray[Any]] = {}
    skipped: dict[str, str] = {}
    for name, column in zip(table.column_names, table.columns, strict=True):
        array = _array(column.combine_chunks())
        if array is None:
            skipped[name] = f"a Parquet column of type {column.type}, or of lists of different lengths"
        else:
            arrays[name] = array
    return Contents(where=where, arrays=arrays, skipped=skipped)


def _array(column: Any) -> NDArray[Any] | None:
    """Column as an array, None if it has no such form; an absent number is NaN."""
    kind = column.type
    if isinstance(column, pa.ChunkedArray):
        column = pa.concat_arrays(column.chunks) if column.num_chunks else pa.array([], type=kind)
    if pa.types.is_dictionary(kind):
        return _array(column.dictionary_decode())
    if pa.types.is_fixed_size_list(kind) or pa.types.is_list(kind) or pa.types.is_large_list(kind):
        # lists of one length are rows, lists of lists further axes
        lengths = set() if column.null_count else {len(row) for row in column}
        inner = _array(column.flatten()) if len(lengths) == 1 else None
        return None if inner is None else inner.reshape(len(column), lengths.pop(), *inner.shape[1:])
    if pa.types.is_timestamp(kind) or pa.types.is_duration(kind):
        if column.null_count:
            return None
        whole = pa.timestamp("ns") if pa.types.is_timestamp(kind) else pa.duration("ns")
        return np.asarray(column.cast(whole).cast(pa.int64()))
    if pa.types.is_decimal(kind):
        column, kind = column.cast(pa.float64()), pa.float64()
    if pa.types.is_boolean(kind) or pa.types.is_integer(kind) or pa.types.is_floating(kind):
        return np.asarray(column.to_numpy(zero_copy_only=False))
    if pa.types.is_string(kind) or pa.types.is_large_string(kind):
        return np.array(["" if cell is None else cell for cell in column.to_pylist()], dtype=np.str_)
    return None
