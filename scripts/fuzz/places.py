"""What may lie in the place of a file: nothing, a folder, a pipe, a device, a link to itself, an empty file."""

import os
import shutil
from collections.abc import Callable
from pathlib import Path


def remove(path: Path) -> None:
    """Remove what is there, if anything is."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def _nothing(path: Path) -> None:
    pass


def _empty(path: Path) -> None:
    path.touch()


def _folder(path: Path) -> None:
    path.mkdir()


def _pipe(path: Path) -> None:
    os.mkfifo(path)


def _device(path: Path) -> None:
    path.symlink_to("/dev/zero")


def _link_to_itself(path: Path) -> None:
    path.symlink_to(path.name)


KINDS: tuple[Callable[[Path], None], ...] = (_nothing, _empty, _folder, _pipe, _device, _link_to_itself)
"""Functions that put something in a place which is free."""
