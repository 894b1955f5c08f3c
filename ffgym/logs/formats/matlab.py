"""MATLAB files, version 5 to 7 (SciPy) and 7.3 (HDF5): arrays, and fields of structures by their paths."""

import io
from typing import Any, cast

import numpy as np
from scipy.io import loadmat
from scipy.sparse import issparse

from ffgym.core.errors import FFGymError
from ffgym.logs.contents import NUMBERS, TEXT, Contents
from ffgym.logs.formats.damage import one_error
from ffgym.logs.formats.matlab_tags import check_mat5

HDF5_MAGIC = b"\x89HDF\r\n\x1a\n"
"""First bytes of HDF5; a MATLAB file 7.3 has them after 512 bytes of its own."""

_USER_BLOCK = 512

OBJECT = "a MATLAB object (table, timeseries, string ...); in MATLAB, save its numbers as arrays, e.g. x = ts.Data"
"""Why a variable is skipped."""


def read_mat(data: bytes, where: str) -> Contents:
    """Arrays of a MATLAB file, without axes of length 1; structures become names like `log.q` and `run(2).q`.

    Raises:
        FFGymError: if it is damaged, or of version 4.
    """
    if data.startswith(HDF5_MAGIC) or data[_USER_BLOCK:].startswith(HDF5_MAGIC):
        from ffgym.logs.formats.optional import read_mat73

        return read_mat73(data, where)
    check_mat5(data)
    with one_error("a MATLAB file"):
        variables = loadmat(cast("Any", io.BytesIO(data)), squeeze_me=True, spmatrix=False)
    arrays: dict[str, Any] = {}
    skipped: dict[str, str] = {}
    for name, value in variables.items():
        if not name.startswith("__"):
            _flatten(name, value, arrays, skipped)
    if not arrays and not skipped:
        raise FFGymError("The MATLAB file holds no variables. Save it again, with save -v7 or -v7.3.")
    return Contents(where=where, arrays=arrays, skipped=skipped)


def _flatten(name: str, value: Any, arrays: dict[str, Any], skipped: dict[str, str]) -> None:
    """Put arrays under their paths: fields of structures, entries of cells and of arrays of structures."""
    if issparse(value):
        skipped[name] = f"a sparse matrix; in MATLAB, save full({name})"
        return
    array = np.asarray(value)
    if array.dtype.names is not None and not type(value).__name__.startswith("Matlab"):
        if array.ndim == 0:
            for field in array.dtype.names:
                _flatten(f"{name}.{field}", array[field][()], arrays, skipped)
        else:
            for i, entry in enumerate(array.reshape(-1, order="F"), start=1):
                _flatten(f"{name}({i})", entry, arrays, skipped)
    elif array.dtype.kind == "O" and type(value) is np.ndarray:
        for i, entry in enumerate(array.reshape(-1, order="F"), start=1):
            _flatten(f"{name}{{{i}}}", entry, arrays, skipped)
    elif array.dtype.kind in NUMBERS + TEXT + "c":
        arrays[name] = array
    else:
        skipped[name] = OBJECT
