"""Return of freed memory to the system.

Trial models come and go by tens of megabytes beside columns that stay. The C library keeps the gaps that they leave,
half a gigabyte of a long log, which counts towards the 3 GB that a diagnosis may need.
"""

import ctypes
from functools import cache
from typing import Any


def trim_heap() -> None:
    """Give freed memory back to the system where its C library can, as that of GNU does; it changes nothing else."""
    trim = _trim()
    if trim is not None:
        trim(0)


@cache
def _trim() -> Any:
    """The function of the C library; None if it has none."""
    try:
        return ctypes.CDLL(None).malloc_trim
    except (OSError, TypeError, AttributeError):  # no such library, or none that is found so
        return None
