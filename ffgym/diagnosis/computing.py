"""Rules of computing in a diagnosis: one thread, memory that is given back, trial models that may fail.

Trial models come and go by tens of megabytes beside columns that stay. The C library keeps the gaps that they leave,
half a gigabyte of a long log, which counts towards the 3 GB that a diagnosis may need.
"""

import ctypes
from collections.abc import Callable
from contextlib import suppress
from functools import wraps
from typing import ParamSpec, TypeVar

import numpy as np
from threadpoolctl import threadpool_limits  # type: ignore[import-untyped]

from ffgym.core.errors import FFGymError

FAILED = (FFGymError, np.linalg.LinAlgError, FloatingPointError)
"""An arm that flies away, a simulation that becomes unstable, a machine that cannot be so; equations without solution;
numbers beyond those that a computer has."""


def trim_heap() -> None:
    """Give freed memory back to the system where its C library can, as that of GNU does; it changes nothing else."""
    with suppress(OSError, TypeError, AttributeError):  # no such library, or none that is found so
        ctypes.CDLL(None).malloc_trim(0)


P = ParamSpec("P")
R = TypeVar("R")


def on_one_thread(function: Callable[P, R]) -> Callable[P, R]:
    """The same function with one thread in the libraries of linear algebra, whatever the environment says.

    Threads of the caller are as before when it is done. The engine's own threads do not depend on it.
    """

    @wraps(function)
    def alone(*args: P.args, **kwargs: P.kwargs) -> R:
        with threadpool_limits(limits=1):
            return function(*args, **kwargs)

    return alone
