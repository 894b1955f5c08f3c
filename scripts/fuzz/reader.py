"""A reader of files, with valid files of its kind, and the damaged ones that a seed and a number stand for."""

import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np

from scripts.fuzz.formats import mutate_file
from scripts.fuzz.places import KINDS, remove

Make = Callable[[Path], Path]
"""Function that writes valid files into an empty folder, and returns the one that the reader is given."""


@dataclass(frozen=True, kw_only=True)
class Reader:
    """One way into the project: files of a kind, and what is called with them."""

    name: str
    use: Callable[[Path], object]
    """Call that reads the files, and what is done with them first."""
    makes: tuple[Make, ...]
    """Functions that write valid files."""
    covers: tuple[Callable[..., Any], ...]
    """Public functions that `use` goes through."""
    errors: tuple[type[Exception], ...] = ()
    """Errors beside FFGymError that its documentation names."""
    share: int = 10
    """Inputs among those of all readers; less where one takes long."""
    repair: Callable[[bytes], bytes] | None = None
    """Function that makes hashes in a file fit again after damage, so that it reaches what lies behind them; it is used
    for half of the inputs."""


@dataclass(frozen=True)
class Valid:
    """Valid files of a reader."""

    main: str
    """Name of the file, or folder, that the reader is given."""
    files: dict[str, bytes] = field(repr=False)
    """Contents by name."""

    def write(self, folder: Path) -> Path:
        """Write the files into a folder; return the path that the reader is given."""
        for name, data in self.files.items():
            place = folder / name
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(data)
        return folder / self.main


@dataclass(frozen=True)
class Damage:
    """Damage to one of the valid files."""

    number: int
    """Number of the set of valid files."""
    name: str
    """Name of the file."""
    data: bytes | Callable[[Path], None] = field(repr=False)
    """New content of the file, or a function that puts something else in its place."""

    def write(self, folder: Path) -> None:
        """Put the damaged file in the place of the valid one in a folder."""
        place = folder / self.name
        if isinstance(self.data, bytes):
            place.write_bytes(self.data)
        else:
            remove(place)
            self.data(place)


def make_valid(reader: Reader, folder: Path) -> list[Valid]:
    """Make the sets of valid files of a reader, below a folder."""
    found = []
    for k, make in enumerate(reader.makes):
        place = folder / f"{reader.name}-{k}"
        shutil.rmtree(place, ignore_errors=True)  # of a process that died
        place.mkdir(parents=True)
        main = make(place)
        files = {file.relative_to(place).as_posix(): file.read_bytes() for file in place.rglob("*") if file.is_file()}
        found.append(Valid(main.relative_to(place).as_posix(), files))
        shutil.rmtree(place)
    return found


def damage(reader: Reader, valid: Sequence[Valid], seed: int, number: int) -> Damage:
    """Make the damage of an input; the same seed and number give the same bytes.

    Args:
        reader: the reader.
        valid: its valid files.
        seed: seed of the run.
        number: number of the input, from 0.
    """
    rng = np.random.default_rng([seed, crc32(reader.name.encode()), number])
    which = int(rng.integers(len(valid)))
    one = valid[which]
    # of several files mostly the one that leads to the others
    name = one.main if one.main in one.files and rng.random() < 0.5 else str(rng.choice(sorted(one.files)))
    if rng.random() < 0.01:
        return Damage(which, name, KINDS[rng.integers(len(KINDS))])
    data = one.files[name]
    for _ in range(int(rng.choice([1, 1, 1, 2, 3]))):
        data = mutate_file(name, data, rng)
    if reader.repair is not None and rng.random() < 0.5:
        data = reader.repair(data)
    return Damage(which, name, data)
