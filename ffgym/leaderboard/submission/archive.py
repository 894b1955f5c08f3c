"""The ZIP file of a submission: flat, small, and read without trust in what it says of itself."""

import hashlib
import io
import os
import re
import stat
import zipfile
from collections.abc import Mapping
from pathlib import Path

from ffgym.core.errors import FFGymError
from ffgym.core.files import read_bytes
from ffgym.leaderboard.submission.refusal import Refused

LARGEST = 64 * 2**20
"""Bytes of a submission, unpacked, all files together; chosen: thousand times a residual policy of this package."""
MOST = 8
"""Files of a submission; it has three at most, and the rest is named when it is refused."""

_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,63}")
_DATE = (1980, 1, 1, 0, 0, 0)
_CHECK = "archive"


def read_archive(path: str | os.PathLike[str]) -> bytes:
    """Bytes of a submission's file; one that is too large, or no ordinary file, is not read.

    Raises:
        FFGymError: if there is no such file, or it cannot be read.
        Refused: if it is too large.
    """
    try:
        found = Path(path).stat()
    except FileNotFoundError:
        return read_bytes(path)  # which says so
    except OSError as error:
        raise FFGymError(f"{path}: cannot be read: {error.strerror}.") from error
    if not stat.S_ISREG(found.st_mode):
        raise FFGymError(f"{path}: is a folder or a device, must be a file.")
    _check_size(found.st_size)
    return read_bytes(path)


def sha256_of(data: bytes) -> str:
    """Hash of a file, hexadecimal."""
    return hashlib.sha256(data).hexdigest()


def encode_archive(files: Mapping[str, bytes]) -> bytes:
    """Bytes of a ZIP file; equal files in the same order give equal bytes."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            entry = zipfile.ZipInfo(name, date_time=_DATE)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3  # the same on every system
            entry.external_attr = (stat.S_IFREG | 0o644) << 16
            archive.writestr(entry, data)
    return buffer.getvalue()


def decode_archive(data: bytes) -> dict[str, bytes]:
    """Files of a ZIP file, by name.

    Raises:
        Refused: if it is damaged or too large, or holds anything but a few plain files beside each other.
    """
    _check_size(len(data))
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            entries = archive.infolist()
            _check_entries(entries)
            return {entry.filename: _content(archive, entry) for entry in entries}
    except Refused:
        raise
    except Exception as error:  # zipfile and zlib raise a dozen types for damaged bytes
        raise Refused(_CHECK, f"it is damaged or cut short, no ZIP file ({type(error).__name__}).") from error


def check_arrays(name: str, data: bytes) -> None:
    """Check that an NPZ file does not unpack to more than a submission may hold.

    Raises:
        Refused: if it does, or is damaged.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            size = sum(entry.file_size for entry in archive.infolist())
    except Exception as error:
        raise Refused(_CHECK, f"{name} is damaged, no NPZ file ({type(error).__name__}).") from error
    if size > LARGEST:
        raise Refused(_CHECK, f"{name} would unpack to {size} bytes, more than {LARGEST}.")


def _check_size(size: int) -> None:
    if size > LARGEST:
        raise Refused(_CHECK, f"it has {size} bytes, must have at most {LARGEST}.")


def _check_entries(entries: list[zipfile.ZipInfo]) -> None:
    if len(entries) > MOST:
        raise Refused(_CHECK, f"it holds {len(entries)} files, must hold at most {MOST}.")
    for entry in entries:
        name = entry.orig_filename
        if not _NAME.fullmatch(name):
            raise Refused(_CHECK, f"the name {name!r} is no plain file name; files must stand beside each other.")
        kind = stat.S_IFMT(entry.external_attr >> 16)
        if kind not in (0, stat.S_IFREG):
            raise Refused(_CHECK, f"{name} is a link or no ordinary file.")
        if entry.flag_bits & 1:
            raise Refused(_CHECK, f"{name} has a password.")
        if entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise Refused(_CHECK, f"{name} is compressed in an unusual way; use deflate.")
    names = [entry.orig_filename.lower() for entry in entries]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise Refused(_CHECK, f"it holds {', '.join(twice)} more than once.")
    size = sum(entry.file_size for entry in entries)
    if size > LARGEST:
        raise Refused(_CHECK, f"it would unpack to {size} bytes, must be at most {LARGEST}.")


def _content(archive: zipfile.ZipFile, entry: zipfile.ZipInfo) -> bytes:
    """Content of a file, no more than its entry says."""
    with archive.open(entry) as file:
        data = file.read(entry.file_size + 1)
    if len(data) != entry.file_size:
        raise Refused(_CHECK, f"{entry.filename} is not of the size that is told.")
    return data
