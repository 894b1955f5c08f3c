"""The process of a command: standard streams that may be closed, full or ASCII, and signals that end it."""

import io
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any

from ffgym.core.errors import FFGymError


class EndedError(BaseException):
    """A signal to end; as Ctrl-C, it is no error that work catches."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number
        """Number of the signal."""


@contextmanager
def ended_by_signals() -> Iterator[None]:
    """Raise EndedError where SIGTERM or SIGHUP comes, so that work cleans up, and KeyboardInterrupt on Ctrl-C.

    A signal that is ignored stays so.

    Raises:
        EndedError: also for Ctrl-C, and where a library makes another error of what is raised in its midst.
    """
    usual = {signal.SIGINT: signal.default_int_handler}
    usual |= {getattr(signal, name): signal.SIG_DFL for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)}
    came, taken = list[int](), dict[signal.Signals, Any]()

    def end(number: int, frame: FrameType | None) -> None:
        came.append(number)
        if number == signal.SIGINT:
            raise KeyboardInterrupt
        raise EndedError(number)

    with suppress(ValueError):  # of another thread than the main one, which alone sees signals
        for number, handler in usual.items():
            if signal.getsignal(number) == handler:
                signal.signal(number, end)
                taken[number] = handler
    try:
        yield
    except (EndedError, FFGymError):
        raise
    except KeyboardInterrupt as error:
        raise EndedError(signal.SIGINT) from error
    except Exception as error:
        if came:
            raise EndedError(came[-1]) from error
        raise
    finally:
        for number, handler in taken.items():
            signal.signal(number, handler)


class _Pipe(io.FileIO):
    """Standard output without an end: once it cannot be written, what is printed is lost, and the work goes on."""

    def __init__(self, descriptor: int) -> None:
        super().__init__(descriptor, "w", closefd=False)
        self.failure: OSError | None = None

    def write(self, data: Any) -> int:
        """Write bytes, or lose them."""
        if self.failure is None:
            try:
                return super().write(data) or 0
            except OSError as error:
                self.failure = error
        return len(data)


@contextmanager
def lasting_output() -> Iterator[None]:
    """Let work in the block go on where nobody reads what it prints, and print what the encoding lacks as escapes.

    Files are the result of most commands, which a closed or full standard output must not cost.

    Raises:
        FFGymError: at the end, if standard output could not be written, other than because its reader has left.
    """
    _open_closed_streams()
    before = sys.stdout
    if before is not sys.__stdout__ or not isinstance(before, io.TextIOWrapper):  # that of a program which calls this
        yield
        return
    before.flush()
    pipe = _Pipe(before.fileno())
    sys.stdout = io.TextIOWrapper(
        io.BufferedWriter(pipe),
        encoding=before.encoding,
        errors="backslashreplace",
        line_buffering=before.line_buffering,
    )
    ended: SystemExit | None = None
    try:
        yield
    except SystemExit as end:  # after help, or what does not parse
        ended = end
    finally:
        sys.stdout.flush()
        sys.stdout = before
    if pipe.failure is not None and not isinstance(pipe.failure, BrokenPipeError):
        raise FFGymError(
            f"Standard output cannot be written: {pipe.failure.strerror}. Files that were asked for are written."
        )
    if ended is not None:
        raise ended


def _open_closed_streams() -> None:
    """Put the empty device where a standard stream is closed, so that no file that is opened takes its place."""
    for number in (0, 1, 2):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, io.TextIOWrapper(io.FileIO(os.devnull, "w"), encoding="utf-8"))
