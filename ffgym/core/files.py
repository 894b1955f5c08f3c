"""Files and folders that appear whole or not at all, and readers that explain their errors."""

import io
import json
import math
import os
import shutil
import stat
import warnings
import zipfile
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from ffgym.core.claims import claimed, claimed_place, piece_of_work
from ffgym.core.errors import FFGymError
from ffgym.core.temporaries import temporary_file, temporary_folder
from ffgym.core.types import Array

_NO_NAME = "{name!r} is no name of a file: {error}."
"""Message about a name that holds a null character."""


def check_writable(path: str | os.PathLike[str]) -> None:
    """Check that `path` can be written; for use before long work."""
    target = Path(path)
    folder = target.absolute().parent
    try:
        if target.is_dir():
            raise FFGymError(f"{path}: is a folder, must be a file.")
        _check_replaceable(path)
        if not folder.is_dir():
            raise FFGymError(f"{path}: the folder {folder} does not exist; create it, or choose another place.")
        with suppress(FileNotFoundError):
            target.stat()  # a link that leads to itself is not there for pathlib, and cannot be written
        for place in (folder, target):
            if place.exists() and not os.access(place, os.W_OK):
                raise FFGymError(f"{path}: {place} is not writable; choose another place, or allow writing.")
    except OSError as error:  # of a name that is too long, a link to itself, or a folder that may not be entered
        raise FFGymError(f"{path}: cannot be written: {error.strerror}; choose another name or place.") from error


def write_bytes(path: str | os.PathLike[str], data: bytes) -> None:
    """Write `data` beside `path` and move it there; whatever fails or interrupts this, the old file or none is left."""
    with replaced_file(path) as temporary, open(temporary, "wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())


@contextmanager
def replaced_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield an empty file, which is at `path` when the block ends without an error, and nowhere otherwise.

    Raises:
        FFGymError: if the file cannot be written.
    """
    _check_replaceable(path)
    target = Path(os.path.realpath(path))  # through a link, as an ordinary write does
    try:
        with temporary_file(target.parent) as temporary:
            yield temporary
            if target.exists():
                shutil.copymode(target, temporary)
            os.replace(temporary, target)
    except OSError as error:
        raise FFGymError(
            f"{path}: cannot be written: {error.strerror}. The folder must exist, be writable and have space left."
        ) from error


def check_ordinary(path: str | os.PathLike[str]) -> None:
    """Check that no pipe, device or socket stands in the place of a file: reading it might never end.

    Raises:
        FFGymError: if it does. A path that leads nowhere passes, as reading says what is wrong.
    """
    if _is_special(path):
        raise FFGymError(f"{path}: is a pipe or a device, must be a file. Write what it gives to a file first.")


def _check_replaceable(path: str | os.PathLike[str]) -> None:
    """Check that no pipe, device or socket stands where a file is to be, which would take its place."""
    if _is_special(path):
        raise FFGymError(f"{path}: is a pipe or a device, must be a file; choose another name.")


def _is_special(path: str | os.PathLike[str]) -> bool:
    """Tell if there is something that is neither file nor folder."""
    try:
        mode = os.stat(path).st_mode
    except (OSError, ValueError):  # ValueError: a name that holds a null character
        return False
    return not (stat.S_ISREG(mode) or stat.S_ISDIR(mode))


def check_there(path: str | os.PathLike[str]) -> None:
    """Check that a file or folder of this name is there, whatever its name says of its format.

    Raises:
        FFGymError: if there is neither.
    """
    if not os.path.lexists(path):
        raise FFGymError(f"{path}: no such file or folder. Check the path; it is relative to {Path.cwd()}.")


def is_file(path: str | os.PathLike[str]) -> bool:
    """Tell if there is a file; a name that is too long, or leads to itself, is that of none."""
    try:
        return Path(path).is_file()
    except (OSError, ValueError):
        return False


def read_bytes(path: str | os.PathLike[str]) -> bytes:
    """Read the bytes of a file, which must exist and not be empty."""
    place = Path(path)
    check_ordinary(place)
    try:
        data = place.read_bytes()
    except FileNotFoundError as error:
        raise FFGymError(f"{place}: no such file. Check the path; it is relative to {Path.cwd()}.") from error
    except IsADirectoryError as error:
        raise FFGymError(f"{place}: is a folder, must be a file. Name a recording in it.") from error
    except OSError as error:
        raise FFGymError(f"{place}: cannot be read: {error.strerror}.") from error
    except ValueError as error:
        raise FFGymError(_NO_NAME.format(name=str(path), error=error)) from error
    if not data:
        raise FFGymError(f"{place}: the file is empty. Copy or record it again.")
    return data


def read_text(path: str | os.PathLike[str]) -> str:
    """Read a UTF-8 file, without byte order mark."""
    check_ordinary(path)
    try:
        return Path(path).read_text(encoding="utf-8-sig")
    except OSError as error:
        raise FFGymError(f"{path}: cannot be read: {error.strerror}.") from error
    except UnicodeDecodeError as error:
        raise FFGymError(
            f"{path}: is not UTF-8 text: byte {error.start} is {error.object[error.start]:#04x}."
        ) from error
    except ValueError as error:
        raise FFGymError(_NO_NAME.format(name=str(path), error=error)) from error


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write a UTF-8 file, as `write_bytes`."""
    try:
        data = text.encode("utf-8")
    except UnicodeEncodeError as error:  # of the name of a file, which may be any bytes
        raise FFGymError(
            f"{path}: cannot be written as UTF-8, because of {error.object[error.start : error.end]!r} in a name. "
            "Rename the file or folder that has it."
        ) from error
    write_bytes(path, data)


def check_vacant(path: str | os.PathLike[str]) -> None:
    """Check that `new_folder` can make `path`: it is free or an empty folder; for use before long work."""
    target = Path(os.path.realpath(path))
    try:
        is_there = target.exists()
        is_vacant = not is_there or (target.is_dir() and not any(target.iterdir()))
    except OSError as error:  # of a name that is too long, or a folder that may not be read
        raise FFGymError(f"{path}: cannot be read: {error.strerror}; choose another name or place.") from error
    if not is_vacant:
        raise FFGymError(f"{path}: exists already, and nothing is overwritten; choose another place, or remove it.")
    check_writable(target / "file" if is_there else target)


@contextmanager
def new_folder(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a folder to write into, which is at `path` when the block ends without an error, and nowhere otherwise.

    Raises:
        FFGymError: if something is at `path` that is no empty folder, or the folder cannot be written.
    """
    check_vacant(path)
    target = Path(os.path.realpath(path))
    with claimed_place(path):
        check_vacant(path)  # again: another process may have made it before the claim
        try:
            with temporary_folder(target.parent) as temporary:
                yield temporary
                if target.exists():
                    target.rmdir()  # it is empty
                temporary.rename(target)
        except FFGymError as error:  # of a file in the folder: tell its name as the user knows it
            raise FFGymError(str(error).replace(str(temporary), str(path))) from error
        except OSError as error:
            raise FFGymError(f"{path}: cannot be written: {error.strerror}. There must be space left.") from error


@contextmanager
def made_folder(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a folder, made if it is absent; after an error, folders that were made and are empty are removed."""
    target = Path(path)
    missing: list[Path] = []
    try:
        try:
            missing = [folder for folder in (target, *target.parents) if not folder.exists()]
            target.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FFGymError(f"{path}: cannot be made a folder: {error.strerror}; choose another place.") from error
        yield target
    except BaseException:
        for folder in missing:
            with suppress(OSError):  # it holds something, or was not made
                folder.rmdir()
        raise


@contextmanager
def filled_folder(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a folder as `made_folder`, which no other process fills meanwhile.

    Raises:
        FFGymError: if it cannot be made or written, or another process fills it.
    """
    with made_folder(path) as folder, claimed(folder), piece_of_work():  # claims in it end before it may be removed
        yield folder


def csv_rows(values: Array) -> str:
    """Format rows of `values` (R, C) as lines of CSV; numbers have the fewest digits that give back every bit."""
    return "".join(",".join(map(repr, row.tolist())) + "\n" for row in values)


def write_json(path: str | os.PathLike[str], value: Any) -> None:
    """Write a JSON file, as `write_bytes`; NaN and infinity have no JSON form."""
    try:
        text = json.dumps(value, indent=1, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise FFGymError(f"{path}: the result has no JSON form: {error}.") from error
    write_text(path, text + "\n")


def encode_arrays(arrays: Mapping[str, Any]) -> bytes:
    """Encode arrays as the bytes of an NPZ file; equal arrays in the same order give equal bytes."""
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, **dict(arrays))
    return buffer.getvalue()


def decode_arrays(data: bytes) -> dict[str, Any]:
    """Decode the bytes of an NPZ file, which must be whole, hold arrays alone, and no name twice.

    Raises:
        FFGymError: if it is not, or would unpack to more than `check_unpacked` allows.
    """
    return _decode_archive(io.BytesIO(data), len(data), None)


def read_arrays(path: str | os.PathLike[str], names: Collection[str]) -> dict[str, Any]:
    """Read arrays of an NPZ file by name, and nothing else of it.

    Raises:
        FFGymError: as `decode_arrays`, or if one of them is not there.
    """
    check_ordinary(path)
    try:
        with open(path, "rb") as stream:
            arrays = _decode_archive(stream, os.fstat(stream.fileno()).st_size, names)
    except OSError as error:
        raise FFGymError(f"{path}: cannot be read: {error.strerror}.") from error
    if missing := [name for name in names if name not in arrays]:
        raise FFGymError(f"The file has no {', '.join(missing)}. Copy or make it again.")
    return arrays


def _decode_archive(stream: BinaryIO, size: int, names: Collection[str] | None) -> dict[str, Any]:
    """Decode arrays of an NPZ file of some bytes: those of `names`, or all."""
    try:
        with zipfile.ZipFile(stream) as archive:
            entries = [(entry.filename.removesuffix(".npy"), entry) for entry in archive.infolist()]
            chosen = [(name, entry) for name, entry in entries if names is None or name in names]
            check_unpacked("The NPZ file", size, sum(entry.file_size for _, entry in chosen))
            arrays = {name: _decode_array(archive.read(entry)) for name, entry in chosen}
    except FFGymError:
        raise
    except Exception as error:  # zipfile, zlib and numpy raise a dozen types for damaged bytes
        kind = type(error).__name__  # and not its text: numpy's advises to load what may run as a program
        raise FFGymError(
            f"Damaged, cut short, not NPZ, or with a password or Python objects in it ({kind}). Copy or make it again."
        ) from error
    if len(arrays) < len(chosen):
        twice = sorted(name for name, count in Counter(name for name, _ in chosen).items() if count > 1)
        raise FFGymError(f"The NPZ file holds {', '.join(twice)} more than once. Keep one entry of each name.")
    for name, array in arrays.items():
        if array is None:
            raise FFGymError(f"The NPZ entry {name!r} is not an array. Remove it, or make the file again.")
    return arrays


def _decode_array(data: bytes) -> NDArray[Any] | None:
    """Decode an entry of an NPZ file; None if it is no array.

    Raises:
        ValueError: if it is damaged, holds Python objects, or its head promises more numbers than it has.
    """
    form = np.lib.format
    if not data.startswith(form.MAGIC_PREFIX):
        return None
    stream = io.BytesIO(data)
    heads = {(1, 0): form.read_array_header_1_0, (2, 0): form.read_array_header_2_0}
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # of numbers in a damaged head that overflow
        shape, _, kind = heads[form.read_magic(stream)](stream)
    fits = kind.itemsize * math.prod(shape) <= len(data) and all(0 <= length <= len(data) for length in shape)
    if kind.hasobject or not fits:
        raise ValueError("Python objects, or fewer numbers than its head says")
    stream.seek(0)
    array: NDArray[Any] = form.read_array(stream, allow_pickle=False)
    return array


LARGEST_UNPACKED = 2**29
"""Bytes to which any packed file may unpack, 512 MiB; chosen: an hour of 16 columns at 1 kHz, five times smaller than
the memory of a small computer."""
USUAL_PACKING = 20
"""Factor by which larger ones may grow; measurements with noise pack by less than 5."""


def most_unpacked(packed: int) -> int:
    """Bytes to which a file of `packed` bytes may unpack."""
    return max(LARGEST_UNPACKED, USUAL_PACKING * packed)


def check_unpacked(what: str, packed: int, unpacked: int) -> None:
    """Check that a packed file of a few kilobytes does not fill the memory; for use before it is unpacked.

    Args:
        what: the file, for the message.
        packed: its size [byte].
        unpacked: the size of its contents [byte], as its head says.

    Raises:
        FFGymError: if they are larger than `most_unpacked`.
    """
    most = most_unpacked(packed)
    if unpacked > most:
        raise FFGymError(
            f"{what} has {packed} bytes and would unpack to {unpacked} or more, must be at most {most}: "
            f"{LARGEST_UNPACKED}, or {USUAL_PACKING} times its size. Cut it into shorter ones, or write it unpacked."
        )
