"""Files and folders that exist while something is written, and go when the process that made them is gone.

Each is locked by its process. The operating system ends a lock with its process, however that ends, so that whoever
finds a temporary file and can lock it knows that nobody writes it any more. Locks are those of `fcntl.flock`: the
library `filelock` is built on them too, but keeps files of its own for them, and this package needs none elsewhere.
"""

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import gettempdir
from uuid import uuid4

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

TEMPORARY = ".ffgym-{}.tmp"
"""Name of what is temporary, in the folder of the place that it is made for."""


own: set[Path] = set()
"""Temporary files and folders of this process that are there, or are about to be made."""


class LockedError(Exception):
    """A file or folder that another process has locked, or another part of this one."""


def lock(path: Path) -> int | None:
    """Lock a file or folder; return the descriptor that holds the lock until it is closed.

    Returns:
        None on systems and drives without such locks.

    Raises:
        LockedError: if it is locked, or was replaced or removed meanwhile.
        OSError: if it cannot be opened.
    """
    if fcntl is None:
        return None
    way = os.O_RDONLY if path.is_dir() else os.O_RDWR  # network drives lock only what may be written
    try:
        descriptor = os.open(path, way | os.O_NOFOLLOW | os.O_NONBLOCK)
    except FileNotFoundError as error:
        raise LockedError(path) from error
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        os.close(descriptor)
        raise LockedError(path) from error
    except OSError:  # a drive without locks
        os.close(descriptor)
        return None
    if not _is_at(descriptor, path):
        os.close(descriptor)
        raise LockedError(path)
    return descriptor


def _is_at(descriptor: int, path: Path) -> bool:
    """Tell whether an open file is still the one at a path."""
    try:
        return os.path.samestat(os.fstat(descriptor), os.stat(path, follow_symlinks=False))
    except FileNotFoundError:
        return False


@contextmanager
def temporary_file(folder: Path) -> Iterator[Path]:
    """Yield an empty new file in a folder, which is removed when the block ends, unless it was moved.

    Raises:
        OSError: if it cannot be made.
    """
    with _temporary(folder, lambda path: path.touch(exist_ok=False)) as path:
        yield path


@contextmanager
def temporary_folder(folder: Path) -> Iterator[Path]:
    """Yield an empty new folder in a folder, which is removed when the block ends, unless it was moved.

    Raises:
        OSError: if it cannot be made.
    """
    with _temporary(folder, Path.mkdir) as path:
        yield path


@contextmanager
def scratch_folder() -> Iterator[Path]:
    """Yield an empty folder for what nobody needs after the block, where the system keeps such files."""
    place = Path(gettempdir())
    remove_remains(place)
    with temporary_folder(place) as path:
        yield path


@contextmanager
def _temporary(folder: Path, make: Callable[[Path], object]) -> Iterator[Path]:
    """Make something under a free name, lock it, and remove it at the end."""
    path, held = _make_locked(folder, make)
    try:
        yield path
    finally:
        remove(path)
        if held is not None:
            os.close(held)


def _make_locked(folder: Path, make: Callable[[Path], object]) -> tuple[Path, int | None]:
    while True:
        path = folder / TEMPORARY.format(uuid4().hex)
        own.add(path)
        make(path)
        try:
            return path, lock(path)
        except LockedError:  # another process looked for remains in this very instant, and takes it for one
            continue
        except BaseException:
            remove(path)
            raise


def remove_remains(folder: Path) -> None:
    """Remove what processes that are gone left half-written in a folder; that of living ones stays."""
    found: list[Path] = []
    with suppress(OSError):
        found = sorted(folder.glob(TEMPORARY.format("*")))
    for path in found:
        with suppress(LockedError, OSError):  # of a living process, of another user, or gone meanwhile
            if (held := lock(path)) is None:
                continue  # nobody can tell whose it is
            try:
                remove(path)
            finally:
                os.close(held)


def remove_own() -> None:
    """Remove what this process has left, after a signal that ended what would have removed it."""
    for path in sorted(own):
        remove(path)


def remove(path: Path) -> None:
    """Remove a temporary file or folder, if it is still there."""
    with suppress(OSError):
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)
    own.discard(path)
