"""All agents by name. Each is declared beside its code (`ffgym.agents.declaration`).

This module knows no family: those of this package stand in `ffgym.agents.families`, those of other packages are found
by entry points in the group 'ffgym.agents'; both are imported when the catalogue is first asked (docs/extending.md).
"""

from collections.abc import Iterator, Mapping
from pathlib import Path

from ffgym.agents.declaration import DECLARED, Entry, Setting
from ffgym.agents.law_files import load_law
from ffgym.control import FeedForwardLaw
from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.plugins import load_families
from ffgym.simulation.plant import Machine, load_machine


def declared() -> list[Entry]:
    """Every agent, in the order of tables.

    Raises:
        FFGymError: if a package that declares some cannot be imported.
    """
    load_families("ffgym.agents")
    return sorted(DECLARED.values(), key=lambda entry: entry.order)


class Catalogue(Mapping[str, Entry]):
    """Agents that commands make by their names, in the order of tables; found when first asked for."""

    def _members(self) -> dict[str, Entry]:
        return {entry.name: entry for entry in declared() if entry.make is not None and entry.on_commands}

    def __getitem__(self, name: str) -> Entry:
        return self._members()[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._members())

    def __len__(self) -> int:
        return len(self._members())


CATALOGUE = Catalogue()
"""Every agent that commands make by its name."""


def entry_of(name: str) -> Entry:
    """Entry by name.

    Raises:
        FFGymError: if there is none.
    """
    return CATALOGUE[check_choice("agent", name, list(CATALOGUE))]


def law_named(name: str, setting: Setting) -> FeedForwardLaw:
    """Law of a catalogue entry, made for `setting`; of a machine file, as in model:machine.toml; or of a file .npz.

    Raises:
        FFGymError: if there is no such entry, or the file cannot be read.
    """
    if name.endswith(".npz"):
        return load_law(name)
    entry, machine, law = _parts(name)
    if machine is not None and entry.make_from is not None:
        return entry.make_from(machine, setting, law)
    assert entry.make is not None  # see Catalogue
    return entry.make(setting)


def name_of_law(name: str) -> str:
    """Name of the law that `law_named` makes, without making it.

    Raises:
        FFGymError: if there is no such entry, or the file cannot be read.
    """
    return load_law(name).name if name.endswith(".npz") else _parts(name)[-1]


def _parts(name: str) -> tuple[Entry, Machine | None, str]:
    """Entry, the machine in the file that follows its name, and the name of the law."""
    kind, colon, file = name.partition(":")
    entry = entry_of(kind)
    if colon and not entry.takes_machine:
        takers = [f"{known}:FILE" for known, each in CATALOGUE.items() if each.takes_machine]
        raise FFGymError(f"Agent {kind!r} takes no file, got {name!r}; {', '.join(takers)} does.")
    return entry, load_machine(file) if colon else None, f"{kind}{colon}{Path(file).stem}"
