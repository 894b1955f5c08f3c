"""All agents by name. Each is declared beside its code, by `declare`, with all that tables and commands want of it.

This module knows no family: those of this package stand in `ffgym.agents.families`, those of other packages are found
by entry points in the group 'ffgym.agents'; both are imported when the catalogue is first asked (docs/extending.md).
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from ffgym.agents.law_files import load_law
from ffgym.agents.trials import SimulatedTrial, Trial
from ffgym.control import FeedForwardLaw, Policy
from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.plugins import load_families
from ffgym.core.provenance import installed
from ffgym.paths import Reference
from ffgym.report.laws import STYLES, LawStyle
from ffgym.robot import RigidArm, RobotDescription
from ffgym.simulation.plant import Machine, load_machine

Track = Literal["causal", "causal, nominal parameters", "per task", "oracle"]
"""What an agent may know: nothing but its trials; the nominal model too; trials of the very task; the truth."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Setting:
    """What a family gets to make a law from."""

    arm: RigidArm
    """Nominal model of the robot: what a controller knows."""
    controller: RigidArm | None = None
    """What the robot's existing controller was made for, its servo and rigid feed-forward; None is `arm`."""
    trial: Trial
    """Runs motions on the machine."""
    references: Sequence[Reference] = ()
    """Motions the law will be run on; per-task families learn on them, others must not look."""
    truth: RobotDescription | None = None
    """The machine's true parameters, for the oracle alone; None if nobody may know them."""
    seed: int = 0
    """Of first weights that are drawn; noise of sensors has the seed of the trial."""

    @classmethod
    def of(cls, robot: RobotDescription, references: Sequence[Reference] = (), n_threads: int = 0) -> "Setting":
        """A simulated robot whose nominal model is its own description."""
        arm = RigidArm(robot)
        trial = SimulatedTrial(arm=arm, n_threads=n_threads)
        return cls(arm=arm, trial=trial, references=references, truth=robot)

    @property
    def robot(self) -> RobotDescription:
        """Nominal description."""
        return self.arm.robot


def _stored(path: Path, arm: RigidArm) -> FeedForwardLaw:
    return load_law(path)


@dataclass(frozen=True, kw_only=True, eq=False)
class Entry:
    """Declaration of one agent. Only `make` or `load` has to do with how it works."""

    name: str
    """Also the name of its law."""
    title: str
    about: str
    """One sentence for the leaderboard: what it does, and what it learned from."""
    track: Track
    order: float
    """Place in tables, ascending: those of this package have 0 to 100, the oracle last."""
    page: str | None = None
    """Its page below docs/agents."""
    style: LawStyle | None = None
    """Look in figures; None takes a spare one."""
    make: Callable[[Setting], FeedForwardLaw] | None = field(default=None, repr=False)
    """Makes the law; learning families run their trials here. None is an agent that only its artefacts have."""
    make_from: Callable[[Machine, Setting, str], FeedForwardLaw] | None = field(default=None, repr=False)
    """Makes the law of a machine file that follows the name after a colon, with a name for it; None takes no file."""
    load: Callable[[Path, RigidArm], FeedForwardLaw | Policy] = field(default=_stored, repr=False)
    """Reads an artefact of agents/trained, for a nominal model of the robot."""
    needs_arm: bool = False
    """Whether it works only on a robot with a tool (TCP)."""
    package: str | None = None
    """Package that it needs to learn, beside those of the core."""
    learns: bool = False
    """Whether `scripts.train_laws` trains it with several seeds, and agents/trained has what it learned."""
    seeded: bool = False
    """Whether a seed changes an agent that has no artefacts."""
    base: str | None = None
    """Name of the law below a residual policy."""
    ranked: bool = True
    on_commands: bool = True
    """Whether commands make it by its name."""
    on_leaderboard: bool = True

    @property
    def takes_machine(self) -> bool:
        """Whether a machine file may follow its name after a colon; without one it knows the nominal model."""
        return self.make_from is not None

    @property
    def is_available(self) -> bool:
        """Whether all that it needs is installed."""
        return self.package is None or installed(self.package)


_DECLARED: dict[str, Entry] = {}


def declare(*entries: Entry) -> None:
    """Make agents known by their names, in tables, figures, commands and on the leaderboard.

    Raises:
        FFGymError: if there is an agent of that name.
    """
    for entry in entries:
        if entry.name in _DECLARED:
            raise FFGymError(f"There is an agent {entry.name!r} already; declare yours with another name.")
        _DECLARED[entry.name] = entry
        if entry.style is not None:
            STYLES[entry.name] = entry.style


def declared() -> list[Entry]:
    """Every agent, in the order of tables.

    Raises:
        FFGymError: if a package that declares some cannot be imported.
    """
    load_families("ffgym.agents")
    return sorted(_DECLARED.values(), key=lambda entry: entry.order)


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
    entry, machine = _parts(name)
    if machine is not None and entry.make_from is not None:
        return entry.make_from(machine, setting, _name_of(name))
    assert entry.make is not None  # see Catalogue
    return entry.make(setting)


def name_of_law(name: str) -> str:
    """Name of the law that `law_named` makes, without making it.

    Raises:
        FFGymError: if there is no such entry, or the file cannot be read.
    """
    if name.endswith(".npz"):
        return load_law(name).name
    _parts(name)
    return _name_of(name)


def _parts(name: str) -> tuple[Entry, Machine | None]:
    """Entry, and the machine in the file that follows its name."""
    kind, colon, file = name.partition(":")
    entry = entry_of(kind)
    if colon and not entry.takes_machine:
        takers = [f"{known}:FILE" for known, each in CATALOGUE.items() if each.takes_machine]
        raise FFGymError(f"Agent {kind!r} takes no file, got {name!r}; {', '.join(takers)} does.")
    return entry, load_machine(file) if colon else None


def _name_of(name: str) -> str:
    kind, colon, file = name.partition(":")
    return f"{kind}{colon}{Path(file).stem}"
