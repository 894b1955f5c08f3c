"""What a command writes, and where its numbers come from."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict
from itertools import combinations
from pathlib import Path
from typing import Any

from ffgym.core.errors import FFGymError
from ffgym.core.files import check_writable
from ffgym.core.provenance import installed, versions


def need_extra(who: str, *packages: str) -> None:
    """Check that packages are installed that `who` needs for tables and pages.

    Raises:
        FFGymError: if one is not.
    """
    missing = [name for name in packages if not installed(name)]
    if missing:
        raise FFGymError(f"{who} needs {', '.join(missing)}; pip install 'ffgym[cli,report]'.")


_SUFFIXES = {"--report": ".html", "--page": ".html", "--json": ".json"}
"""How files must end whose form does not follow from their name, so that no description or program is written over."""


def check_outputs(places: Mapping[str, Path | None], *, inputs: Iterable[str | Path | None] = ()) -> None:
    """Check before long work that all files can be written after it; None is none.

    Args:
        places: by the option that names each.
        inputs: names and files that the command reads, none of which may be written over.

    Raises:
        FFGymError: if one cannot be written, two are one file, one is an input, or is named as another kind of file.
    """
    given = {option: place for option, place in places.items() if place is not None}
    for place in given.values():
        check_writable(place)
    for (one, first), (other, second) in combinations(given.items(), 2):
        if first.resolve() == second.resolve():
            raise FFGymError(f"{one} and {other} are both {first}; they need two files.")
    read = {Path(name).resolve() for name in inputs if name is not None}
    for option, place in given.items():
        if place.resolve() in read:
            raise FFGymError(f"{option} {place}: is read by this command and would be lost; choose another name.")
        if place.suffix != _SUFFIXES.get(option, place.suffix):
            raise FFGymError(f"{option} {place}: the name must end in {_SUFFIXES[option]}.")


def provenance(command: str, config: Any, robot: str, fingerprint: str | None, seed: int | None) -> dict[str, Any]:
    """Origin of numbers, for JSON.

    Args:
        command: e.g. 'ffgym demo'.
        config: the dataclass of its options.
        robot: name.
        fingerprint: of the simulated physics; None where nothing can be simulated.
        seed: None where nothing is random.
    """
    return {
        "command": command,
        "config": {name: _plain(value) for name, value in asdict(config).items()},
        "robot": robot,
        "seed": seed,
        "versions": versions(),
        "physics_fingerprint": fingerprint,
    }


def _plain(value: Any) -> Any:
    if isinstance(value, tuple):
        return [_plain(entry) for entry in value]
    return str(value) if isinstance(value, Path) else value
