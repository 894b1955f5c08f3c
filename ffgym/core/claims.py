"""Lock of a folder, for one process at a time."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ffgym.core.errors import FFGymError
from ffgym.core.files import TEMPORARY

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]


@contextmanager
def claimed(folder: str | os.PathLike[str]) -> Iterator[Path]:
    """Hold a folder, so that two processes do not fill it at once; half-written files of killed processes are removed.

    The claim is a lock of the operating system on the folder itself, which ends with the process however that ends.
    Windows and some network drives have none; there the folder is merely yielded.

    Raises:
        FFGymError: if another process holds the folder, or it cannot be read or written.
    """
    place = Path(folder)
    if not os.access(place, os.W_OK):
        raise FFGymError(f"{place}: is not writable; choose another folder, or allow writing.")
    held = _lock(place)
    try:
        if held is not None:
            remove_remains(place)
        yield place
    finally:
        if held is not None:
            os.close(held)


def remove_remains(folder: Path) -> None:
    """Remove half-written files and folders of processes that were killed."""
    for remains in folder.glob(TEMPORARY.format("*")):
        if remains.is_dir():
            shutil.rmtree(remains, ignore_errors=True)
        else:
            remains.unlink(missing_ok=True)


def _lock(folder: Path) -> int | None:
    """Return the descriptor that holds the lock; None on systems without such locks."""
    if fcntl is None:
        return None
    try:
        descriptor = os.open(folder, os.O_RDONLY)
    except OSError as error:
        raise FFGymError(f"{folder}: cannot be read: {error.strerror}; choose another folder, or allow it.") from error
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        os.close(descriptor)
        raise FFGymError(
            f"{folder}: another process is filling this folder. Wait for it, end it, or choose another folder."
        ) from error
    except OSError:  # a drive without locks
        os.close(descriptor)
        return None
    return descriptor
