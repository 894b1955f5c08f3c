"""What an agent must not try, told from the events of `sys.audit`: to read what is hidden, to start processes."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import ffgym

HIDDEN = (
    "ffgym.workcell",
    "ffgym.envs",
    "scripts.exam",
    "ffgym.cli",
    "ffgym.improvement",
    "scripts.thesis",
    "ffgym.report",
    "ffgym.leaderboard",
    "scripts",
    "tests",
)
"""Modules that no agent may see, with all below them: the machines, and what leads to them."""
SEEN = ("ffgym.leaderboard.submission",)
"""What it runs in."""

_DOORS = ("_posixsubprocess",)
"""Modules that are loaded, and must not be loaded afresh: they start processes without an event."""
_TRUTH = os.sep + os.path.join("ffgym", "workcell") + os.sep
"""Part of a path that leads to the machines, in whichever copy of this package."""
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
    "_winapi.CreateProcess": "start a process",
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


class Judge:
    """Says what an event tries that is not allowed, or None.

    Args:
        folder: the only one in which files may be written.
        hidden: modules that must not be seen, with all below them.
    """

    def __init__(self, folder: Path, hidden: Sequence[str] = HIDDEN) -> None:
        package = Path(os.path.realpath(ffgym.__file__ or "")).parent
        self._folder = os.path.realpath(folder)
        self._modules = tuple(hidden)
        self._hidden = [_place(package, name) for name in hidden if name.startswith("ffgym.")]
        if (package.parent / "pyproject.toml").is_file():  # elsewhere these names are of other packages
            self._hidden += [str(package.parent / name) for name in hidden if "." not in name]
        self._seen = [_place(package, name) for name in SEEN]
        self._harmless = (*_HARMLESS, f"/proc/{os.getpid()}/maps")  # threadpoolctl looks there for libraries

    def __call__(self, event: str, arguments: tuple[Any, ...]) -> str | None:
        """What the event tries that is not allowed; None if it may."""
        if event == "open":
            return self._opened(*arguments[:3])
        if event == "import":
            return f"import {arguments[0]}" if self.hides(str(arguments[0])) else None
        if event in _ALONE:
            return _ALONE[event]
        if event in _LISTS:
            return self._read(arguments[0] if arguments[0] is not None else os.curdir)
        if event in _CHANGES:
            return self._changed(arguments[: _CHANGES[event]])
        return next((tried for begin, tried in _FAMILIES.items() if event.startswith(begin)), None)

    def hides(self, module: str) -> bool:
        """Whether a module must not be imported."""
        return _below(module, _DOORS) or self.is_secret(module)

    def is_secret(self, module: str) -> bool:
        """Whether a module must not even be loaded."""
        if module == "ffgym.leaderboard" or _below(module, SEEN):
            return False
        return _below(module, self._modules)

    def _opened(self, path: Any, mode: Any, flags: Any) -> str | None:
        if isinstance(path, int):
            return None  # it is open already
        writes = bool(flags & _WRITING) if isinstance(flags, int) else False
        writes |= isinstance(mode, str) and any(letter in mode for letter in "wax+")
        return self._read(path) or self._entered(path) or (self._changed((path,)) if writes else None)

    def _read(self, path: Any) -> str | None:
        if isinstance(path, int):
            return None
        text = os.fsdecode(path)
        place = os.path.realpath(text)
        if place in self._harmless:
            return None
        hidden = within(place, _MEMORIES) or (within(place, self._hidden) and not within(place, self._seen))
        named = (os.path.normpath(each) for each in (os.sep + text, place))  # a path may count from another folder
        return f"read {place}" if hidden or any(_TRUTH in each + os.sep for each in named) else None

    def _entered(self, path: Any) -> str | None:
        """A folder that is opened is one that later paths may count from."""
        place = os.path.realpath(os.fsdecode(path))
        if os.path.isdir(place) and not within(place, [self._folder]):
            return f"open the folder {place}"
        return None

    def _changed(self, paths: Sequence[Any]) -> str | None:
        for path in paths:
            place = None if isinstance(path, int) else os.path.realpath(os.fsdecode(path))
            if place is not None and place != os.devnull and not within(place, [self._folder]):
                return f"write {place}, outside of its folder"
        return None


def within(path: str, folders: Sequence[str]) -> bool:
    """Whether a path is one of `folders` or below."""
    return any(path == folder or path.startswith(folder + os.sep) for folder in folders)


def _below(name: str, parents: Sequence[str]) -> bool:
    return any(name == parent or name.startswith(parent + ".") for parent in parents)


def _place(package: Path, name: str) -> str:
    return str(package.joinpath(*name.split(".")[1:]))
