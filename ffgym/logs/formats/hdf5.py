"""HDF5 files, and the MATLAB 7.3 files that are made of it."""

import io
from typing import Any

import h5py
import numpy as np

from ffgym.logs.contents import NUMBERS, Contents
from ffgym.logs.formats.damage import one_error
from ffgym.logs.formats.matlab import OBJECT

_DEEPEST = 32
"""Levels of groups that are followed; links may lead back to where they come from."""


def read_hdf5(data: bytes, where: str) -> Contents:
    """Data sets of an HDF5 file by their paths, e.g. `arm/position`.

    Raises:
        FFGymError: if it is damaged.
    """
    arrays: dict[str, Any] = {}
    skipped: dict[str, str] = {}
    with one_error("an HDF5 file"), h5py.File(io.BytesIO(data), "r") as file:
        _collect_hdf5(file, "", arrays, skipped, _DEEPEST)
    return Contents(where=where, arrays=arrays, skipped=skipped)


def read_mat73(data: bytes, where: str) -> Contents:
    """Variables of a MATLAB 7.3 file, named as `read_mat` does: `log.q`, `run(2).q`, `cell{1}`.

    Axes are those that MATLAB shows; HDF5 stores them in reverse.

    Raises:
        FFGymError: if it is damaged.
    """
    arrays: dict[str, Any] = {}
    skipped: dict[str, str] = {}
    with one_error("a MATLAB file"), h5py.File(io.BytesIO(data), "r") as file:
        for name, item in file.items():
            if not name.startswith("#"):  # what references lead to, and objects
                _collect_mat(file, name, item, arrays, skipped, _DEEPEST)
    return Contents(where=where, arrays=arrays, skipped=skipped)


def _collect_hdf5(group: Any, prefix: str, arrays: dict[str, Any], skipped: dict[str, str], depth: int) -> None:
    for name, item in group.items():
        path = f"{prefix}{name}"
        if isinstance(item, h5py.Group) and depth > 0:
            _collect_hdf5(item, f"{path}/", arrays, skipped, depth - 1)
        elif isinstance(item, h5py.Dataset):
            if h5py.check_string_dtype(item.dtype) is not None:
                arrays[path] = np.array(item.asstr()[()], dtype=np.str_)
            elif item.dtype.kind in NUMBERS:
                arrays[path] = np.asarray(item[()])
            else:
                skipped[path] = f"HDF5 data of type {item.dtype}"


def _collect_mat(file: Any, name: str, item: Any, arrays: dict[str, Any], skipped: dict[str, str], depth: int) -> None:
    if "MATLAB_object_decode" in item.attrs or depth == 0:
        skipped[name] = OBJECT
    elif isinstance(item, h5py.Group):
        for field, entry in item.items():
            _collect_mat(file, f"{name}.{field}", entry, arrays, skipped, depth - 1)
    elif item.dtype == h5py.ref_dtype:
        _collect_references(file, name, item, arrays, skipped, depth)
    elif item.dtype.kind not in NUMBERS:
        skipped[name] = f"MATLAB data of type {item.dtype}"
    elif item.attrs.get("MATLAB_empty", 0):
        arrays[name] = np.zeros(0)
    else:
        values = np.squeeze(np.asarray(item[()]).T)
        text = item.attrs.get("MATLAB_class", b"") == b"char"
        arrays[name] = np.array("".join(map(chr, values.reshape(-1)))) if text else values


def _collect_references(
    file: Any, name: str, item: Any, arrays: dict[str, Any], skipped: dict[str, str], depth: int
) -> None:
    """Entries of a cell, or one field of all entries of an array of structures."""
    entries = item[()].T.reshape(-1, order="F")
    cell = item.attrs.get("MATLAB_class", b"") == b"cell"
    owner, _, field = name.rpartition(".")
    for i, reference in enumerate(entries, start=1):
        path = f"{name}{{{i}}}" if cell else f"{owner}({i}).{field}"
        if reference:
            _collect_mat(file, path, file[reference], arrays, skipped, depth - 1)
