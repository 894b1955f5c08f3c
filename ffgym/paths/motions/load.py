"""Motions by name or from a file, as references for a robot."""

from collections.abc import Callable, Mapping
from functools import partial
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from types import MappingProxyType

import numpy as np

from ffgym.core.errors import FFGymError, check_choice
from ffgym.paths.motions.composition import compose
from ffgym.paths.motions.motion import Motion
from ffgym.paths.motions.motion_file import parse_motion, read_motion_file
from ffgym.paths.motions.parts.place import Place
from ffgym.paths.motions.parts.table_part import TablePart
from ffgym.paths.motions.rapid import rapid_motion
from ffgym.robot import RigidArm


def read_csv(arm: RigidArm, path: Path) -> Motion:
    """Motion of a CSV file of poses or joint positions, see `TablePart`.

    Raises:
        FFGymError: if the file cannot be read or is no such table, or the robot cannot make the motion.
    """
    place = Place(arm=arm, origin=np.zeros(3), where=str(path), folder=path.parent)
    return compose(arm, TablePart(file=path.name).moves(place), name=path.stem)


READERS: Mapping[str, Callable[[RigidArm, Path], Motion]] = MappingProxyType(
    {".toml": read_motion_file, ".csv": read_csv, ".mod": rapid_motion, ".prg": rapid_motion}
)
"""What reads a file, by the suffix of its name."""

PROGRAMS = tuple(suffix for suffix, reader in READERS.items() if reader is rapid_motion)
"""Suffixes of files with procedures."""

FOLDERS = (("ffgym.paths.motions", "data"), ("ffgym.paths.rapid", "examples"))
"""Where built-in motions are: packages and folders in them."""


def list_motions() -> tuple[str, ...]:
    """Names of the motions that ship with the package; which of them a robot can make depends on it."""
    return tuple(sorted(builtin_files()))


def builtin_files() -> dict[str, Traversable]:
    """Files of the built-in motions, by name."""
    files = [file for package, folder in FOLDERS for file in (resources.files(package) / folder).iterdir()]
    return {Path(file.name).stem: file for file in files if Path(file.name).suffix in READERS}


def load_motion(arm: RigidArm, source: str | Path, *, entry: str | None = None) -> Motion:
    """Motion for a robot, from a built-in name or from a file.

    Args:
        arm: the robot.
        source: a name of `list_motions`, or a path whose suffix is one of READERS.
        entry: procedure of a RAPID program that is run; None takes main, or the only one.

    Raises:
        FFGymError: if there is no such motion or file, it has no procedure `entry`, or the robot cannot make it.
    """
    path = Path(source)
    if path.suffix.lower() in READERS:
        return _reader(path.name, entry)(arm, path)
    if path.suffix or path.name != str(source):
        raise FFGymError(f"{source}: a motion file must end in {', '.join(READERS)}.")
    file = builtin_files()[check_choice("motion", str(source), list_motions())]
    reader = _reader(file.name, entry)
    if file.name.endswith(".toml"):
        return parse_motion(arm, file.read_text(encoding="utf-8"), where=file.name, name=str(source))
    with resources.as_file(file) as place:
        return reader(arm, place)


def _reader(name: str, entry: str | None) -> Callable[[RigidArm, Path], Motion]:
    """What reads a file of that name, from procedure `entry` on if one is given."""
    suffix = Path(name).suffix.lower()
    if entry is None:
        return READERS[suffix]
    if suffix not in PROGRAMS:
        raise FFGymError(
            f"entry = {entry!r} is a procedure of a program ({', '.join(PROGRAMS)}), which {name} is not; leave it out."
        )
    return partial(rapid_motion, entry=entry)
