"""A format of logs, declared once: what its files look like, what reads them, which packages that takes.

Formats are found by their classes: those of the files in `ffgym.logs.formats`, and those that other packages name as
entry points of the group "ffgym.log_formats" (docs/extending.md).
"""

import os
from abc import ABC
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import util
from pathlib import Path
from typing import ClassVar

from ffgym.core.errors import FFGymError, errors_at
from ffgym.core.files import read_bytes
from ffgym.core.plugins import load_families
from ffgym.logs.contents import Contents
from ffgym.logs.text_layout import TextLayout

PACKED = ".gz"
"""Suffix after that of a table in text, where gzip packed it."""


class LogFormat(ABC):
    """A kind of file or folder. To add one, inherit and override `decode`, or `read` for what is no whole file."""

    title: ClassVar[str]
    """The kind with its article, for messages, e.g. 'a Parquet file'."""
    suffixes: ClassVar[tuple[str, ...]] = ()
    """Suffixes of its files, in small letters, e.g. '.parquet'."""
    folder: ClassVar[str] = ""
    """File that makes a folder one of this kind, e.g. 'meta/info.json'."""
    packages: ClassVar[tuple[str, ...]] = ()
    """Packages that reading imports, beside those that ffgym needs anyway."""
    extra: ClassVar[str] = ""
    """Packages for pip to install where they are missing; empty is `packages`."""
    is_text: ClassVar[bool] = False
    """True if the table [file] of a column map says how it is laid out."""

    def __init_subclass__(cls) -> None:
        _KINDS.append(cls)

    def recognises(self, path: Path) -> bool:
        """Tell whether a file or folder is of this kind."""
        if path.is_dir():
            return bool(self.folder) and (path / self.folder).is_file()
        return path.suffix.lower() in self.suffixes

    def read(self, path: Path, layout: TextLayout) -> Contents:
        """Arrays of a file or folder; whatever is raised here becomes one FFGymError that begins with the path."""
        return self.decode(read_bytes(path), str(path))

    def decode(self, data: bytes, where: str) -> Contents:
        """Arrays in the bytes of a file, which messages call `where`."""
        raise NotImplementedError(f"{type(self).__name__} overrides neither read nor decode")


_KINDS: list[type[LogFormat]] = []


def log_formats() -> list[LogFormat]:
    """All formats in the order of their declaration; of two that recognise a file the later one reads it."""
    load_families("ffgym.log_formats", "ffgym.logs.formats")
    return [kind() for kind in _KINDS]


def read_contents(path: str | os.PathLike[str], layout: TextLayout | None = None) -> Contents:
    """Arrays in a file or folder of another tool.

    Args:
        path: where it is.
        layout: of a text file, as far as it cannot be seen.

    Raises:
        FFGymError: if the kind of file is unknown, or it cannot be read; the message begins with the path.
    """
    place, layout = Path(path), layout or TextLayout()
    with errors_at(str(place)):
        found = _format_of(place)
        if layout != TextLayout() and not found.is_text:
            texts = ", ".join(suffix for kind in log_formats() if kind.is_text for suffix in kind.suffixes)
            raise FFGymError(f"[file] is about text files ({texts}); leave it out.")
        if missing := [package for package in found.packages if util.find_spec(package) is None]:
            raise FFGymError(
                f"Reading {found.title} needs {', '.join(missing)}; pip install '{found.extra or ' '.join(missing)}'."
            )
        with one_error(found.title):
            return found.read(place, layout)


def _format_of(place: Path) -> LogFormat:
    """Format that reads a file or folder."""
    kinds = sorted(log_formats(), key=lambda kind: not kind.is_text)
    found = next((kind for kind in reversed(kinds) if kind.recognises(place)), None)
    if found is not None:
        return found
    if place.is_dir():
        markers = " or ".join(kind.folder for kind in kinds if kind.folder)
        raise FFGymError(f"the folder has no {markers}: neither a rosbag nor a LeRobot data set.")
    if place.suffix.lower() == PACKED:
        texts = ", ".join(suffix for kind in kinds if kind.is_text for suffix in kind.suffixes)
        raise FFGymError(f"only tables in text ({texts}) are read packed; unpack it first.")
    known = ", ".join(suffix for kind in kinds for suffix in kind.suffixes)
    raise FFGymError(f"suffix {place.suffix.lower()!r} is unknown, must be one of {known}.")


def bare_name(path: str | os.PathLike[str]) -> str:
    """Name of a file without its suffix, and without that of a packed table: `run.csv.gz` is `run`."""
    place = Path(path)
    return Path(place.stem).stem if place.suffix.lower() == PACKED else place.stem


@contextmanager
def one_error(what: str) -> Iterator[None]:
    """Turn whatever a library raises on damaged bytes of `what`, e.g. 'a MATLAB file', into one FFGymError of one line.

    Raises:
        FFGymError: in place of any exception within.
    """
    try:
        yield
    except FFGymError:
        raise
    except MemoryError as error:  # of a length in a damaged file, for which a library reserves memory before it reads
        raise FFGymError(f"Not {what}, or damaged: it asks for more memory than there is. Copy it again.") from error
    except Exception as error:
        # scipy, h5py, pyarrow, sqlite3 and rosbags parse what may be any bytes, and document no closed list of
        # what they raise: IndexError, struct.error, zlib.error, OverflowError, AttributeError, ... were all seen.
        text = " ".join(str(error).split())[:200]
        reason = f"{type(error).__name__}: {text}" if text else type(error).__name__
        raise FFGymError(
            f"Not {what}, or damaged, cut short or protected by a password ({reason}). Copy or export it again."
        ) from error
