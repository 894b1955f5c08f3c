"""Files of other tools as arrays: the suffix, or what a folder holds, chooses the reader."""

import gzip
import os
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType

from ffgym.core.errors import FFGymError
from ffgym.core.files import read_bytes
from ffgym.logs.contents import Contents
from ffgym.logs.formats.json_table import read_json
from ffgym.logs.formats.matlab import read_mat
from ffgym.logs.formats.npz import read_npz
from ffgym.logs.formats.optional import read_bag, read_hdf5, read_lerobot, read_parquet
from ffgym.logs.formats.text import read_text_table
from ffgym.logs.formats.text_layout import TextLayout

TEXT_FILES = (".csv", ".tsv", ".txt", ".dat", ".asc")
"""Suffixes of tables in text."""

PACKED = ".gz"
"""Suffix after that of a table in text, where gzip packed it."""

FILES: Mapping[str, Callable[[bytes, str], Contents]] = MappingProxyType(
    {
        ".npz": read_npz,
        ".json": read_json,
        ".jsonl": read_json,
        ".mat": read_mat,
        ".h5": read_hdf5,
        ".hdf5": read_hdf5,
        ".parquet": read_parquet,
    }
)
"""What reads the bytes of a file, by suffix."""

BAGS = (".mcap", ".db3", ".bag")
"""Suffixes of files that are read piece by piece."""

FOLDERS: Mapping[str, Callable[[Path], Contents]] = MappingProxyType(
    {"metadata.yaml": read_bag, "meta/info.json": read_lerobot}
)
"""What reads a folder, by the file that tells its kind."""


def read_contents(path: str | os.PathLike[str], layout: TextLayout | None = None) -> Contents:
    """Arrays in a file or folder of another tool.

    Args:
        path: where it is.
        layout: of a text file, as far as it cannot be seen.

    Raises:
        FFGymError: if the kind of file is unknown, or it cannot be read; the message begins with the path.
    """
    place = Path(path)
    try:
        return _read(place, layout)
    except FFGymError as error:
        raise error if str(error).startswith(f"{place}: ") else FFGymError(f"{place}: {error}") from error


def _read(place: Path, layout: TextLayout | None) -> Contents:
    packed = place.suffix.lower() == PACKED
    suffix = (Path(place.stem) if packed else place).suffix.lower()
    if place.is_dir():
        return _read_folder(place)
    if suffix in (*FILES, *BAGS) and layout is not None and layout != TextLayout():
        raise FFGymError(f"[file] is about text files ({', '.join(TEXT_FILES)}); leave it out.")
    if suffix in TEXT_FILES:
        data = _unpacked(read_bytes(place)) if packed else read_bytes(place)
        return read_text_table(data, str(place), layout or TextLayout())
    if packed:
        raise FFGymError(f"only tables in text ({', '.join(TEXT_FILES)}) are read packed; unpack it first.")
    if suffix in FILES:
        return FILES[suffix](read_bytes(place), str(place))
    if suffix in BAGS:
        _check_file(place)
        return read_bag(place)
    raise FFGymError(f"suffix {suffix!r} is unknown, must be one of {', '.join((*TEXT_FILES, *FILES, *BAGS))}.")


def bare_name(path: str | os.PathLike[str]) -> str:
    """Name of a file without its suffix, and without that of a packed table: `run.csv.gz` is `run`."""
    place = Path(path)
    return Path(place.stem).stem if place.suffix.lower() == PACKED else place.stem


def _unpacked(data: bytes) -> bytes:
    """Bytes of a gzip file."""
    try:
        return gzip.decompress(data)
    except (OSError, EOFError, zlib.error) as error:
        raise FFGymError(f"is no whole gzip file: {error}. Copy it again.") from error


def _read_folder(place: Path) -> Contents:
    for file, read in FOLDERS.items():
        if (place / file).is_file():
            return read(place)
    raise FFGymError(f"the folder has no {' or '.join(FOLDERS)}: neither a rosbag nor a LeRobot data set.")


def _check_file(place: Path) -> None:
    try:
        size = place.stat().st_size
    except OSError as error:
        raise FFGymError(
            f"cannot be read: {error.strerror}. Check the path; it is relative to {Path.cwd()}."
        ) from error
    if not size:
        raise FFGymError("the file is empty. Copy or record it again.")
