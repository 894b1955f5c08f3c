"""Declaration of an agent, beside its code: its name, title, track and look, and how its law is made and read."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from ffgym.agents.law_files import load_law
from ffgym.agents.trials import SimulatedTrial, Trial
from ffgym.control import FeedForwardLaw, LawStyle, Policy, SetpointChannel
from ffgym.control.style import STYLES
from ffgym.core.errors import FFGymError
from ffgym.core.provenance import is_installed
from ffgym.paths import Reference
from ffgym.robot import RigidArm, RobotDescription
from ffgym.simulation.plant import Machine

Track = Literal["causal", "causal, nominal parameters", "per task", "oracle"]
"""Knowledge of an agent: its trials alone; the nominal model too; trials of the very task; the true parameters."""


@dataclass(frozen=True, kw_only=True, eq=False)
class AgentSetting:
    """Robot, trials and motions that a family makes a law from."""

    arm: RigidArm
    """Nominal model of the robot, on which a controller relies."""
    controller: RigidArm | None = None
    """Model behind the existing controller, its servo and rigid feed-forward; defaults to `arm`."""
    trial: Trial
    """Trial procedure that runs motions on the machine."""
    references: Sequence[Reference] = ()
    """Motions that the law will be run on; per-task families learn on them, others must not read them."""
    truth: RobotDescription | None = None
    """The machine's true parameters, for the oracle alone; None if they are shut away."""
    seed: int = 0
    """Seed of first weights that are drawn; noise of sensors has the seed of the trial."""

    @classmethod
    def of(cls, robot: RobotDescription, references: Sequence[Reference] = (), n_threads: int = 0) -> "AgentSetting":
        """Make the setting of a simulated robot whose nominal model is its own description."""
        arm = RigidArm(robot)
        trial = SimulatedTrial(arm=arm, n_threads=n_threads)
        return cls(arm=arm, trial=trial, references=references, truth=robot)

    @property
    def robot(self) -> RobotDescription:
        """Nominal description."""
        return self.arm.robot


@dataclass(frozen=True, kw_only=True, eq=False)
class AgentEntry:
    """Declaration of one agent. Only `make` or `load` has to do with how it works."""

    name: str
    """Name of the agent and of its law."""
    title: str
    about: str
    """One sentence for the leaderboard: method, and data that it learned from."""
    track: Track
    order: float
    """Place in tables, ascending: those of this package have 0 to 100, the oracle last."""
    page: str | None = None
    """Page below docs/agents."""
    style: LawStyle | None = None
    """Style in figures; defaults to a spare one."""
    make: Callable[[AgentSetting], FeedForwardLaw] | None = field(default=None, repr=False)
    """Function that makes the law; learning families run their trials in it. None: it exists as artefacts only."""
    make_from: Callable[[Machine, AgentSetting, str], FeedForwardLaw] | None = field(default=None, repr=False)
    """Function that makes a law, with a name, from a machine file (name:FILE); None: the agent takes no file."""
    load: Callable[[Path, RigidArm], FeedForwardLaw | Policy] | None = field(
        default=lambda path, arm: load_law(path), repr=False
    )
    """Function that reads an artefact of agents/trained, for a nominal model of the robot; None: `make` reads it, and
    adapts it to the machine by trials."""
    feedback: bool = False
    """True if it observes present errors of the motors: track with feedback. A feed-forward policy runs in an
    environment that shows none."""
    channel: SetpointChannel | None = None
    """Set-point channel through which its law acts on the leaderboard; None adds its torque."""
    needs_arm: bool = False
    """True if it works only on a robot with a tool (TCP)."""
    package: str | None = None
    """Package needed for learning, beside those of the core."""
    learns: bool = False
    """True if `scripts.train_laws` trains it with several seeds and agents/trained holds the results."""
    seeded: bool = False
    """True if a seed changes an agent that has no artefacts."""
    base: str | None = None
    """Name of the law below a residual policy."""
    ranked: bool = True
    on_commands: bool = True
    """True if commands make it by its name."""
    on_leaderboard: bool = True

    @property
    def takes_machine(self) -> bool:
        """True if a machine file may follow the name after a colon; without one the law has the nominal model."""
        return self.make_from is not None

    @property
    def is_available(self) -> bool:
        """True if the package that learning needs is installed."""
        return self.package is None or is_installed(self.package)


DECLARED: dict[str, AgentEntry] = {}
"""All agents declared so far, by name."""


def declare(*entries: AgentEntry) -> None:
    """Register agents by their names, for tables, figures, commands and the leaderboard.

    Raises:
        FFGymError: if there is an agent of that name.
    """
    for entry in entries:
        if entry.name in DECLARED:
            raise FFGymError(f"There is an agent {entry.name!r} already; declare yours with another name.")
        DECLARED[entry.name] = entry
        if entry.style is not None:
            STYLES[entry.name] = entry.style
