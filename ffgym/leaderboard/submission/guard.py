"""What an agent must not do: look at the simulator, leave its process, talk to others, write elsewhere.

This keeps honest people honest. It is no wall: who knows Python well finds a way around a hook in the same process.
Foreign code that you have reason to distrust belongs in a container of your own; see docs/leaderboard/submissions.md.
"""

import importlib.abc
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import ffgym
from ffgym.errors import FFGymError

HIDDEN = (
    "ffgym.workcell",
    "ffgym.envs",
    "ffgym.exam",
    "ffgym.cli",
    "ffgym.improvement",
    "ffgym.reproduction",
    "ffgym.report",
    "ffgym.leaderboard",
    "scripts",
    "tests",
)
"""Modules that an agent must not see, with all below them: the machines, and what leads to them."""
SEEN = ("ffgym.leaderboard.submission",)
"""What it runs in."""

_HARMLESS = ("/proc/cpuinfo", "/proc/meminfo", "/proc/stat")
"""What libraries read to count processors and memory."""
_MEMORIES = ("/proc", "/dev/mem", "/dev/kmem", "/dev/port")
_ALONE = {
    "subprocess.Popen": "start a process",
    "os.system": "start a process",
    "os.exec": "start a process",
    "os.posix_spawn": "start a process",
    "os.spawn": "start a process",
    "os.fork": "start a process",
    "os.forkpty": "start a process",
    "pty.spawn": "start a process",
    "os.startfile": "start a process",
    "os.kill": "send a signal",
    "os.killpg": "send a signal",
    "signal.pthread_kill": "send a signal",
    "sqlite3.connect": "open a data base",
}
"""Events that are refused whatever their arguments, and what the agent tried."""
_FAMILIES = {"ctypes.": "reach memory through ctypes", "socket.": "open a network connection"}
_LISTS = ("os.listdir", "os.scandir")
_CHANGES = {
    "os.remove": 1,
    "os.rename": 2,
    "os.link": 2,
    "os.symlink": 2,
    "os.mkdir": 1,
    "os.rmdir": 1,
    "os.truncate": 1,
    "os.chmod": 1,
    "os.chown": 1,
    "os.utime": 1,
}
"""Events that change files, and how many of their arguments are paths."""
_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND


def install(refuse: Callable[[str], None], folder: Path) -> None:
    """Watch this process from now on, for good.

    Args:
        refuse: called with what the agent tried, before the agent gets a PermissionError that it may swallow.
        folder: the only one in which files may be written.

    Raises:
        FFGymError: if something is loaded already that an agent must not see.
    """
    if loaded := sorted(name for name in sys.modules if _is_hidden(name)):
        raise FFGymError(f"{', '.join(loaded)} must not be loaded where an agent runs; load agents without it.")
    judge = Judge(folder)

    def watch(event: str, arguments: tuple[Any, ...]) -> None:
        if (tried := judge(event, arguments)) is not None:
            refuse(tried)
            raise PermissionError(f"An agent must not {tried}.")

    sys.meta_path.insert(0, _NoImports(refuse))
    sys.addaudithook(watch)


class _NoImports(importlib.abc.MetaPathFinder):
    """Finds nothing, and refuses what is hidden, however it is imported."""

    def __init__(self, refuse: Callable[[str], None]) -> None:
        self._refuse = refuse

    def find_spec(self, fullname: str, path: Any, target: Any = None) -> None:
        """See base class."""
        if _is_hidden(fullname):
            self._refuse(f"import {fullname}")
            raise ImportError(f"An agent must not import {fullname}: it is handed observations only.")


class Judge:
    """Says what an event of `sys.audit` tries that is not allowed, or None."""

    def __init__(self, folder: Path) -> None:
        package = Path(os.path.realpath(ffgym.__file__ or "")).parent
        self._folder = os.path.realpath(folder)
        self._hidden = [_place(package, name) for name in HIDDEN if name.startswith("ffgym.")]
        self._seen = [_place(package, name) for name in SEEN]

    def __call__(self, event: str, arguments: tuple[Any, ...]) -> str | None:
        """What the event tries that is not allowed; None if it may."""
        if event == "open":
            return self._opened(*arguments[:3])
        if event == "import":
            return f"import {arguments[0]}" if _is_hidden(str(arguments[0])) else None
        if event in _ALONE:
            return _ALONE[event]
        if event in _LISTS:
            return self._read(arguments[0] if arguments[0] is not None else os.curdir)
        if event in _CHANGES:
            return self._changed(arguments[: _CHANGES[event]])
        return next((tried for begin, tried in _FAMILIES.items() if event.startswith(begin)), None)

    def _opened(self, path: Any, mode: Any, flags: Any) -> str | None:
        if isinstance(path, int):
            return None  # it is open already
        writes = bool(flags & _WRITING) if isinstance(flags, int) else False
        writes |= isinstance(mode, str) and any(letter in mode for letter in "wax+")
        return self._read(path) or (self._changed((path,)) if writes else None)

    def _read(self, path: Any) -> str | None:
        if isinstance(path, int):
            return None
        place = os.path.realpath(os.fsdecode(path))
        if place in _HARMLESS:
            return None
        hidden = within(place, _MEMORIES) or (within(place, self._hidden) and not within(place, self._seen))
        return f"read {place}" if hidden else None

    def _changed(self, paths: Sequence[Any]) -> str | None:
        for path in paths:
            place = None if isinstance(path, int) else os.path.realpath(os.fsdecode(path))
            if place is not None and place != os.devnull and not within(place, [self._folder]):
                return f"write {place}, outside of its folder"
        return None


def within(path: str, folders: Sequence[str]) -> bool:
    """Whether a path is one of `folders` or below."""
    return any(path == folder or path.startswith(folder + os.sep) for folder in folders)


def _is_hidden(name: str) -> bool:
    if name == "ffgym.leaderboard" or _below(name, SEEN):
        return False
    return _below(name, HIDDEN)


def _below(name: str, parents: Sequence[str]) -> bool:
    return any(name == parent or name.startswith(parent + ".") for parent in parents)


def _place(package: Path, name: str) -> str:
    return str(package.joinpath(*name.split(".")[1:]))
