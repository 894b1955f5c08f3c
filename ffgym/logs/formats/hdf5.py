"""HDF5 files, and the MATLAB 7.3 files that are made of it."""

import io
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import lazy_loader
import numpy as np

from ffgym.core.files import check_unpacked
from ffgym.logs.contents import NUMBERS, Contents
from ffgym.logs.log_format import LogFormat

h5py = lazy_loader.load("h5py")

OBJECT = "a MATLAB object (table, timeseries, string ...); in MATLAB, save its numbers as arrays, e.g. x = ts.Data"
"""Why a variable is skipped."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Found:
    """Arrays and notes that a walk through a file collects."""

    size: int
    """Size of the file [byte]."""
    arrays: dict[str, Any] = field(default_factory=dict)
    skipped: dict[str, str] = field(default_factory=dict)
    seen: set[int] = field(default_factory=set)
    """Addresses of groups, since links may lead back to where they come from."""

    def read(self, item: Any) -> Any:
        """Numbers or text of a data set, unless all that were read unpack to too much."""
        check_unpacked("The file", self.size, sum(array.nbytes for array in self.arrays.values()) + item.nbytes)
        return item[()]

    def entries(self, group: Any) -> Iterator[tuple[str, Any]]:
        """Entries of a group that was not seen before."""
        address = h5py.h5o.get_info(group.id).addr
        if address not in self.seen:
            self.seen.add(address)
            yield from group.items()


class Hdf5(LogFormat):
    """Data sets of numbers by their paths, e.g. `arm/position`."""

    title = "an HDF5 file"
    suffixes = (".h5", ".hdf5")
    packages = ("h5py",)
    extra = "ffgym[logs]"

    def decode(self, data: bytes, where: str) -> Contents:
        """Read all numeric data sets of an HDF5 file, named by their paths."""
        found = _Found(size=len(data))
        with h5py.File(io.BytesIO(data), "r") as file:
            _collect_hdf5(file, "", found)
        return Contents(where=where, arrays=found.arrays, skipped=found.skipped)


def read_mat73(data: bytes, where: str) -> Contents:
    """Variables of a MATLAB 7.3 file: `log.q`, `run(2).q`, `cell{1}`; HDF5 stores their axes in reverse."""
    found = _Found(size=len(data))
    with h5py.File(io.BytesIO(data), "r") as file:
        for name, item in found.entries(file):
            if not name.startswith("#"):  # what references lead to, and objects
                _collect_mat(file, name, item, found)
    return Contents(where=where, arrays=found.arrays, skipped=found.skipped)


def _collect_hdf5(group: Any, prefix: str, found: _Found) -> None:
    for name, item in found.entries(group):
        path = f"{prefix}{name}"
        if isinstance(item, h5py.Group):
            _collect_hdf5(item, f"{path}/", found)
        elif not isinstance(item, h5py.Dataset):
            found.skipped[path] = "an HDF5 data type"
        elif item.dtype.kind in NUMBERS:
            found.arrays[path] = np.asarray(found.read(item))
        elif item.dtype.kind == "S":
            found.arrays[path] = np.char.decode(np.asarray(found.read(item)), "utf-8", "replace")
        else:  # among others text of variable length, in which the library may get lost for ever where it is damaged
            found.skipped[path] = f"HDF5 data of type {item.dtype}"


def _collect_mat(file: Any, name: str, item: Any, found: _Found) -> None:
    if "MATLAB_object_decode" in item.attrs:
        found.skipped[name] = OBJECT
    elif isinstance(item, h5py.Group):
        for field_name, entry in found.entries(item):
            _collect_mat(file, f"{name}.{field_name}", entry, found)
    elif item.dtype == h5py.ref_dtype:
        _collect_references(file, name, item, found)
    elif item.dtype.kind not in NUMBERS:
        found.skipped[name] = f"MATLAB data of type {item.dtype}"
    elif item.attrs.get("MATLAB_empty", 0):
        found.arrays[name] = np.zeros(0)
    else:
        values = np.squeeze(np.asarray(found.read(item)).T)
        text = item.attrs.get("MATLAB_class", b"") == b"char"
        found.arrays[name] = np.array("".join(map(chr, values.reshape(-1)))) if text else values


def _collect_references(file: Any, name: str, item: Any, found: _Found) -> None:
    """Entries of a cell, or one field of all entries of an array of structures."""
    address = h5py.h5o.get_info(item.id).addr
    if address in found.seen:
        return
    found.seen.add(address)
    cell = item.attrs.get("MATLAB_class", b"") == b"cell"
    owner, _, field_name = name.rpartition(".")
    for i, reference in enumerate(found.read(item).T.reshape(-1, order="F"), start=1):
        path = f"{name}{{{i}}}" if cell else f"{owner}({i}).{field_name}"
        if reference:
            _collect_mat(file, path, file[reference], found)
