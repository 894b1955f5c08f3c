"""MATLAB files, version 5 to 7 (SciPy) and 7.3 (HDF5): arrays, and fields of structures by their paths.

SciPy may crash on bytes that do not have the structure of a MATLAB 5 file, so that this is checked first.
"""

import io
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import util
from math import prod
from typing import Any, NamedTuple, cast

import numpy as np
import scipy
from scipy.io import loadmat

from ffgym.core.errors import FFGymError
from ffgym.core.files import check_unpacked, most_unpacked
from ffgym.logs.contents import NUMBERS, TEXT, Contents
from ffgym.logs.formats.hdf5 import OBJECT, read_mat73
from ffgym.logs.log_format import LogFormat

HDF5_MAGIC = b"\x89HDF\r\n\x1a\n"
"""First bytes of HDF5; a MATLAB file 7.3 has them after 512 bytes of its own."""

_USER_BLOCK = 512

_HEADER, _ENDIAN = 128, {b"IM": "<", b"MI": ">"}
"""Bytes of text and version before the first element of a file of version 5; its last two say the order of bytes."""

_TAG, _SMALL = 8, 4
"""Bytes of a tag: type and size, 32 bits each; and most bytes of an element that stands within its own tag."""

_NUMBERS = frozenset({1, 2, 3, 4, 5, 6, 7, 9, 12, 13, 16, 17, 18})
"""Types of elements that hold numbers or text: miINT8 ... miUTF32."""

_ARRAY, _COMPRESSED, _UINT32, _INT32 = 14, 15, 6, 5
"""Types of elements: arrays, what is compressed; flags of an array, and its dimensions in the words of some writers."""

_CELL, _STRUCTURE, _OBJECT, _TEXT, _SPARSE, _NUMERIC, _UNREAD = 1, 2, 3, 4, 5, range(6, 16), (16, 17)
"""Classes of arrays; functions and what is opaque are not read."""

_COMPLEX = 8
"""Flag of an array with an imaginary part."""

_PLAIN = {_CELL: 3, _STRUCTURE: 5, _OBJECT: 6, _TEXT: 4, _SPARSE: 6} | dict.fromkeys(_NUMERIC, 4)
"""Elements of numbers or text that an array begins with, by class: flags, dimensions, name, and so on."""

_DEEPEST = 64
"""Levels of structures in structures."""


class Matlab(LogFormat):
    """Arrays without axes of length 1; structures become names like `log.q` and `run(2).q`, cells `c{1}`."""

    title = "a MATLAB file"
    suffixes = (".mat",)

    def decode(self, data: bytes, where: str) -> Contents:
        """Read the numeric variables of a MAT file."""
        if data.startswith(HDF5_MAGIC) or data[_USER_BLOCK:].startswith(HDF5_MAGIC):
            if util.find_spec("h5py") is None:
                raise FFGymError("Reading MATLAB files of version 7.3 needs h5py; pip install 'ffgym[logs]'.")
            return read_mat73(data, where)
        _check_mat5(data)
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
    if scipy.sparse.issparse(value):
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


def _check_mat5(data: bytes) -> None:
    """Check that tags are valid, and that every element lies within the one that holds it.

    Reference:
        MathWorks, MAT-File Format, version 5.
    """
    order = _ENDIAN.get(data[_HEADER - 2 : _HEADER])
    if order is None:
        raise FFGymError("Not a MATLAB file of version 5 or later, or cut short. In MATLAB, use save -v7 or -v7.3.")
    file, total = _Bytes(data, order), 0
    for element in file.elements(_HEADER, len(data), aligned=False):
        if element.kind != _COMPRESSED:
            file.check(element, _DEEPEST)
            continue
        try:
            packed = zlib.decompressobj()
            unpacked = packed.decompress(data[element.start : element.end], most_unpacked(len(data)) + 1)
            total += len(unpacked)
            check_unpacked("The file", len(data), total)
            if not packed.eof:
                raise zlib.error("its end is missing")
        except zlib.error as error:
            raise FFGymError(f"Damaged: the variable at byte {element.start} cannot be decompressed.") from error
        inner = _Bytes(unpacked, order)
        for found in inner.elements(0, len(inner.data), aligned=False):
            inner.check(found, _DEEPEST)


class _Element(NamedTuple):
    """Type, first byte and end of an element."""

    kind: int
    start: int
    end: int


@dataclass(frozen=True)
class _Bytes:
    """Elements of a MATLAB 5 file, or of a part of it that was compressed."""

    data: bytes
    order: str

    def elements(self, start: int, end: int, *, aligned: bool) -> Iterator[_Element]:
        """Elements between two bytes; those within an array start at multiples of a tag."""
        while start < end:
            if start + _TAG > end:
                raise FFGymError(f"Damaged or cut short: there is no whole element at byte {start}.")
            kind, size = self.integers(start, start + _TAG, "u4")
            first = start + _TAG
            if kind >> 16:  # type and size share the first half, numbers are in the second
                kind, size, first = kind & 0xFFFF, kind >> 16, start + _TAG // 2
                if size > _SMALL:
                    raise FFGymError(f"Damaged: the element at byte {start} has {size} bytes, of at most {_SMALL}.")
                start += _TAG
            else:
                start = first + (-(-size // _TAG) * _TAG if aligned else size)
            if first + size > end:
                left = end - first
                raise FFGymError(f"Damaged or cut short: the element at byte {first} has {size} bytes, {left} left.")
            yield _Element(kind, first, first + size)

    def integers(self, start: int, end: int, kind: str = "i4") -> list[int]:
        """Whole numbers between two bytes."""
        return np.frombuffer(self.data, f"{self.order}{kind}", (end - start) // 4, start).tolist()

    def check(self, element: _Element, depth: int) -> None:
        """Check one element, those in it, and that an array has those that its class calls for."""
        if element.kind in _NUMBERS:
            return
        if element.kind != _ARRAY or depth == 0:
            raise FFGymError(
                f"Damaged: the element at byte {element.start} is of type {element.kind}, which there is not."
            )
        inner = [*self.elements(element.start, element.end, aligned=True)]
        for found in inner:
            self.check(found, depth - 1)
        if not inner:  # an array may be empty altogether
            return
        start = inner[0].start
        if inner[0].kind != _UINT32 or inner[0].end - start < _TAG:
            raise FFGymError(f"Damaged: the array at byte {start} has no flags.")
        (flags,) = self.integers(start, start + 4)
        kind, is_complex = flags & 0xFF, bool(flags >> 8 & _COMPLEX)
        if kind in _UNREAD:
            return
        if kind not in _PLAIN:
            raise FFGymError(f"Damaged: the array at byte {start} is of class {kind}, which there is not.")
        plain = _PLAIN[kind] + (is_complex and (kind == _SPARSE or kind in _NUMERIC))
        wanted = [True] * plain + [False] * min(self._n_arrays(inner, kind), len(inner))
        if [e.kind in _NUMBERS for e in inner] != wanted or inner[1].kind not in (_INT32, _UINT32):
            raise FFGymError(
                f"Damaged: the array at byte {start} does not have the elements of an array of class {kind}."
            )

    def _n_arrays(self, inner: list[_Element], kind: int) -> int:
        """Arrays within an array: one per entry, and in structures and objects per field."""
        if kind not in (_CELL, _STRUCTURE, _OBJECT) or len(inner) < _PLAIN[kind]:
            return 0
        count = prod(max(size, 0) for size in self.integers(*inner[1][1:]))
        if kind == _CELL:
            return count
        length, names = inner[_PLAIN[kind] - 2], inner[_PLAIN[kind] - 1]
        (longest, *_) = self.integers(*length[1:]) or (0,)
        return count * ((names.end - names.start) // longest) if longest > 0 else 0
