"""Whether the bytes of a MATLAB 5 file have its structure: SciPy's reader may crash on those that do not."""

import struct
import zlib
from collections.abc import Iterator

from ffgym.core.errors import FFGymError

_HEADER = 128
"""Bytes of text and version before the first element."""

_ENDIAN = slice(126, 128)
_LITTLE, _BIG = b"IM", b"MI"

_TAG = 8
"""Bytes of a tag: type and size, 32 bits each; elements within an array start at multiples of it."""

_SMALL = 4
"""Most bytes of an element that stands within its own tag."""

_NUMBERS = frozenset({1, 2, 3, 4, 5, 6, 7, 9, 12, 13, 16, 17, 18})
"""Types of elements that hold numbers or text: miINT8 ... miUTF32."""

_ARRAY, _COMPRESSED = 14, 15

_UINT32, _INT32 = 6, 5
"""Types of the first two elements of an array: flags, and dimensions, for which some writers take the other."""

_CELL, _STRUCTURE, _OBJECT, _TEXT, _SPARSE = 1, 2, 3, 4, 5
_NUMERIC = range(6, 16)
_FUNCTION, _OPAQUE = 16, 17
"""Classes of arrays."""

_COMPLEX = 8
"""Flag of an array with an imaginary part."""

_PLAIN = {_CELL: 3, _STRUCTURE: 5, _OBJECT: 6, _TEXT: 4, _SPARSE: 6} | dict.fromkeys(_NUMERIC, 4)
"""Elements of numbers or text that an array begins with, by class: flags, dimensions, name, and so on."""

_DEEPEST = 64
"""Levels of structures in structures."""


def check_mat5(data: bytes) -> None:
    """Check that tags are valid, and that every element lies within the one that holds it.

    Raises:
        FFGymError: if not; the message says at which byte.

    Reference:
        MathWorks, MAT-File Format, version 5.
    """
    if len(data) < _HEADER or data[_ENDIAN] not in (_LITTLE, _BIG):
        raise FFGymError("Not a MATLAB file of version 5 or later, or cut short. In MATLAB, use save -v7 or -v7.3.")
    order = "<" if data[_ENDIAN] == _LITTLE else ">"
    for kind, start, end in _elements(data, _HEADER, len(data), order, aligned=False):
        if kind == _COMPRESSED:
            try:
                inner = zlib.decompress(data[start:end])
            except zlib.error as error:
                raise FFGymError(f"Damaged: the variable at byte {start} cannot be decompressed.") from error
            for found, first, last in _elements(inner, 0, len(inner), order, aligned=False):
                _check(inner, found, first, last, order, _DEEPEST)
        else:
            _check(data, kind, start, end, order, _DEEPEST)


def _elements(data: bytes, start: int, end: int, order: str, *, aligned: bool) -> Iterator[tuple[int, int, int]]:
    """Type, first byte and end of each element."""
    while start < end:
        if start + _TAG > end:
            raise FFGymError(f"Damaged or cut short: there is no whole element at byte {start}.")
        kind, size = struct.unpack(f"{order}II", data[start : start + _TAG])
        first = start + _TAG
        if kind >> 16:  # type and size share the first half, numbers are in the second
            kind, size, first = kind & 0xFFFF, kind >> 16, start + _TAG // 2
            if size > _SMALL:
                raise FFGymError(f"Damaged: the element at byte {start} has {size} bytes, of at most {_SMALL}.")
            start += _TAG
        else:
            start = first + (-(-size // _TAG) * _TAG if aligned else size)
        if first + size > end:
            raise FFGymError(f"Damaged or cut short: the element at byte {first} has {size} bytes, {end - first} left.")
        yield kind, first, first + size


def _check(data: bytes, kind: int, start: int, end: int, order: str, depth: int) -> None:
    """Check one element, and those in it."""
    if kind in _NUMBERS:
        return
    if kind != _ARRAY or depth == 0:
        raise FFGymError(f"Damaged: the element at byte {start} is of type {kind}, which there is not.")
    inner = list(_elements(data, start, end, order, aligned=True))
    for found, first, last in inner:
        _check(data, found, first, last, order, depth - 1)
    if inner:  # an array may be empty altogether
        _check_array(data, inner, order)


def _check_array(data: bytes, inner: list[tuple[int, int, int]], order: str) -> None:
    """Check that an array has the elements that its class calls for."""
    start = inner[0][1]
    if inner[0][0] != _UINT32 or inner[0][2] - start < _TAG:
        raise FFGymError(f"Damaged: the array at byte {start} has no flags.")
    (flags,) = struct.unpack(f"{order}I", data[start : start + 4])
    kind, is_complex = flags & 0xFF, bool(flags >> 8 & _COMPLEX)
    if kind in (_FUNCTION, _OPAQUE):
        return  # read by nobody
    if kind not in _PLAIN:
        raise FFGymError(f"Damaged: the array at byte {start} is of class {kind}, which there is not.")
    plain = _PLAIN[kind] + (is_complex and (kind == _SPARSE or kind in _NUMERIC))
    arrays = _n_arrays(data, inner, order, kind) if kind in (_CELL, _STRUCTURE, _OBJECT) else 0
    wanted = [True] * plain + [False] * arrays if plain + arrays <= len(inner) else []
    if inner[1][0] not in (_INT32, _UINT32) or [found in _NUMBERS for found, _, _ in inner] != wanted:
        raise FFGymError(f"Damaged: the array at byte {start} does not have the elements of an array of class {kind}.")


def _n_arrays(data: bytes, inner: list[tuple[int, int, int]], order: str, kind: int) -> int:
    """Arrays within an array: one per entry, and in structures and objects per field; never more than elements."""
    if len(inner) < _PLAIN[kind]:
        return 0
    count = 1
    for size in _integers(data, inner[1], order):
        count = min(count * max(size, 0), len(inner))
    if kind == _CELL:
        return count
    length, names = inner[_PLAIN[kind] - 2], inner[_PLAIN[kind] - 1]
    (longest,) = _integers(data, length, order) or (0,)
    return count * ((names[2] - names[1]) // longest) if longest > 0 else 0


def _integers(data: bytes, element: tuple[int, int, int], order: str) -> tuple[int, ...]:
    _, start, end = element
    count = (end - start) // 4
    return struct.unpack(f"{order}{count}i", data[start : start + 4 * count])
