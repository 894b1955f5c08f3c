"""Checks and claims before a command works, what it writes and prints after, and where its numbers come from."""

import hashlib
import os
import re
import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, fields
from importlib import resources
from itertools import combinations
from pathlib import Path
from typing import Any, get_type_hints

import tyro

from ffgym.core.claims import claim
from ffgym.core.errors import FFGymError
from ffgym.core.files import check_vacant, check_writable, write_json
from ffgym.core.provenance import is_installed, versions
from ffgym.robot import builtin_parameters, builtin_robots


def need_extra(who: str, *packages: str, extra: str = "cli,report") -> None:
    """Check that packages are installed that `who` needs, which `extra` of ffgym installs.

    Raises:
        FFGymError: if one is not.
    """
    missing = [name for name in packages if not is_installed(name)]
    if missing:
        raise FFGymError(f"{who} needs {', '.join(missing)}; pip install 'ffgym[{extra}]'.")


def given_options(command: Any, names: Sequence[str]) -> list[str]:
    """List those of the options `names` of a command that have another value than their default, as they are typed."""
    defaults = {field.name: field.default for field in fields(command)}
    return ["--" + name.replace("_", "-") for name in names if getattr(command, name) != defaults[name]]


_SUFFIXES = {"--report": ".html", "--page": ".html", "--json": ".json"}
"""Endings of files whose form does not follow from their name, so that no description or program is written over."""


def claim_outputs(
    places: Mapping[str, Path | None], *, inputs: Iterable[str | Path | None] = (), suffix: str | None = None
) -> None:
    """Claim all files before long work, which can be written after it then, and pages made; None is none.

    They are claimed until the command ends, so that no second one writes the same places.

    Args:
        places: by the option that names each.
        inputs: names and files that the command reads, none of which may be written over.
        suffix: how the file of `--out` must end; None is as the command likes.

    Raises:
        FFGymError: if one cannot be written, two are one file, one is an input, or is named as another kind of file, or
            another process is writing it.
    """
    given = {option: place for option, place in places.items() if place is not None}
    suffixes = _SUFFIXES | ({} if suffix is None else {"--out": suffix})
    if "--report" in given:
        need_extra("The report", "matplotlib", "jinja2")
    for place in given.values():
        check_writable(place)
    for (one, first), (other, second) in combinations(given.items(), 2):
        if os.path.realpath(first) == os.path.realpath(second):
            raise FFGymError(f"{one} and {other} are both {first}; they need two files.")
    read = {os.path.realpath(name) for name in inputs if name is not None}
    for option, place in given.items():
        if os.path.realpath(place) in read:
            raise FFGymError(f"{option} {place}: is read by this command and would be lost; choose another name.")
        if place.suffix != suffixes.get(option, place.suffix):
            raise FFGymError(f"{option} {place}: the name must end in {suffixes[option]}.")
    for place in given.values():
        claim(place)


def claim_new(path: Path, kind: str, *, force: bool) -> None:
    """Claim a .toml file that people work on, which is written over only by `force`.

    Raises:
        FFGymError: if it is there, cannot be written, has another suffix, or another process is writing it.
    """
    if path.suffix != ".toml":
        raise FFGymError(f"{path}: the suffix is {path.suffix!r}, {kind} must end in .toml.")
    if path.exists() and not force:
        raise FFGymError(f"{path} is there already, and may hold your work; --force writes over it.")
    check_writable(path)
    claim(path)


def claim_new_folder(path: Path) -> None:
    """Claim a folder that is to be made, before long work.

    Raises:
        FFGymError: if something is there that is no empty folder, it cannot be made, or another process makes it.
    """
    check_vacant(path)
    claim(path)


def given_folder(path: Path | None, what: str) -> Path:
    """The folder of `--out`.

    Raises:
        FFGymError: if it is not given, or a file.
    """
    if path is None:
        raise FFGymError(f"Say where {what}: --out FOLDER.")
    if path.exists() and not path.is_dir():
        raise FFGymError(f"--out {path}: is a file, must be a folder; choose another name.")
    return path


def file_of_each(out: Path, names: Sequence[str]) -> dict[str, Path]:
    """A file for each of some names, which may hold anything: with the name before the suffix, if there are several.

    Raises:
        FFGymError: if two would be the same.
    """
    if len(names) == 1:
        return {names[0]: out}
    plain = {name: re.sub(r"[^\w.-]", "_", name) for name in names}
    files = {name: out.with_stem(f"{out.stem}_{word}") for name, word in plain.items()}
    if len(set(files.values())) < len(names):
        raise FFGymError(
            f"--out {out}: {', '.join(names)} would be written to the same file. Write them one at a time, each with "
            "its own --out."
        )
    return files


def write_numbers(config: Any, numbers: Mapping[str, Any]) -> None:
    """Write the file of `--json`, if it is given."""
    if config.json is not None:
        write_json(config.json, numbers)


def print_places(**places: Path | str | None) -> None:
    """Print where files are that were written, a line for each; None is none."""
    for what, place in places.items():
        if place is not None:
            print(f"{what}: {place}")


def provenance(
    command: str,
    config: Any,
    robot: str,
    fingerprint: str | None,
    seed: int | None,
    *,
    passing: Sequence[str] = (),
) -> dict[str, Any]:
    """Origin of numbers, for JSON.

    Args:
        command: e.g. 'ffgym demo'.
        config: the dataclass of its options.
        robot: name.
        fingerprint: of the simulated physics; None where nothing can be simulated.
        seed: None where nothing is random.
        passing: options that only say where results go and how they are made, and are left out, as `yes` always is.
    """
    passing = (*passing, "yes")
    return {
        "command": command,
        "command_line": write_command(command, config, passing=passing),
        "config": {name: _plain(value) for name, value in asdict(config).items() if name not in passing},
        "robot": robot,
        "seed": seed,
        "versions": versions(),
        "physics_fingerprint": fingerprint,
    }


def write_command(command: str, config: Any, *, passing: Sequence[str] = ()) -> str:
    """Write the line that runs a command again: its arguments, then the options that differ from their defaults.

    Args:
        command: e.g. 'ffgym demo'.
        config: the dataclass of its options.
        passing: options that are left out.
    """
    hints = get_type_hints(type(config), include_extras=True)
    arguments, options = list[str](), list[str]()
    for field in fields(config):
        value = getattr(config, field.name)
        if field.name in passing or value is None or value == field.default:
            continue
        words = [str(entry) for entry in (value if isinstance(value, tuple) else [value])]
        markers = getattr(hints[field.name], "__metadata__", ())
        option = next((name for marker in markers if (name := getattr(marker, "name", None))), field.name)
        option = option.replace("_", "-")
        if tyro.conf.Positional in markers:
            arguments += words
        elif isinstance(value, bool):
            options.append(f"--{option}" if value else f"--no-{option}")
        else:
            options += [f"--{option}", *words]
    return shlex.join([*command.split(), *arguments, *options])


PACKAGE = Path(str(resources.files("ffgym")))
"""Folder of the files that come with the package."""


def hash_inputs(names: Iterable[str | Path | None]) -> list[str]:
    """Write name and SHA-256 of each input file, in the order given; folders stand for the files in them.

    Args:
        names: files, folders and built-in robots; other names that are no files are left out.
    """
    files: list[Path] = []
    for name in names:
        if name is None:
            continue
        path = _file_in_package(str(name)) or Path(name)
        files += sorted(path.iterdir()) if path.is_dir() else [path]
    hashes = []
    for file in dict.fromkeys(file for file in files if file.is_file()):
        shown = file.relative_to(PACKAGE.parent) if file.is_relative_to(PACKAGE) else file
        with open(file, "rb") as stream:
            hashes.append(f"{shown} sha256:{hashlib.file_digest(stream, 'sha256').hexdigest()}")
    return hashes


def _file_in_package(robot: str) -> Path | None:
    """File of a built-in robot, or of one of its parameter sets."""
    for folder, names in (("data", builtin_robots()), ("parameters", builtin_parameters())):
        if robot in names:
            return PACKAGE / "robot" / folder / f"{robot}.toml"
    return None


def _plain(value: Any) -> Any:
    if isinstance(value, tuple):
        return [_plain(entry) for entry in value]
    return str(value) if isinstance(value, Path) else value
