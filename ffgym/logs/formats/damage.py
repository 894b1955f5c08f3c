"""One error for a file that a library cannot read."""

from collections.abc import Iterator
from contextlib import contextmanager

from ffgym.core.errors import FFGymError


@contextmanager
def one_error(what: str) -> Iterator[None]:
    """Turn whatever a library raises on damaged bytes into one FFGymError of one line.

    Args:
        what: the kind of file, e.g. 'a MATLAB file'.

    Raises:
        FFGymError: in place of any exception within.
    """
    try:
        yield
    except FFGymError:
        raise
    except Exception as error:
        # scipy, h5py, pyarrow, sqlite3 and rosbags parse what may be any bytes, and document no closed list of
        # what they raise: IndexError, struct.error, zlib.error, OverflowError, AttributeError, ... were all seen.
        text = " ".join(str(error).split())[:200]
        reason = f"{type(error).__name__}: {text}" if text else type(error).__name__
        raise FFGymError(
            f"Not {what}, or damaged, cut short or protected by a password ({reason}). Copy or export it again."
        ) from error
