"""Declaration of an agent, beside its code: its name, title, track and look, and how its law is made and read."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from ffgym.agents.law_files import load_law
from ffgym.agents.trials import SimulatedTrial, Trial
from ffgym.control import FeedForwardLaw, LawStyle, Policy
from ffgym.control.style import STYLES
from ffgym.core.errors import FFGymError
from ffgym.core.provenance import installed
from ffgym.paths import Reference
from ffgym.robot import RigidArm, RobotDescription
from ffgym.simulation.plant import Machine

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
    load: Callable[[Path, RigidArm], FeedForwardLaw | Policy] = field(
        default=lambda path, arm: load_law(path), repr=False
    )
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


DECLARED: dict[str, Entry] = {}
"""Every agent that was declared so far, by name."""


def declare(*entries: Entry) -> None:
    """Make agents known by their names, in tables, figures, commands and on the leaderboard.

    Raises:
        FFGymError: if there is an agent of that name.
    """
    for entry in entries:
        if entry.name in DECLARED:
            raise FFGymError(f"There is an agent {entry.name!r} already; declare yours with another name.")
        DECLARED[entry.name] = entry
        if entry.style is not None:
            STYLES[entry.name] = entry.style
