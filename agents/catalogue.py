"""All agents by name. Each is declared beside its code (`ffgym.agents.declaration`).

Families of this package stand in `ffgym.agents.families`; families of other packages are found by entry points in the
group 'ffgym.agents'. Both are imported when the catalogue is first read (docs/extending.md).
"""

from collections.abc import Iterator, Mapping
from pathlib import Path

from ffgym.agents.declaration import DECLARED, AgentEntry, AgentSetting
from ffgym.agents.law_files import load_law
from ffgym.control import FeedForwardLaw
from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.plugins import load_families
from ffgym.simulation.plant import Machine, load_machine


def list_entries() -> list[AgentEntry]:
    """List every agent, in the order of tables.

    Raises:
        FFGymError: if a package that declares some cannot be imported.
    """
    load_families("ffgym.agents")
    return sorted(DECLARED.values(), key=lambda entry: entry.order)


class AgentCatalogue(Mapping[str, AgentEntry]):
    """Agents that commands make by their names, in the order of tables; found when first read."""

    def _members(self) -> dict[str, AgentEntry]:
        return {entry.name: entry for entry in list_entries() if entry.make is not None and entry.on_commands}

    def __getitem__(self, name: str) -> AgentEntry:
        return self._members()[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._members())

    def __len__(self) -> int:
        return len(self._members())


CATALOGUE = AgentCatalogue()
"""Every agent that commands make by its name."""


def find_entry(name: str) -> AgentEntry:
    """Return the entry of an agent.

    Raises:
        FFGymError: if there is no agent of that name.
    """
    return CATALOGUE[check_choice("agent", name, list(CATALOGUE))]


def make_law(name: str, setting: AgentSetting) -> FeedForwardLaw:
    """Make a law for `setting` from the name of an agent, model:machine.toml, or a learned law in a file .npz.

    Raises:
        FFGymError: if there is no such entry, or the file cannot be read.
    """
    if name.endswith(".npz"):
        return load_law(name)
    entry, machine, law = _parts(name)
    if machine is not None and entry.make_from is not None:
        return entry.make_from(machine, setting, law)
    assert entry.make is not None  # see AgentCatalogue
    return entry.make(setting)


def find_law_name(name: str) -> str:
    """Find the name of the law that `make_law` makes, without making it.

    Raises:
        FFGymError: if there is no such entry, or the file cannot be read.
    """
    return load_law(name).name if name.endswith(".npz") else _parts(name)[-1]


def _parts(name: str) -> tuple[AgentEntry, Machine | None, str]:
    """Split a name into its entry, the machine in the file after the colon, and the name of the law."""
    kind, colon, file = name.partition(":")
    entry = find_entry(kind)
    if colon and not entry.takes_machine:
        takers = [f"{known}:FILE" for known, each in CATALOGUE.items() if each.takes_machine]
        raise FFGymError(f"Agent {kind!r} takes no file, got {name!r}; {', '.join(takers)} does.")
    return entry, load_machine(file) if colon else None, f"{kind}{colon}{Path(file).stem}"
