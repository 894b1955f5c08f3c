"""All families by name: what each may know, and how a member is made, trained where it learns."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Literal

from ffgym.agents.bspline import ExtendedBSN, StaticBSN
from ffgym.agents.common.law_files import load_law
from ffgym.agents.common.trials import SimulatedTrial, Trial
from ffgym.agents.elastic import elastic_law
from ffgym.agents.feedback_error import trained_mlp
from ffgym.agents.fitting.narx_fit import trained_narx
from ffgym.agents.fitting.residual_fit import trained_residual_torque
from ffgym.agents.iterative import motor_law, tool_law
from ffgym.agents.lugre import dynamic_lugre, static_lugre
from ffgym.agents.model import model_law
from ffgym.agents.oracle import oracle_law
from ffgym.agents.splines.recipes import trained_as_in_thesis, trained_with_prior
from ffgym.control import FeedForwardLaw, NoCompensation
from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.provenance import installed
from ffgym.paths import Reference
from ffgym.robot import RigidArm, RobotDescription
from ffgym.simulation.plant import Machine, load_machine

Track = Literal["causal", "causal, nominal parameters", "per task", "oracle"]
"""What a family may know: nothing but its trials; the nominal model too; trials of the very task; the truth."""


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


@dataclass(frozen=True, kw_only=True)
class Entry:
    """One member of a family, as in tables and on the leaderboard."""

    name: str
    """Also the name of its law."""
    title: str
    track: Track
    page: str
    """Its page below docs/agents."""
    make: Callable[[Setting], FeedForwardLaw] = field(repr=False)
    """Make the law; learning families run their trials here."""
    needs_arm: bool = False
    """Whether it works only on a robot with a tool (TCP)."""
    package: str | None = None
    """Package that it needs to learn, beside those of the core."""
    takes_machine: bool = False
    """Whether a machine file may follow its name after a colon; without one it knows the nominal model."""

    @property
    def is_available(self) -> bool:
        """Whether all that it needs is installed."""
        return self.package is None or installed(self.package)


_ENTRIES = (
    Entry(
        name="none",
        title="no compensation",
        track="causal",
        page="README.md",
        make=lambda setting: NoCompensation(),
    ),
    Entry(
        name="lugre_static",
        title="static LuGre",
        track="causal, nominal parameters",
        page="lugre.md",
        make=lambda setting: static_lugre(setting.robot),
    ),
    Entry(
        name="lugre_dynamic",
        title="dynamic LuGre",
        track="causal, nominal parameters",
        page="lugre.md",
        make=lambda setting: dynamic_lugre(setting.robot),
    ),
    Entry(
        name="bsn_static",
        title="static B-spline network",
        track="causal",
        page="bspline.md",
        make=lambda setting: trained_as_in_thesis(StaticBSN, setting.arm, setting.trial),
    ),
    Entry(
        name="bsn_extended",
        title="extended B-spline network",
        track="causal",
        page="bspline.md",
        make=lambda setting: trained_as_in_thesis(ExtendedBSN, setting.arm, setting.trial),
    ),
    Entry(
        name="bsn_extended_prior",
        title="extended B-spline network with prior",
        track="causal",
        page="bspline.md",
        make=lambda setting: trained_with_prior(setting.arm, setting.trial, "bsn_extended_prior"),
    ),
    Entry(
        name="mlp_fel",
        title="perceptron, feedback-error learning",
        track="causal, nominal parameters",
        page="feedback_error.md",
        make=lambda setting: trained_mlp(setting.arm, setting.trial, setting.seed),
        package="torch",
    ),
    Entry(
        name="narx",
        title="NARX network",
        track="causal",
        page="narx.md",
        make=lambda setting: trained_narx(setting.arm, setting.trial, setting.seed),
    ),
    Entry(
        name="residual_gp",
        title="residual torque model",
        track="causal",
        page="residual_torque.md",
        make=lambda setting: trained_residual_torque(setting.arm, setting.trial),
        package="scikit-learn",
    ),
    Entry(
        name="ilc_motor",
        title="iterative learning on motor positions",
        track="per task",
        page="iterative.md",
        make=lambda setting: motor_law(setting.arm, setting.references, setting.trial),
    ),
    Entry(
        name="ilc_tcp",
        title="iterative learning on the tool's position",
        track="per task",
        page="iterative.md",
        make=lambda setting: tool_law(setting.arm, setting.references, setting.trial, setting.controller),
        needs_arm=True,
    ),
    Entry(
        name="elastic",
        title="elastic feed-forward",
        track="causal, nominal parameters",
        page="elastic.md",
        make=lambda setting: elastic_law(setting.arm, setting.controller),
    ),
    Entry(
        name="model",
        title="feed-forward from a machine file",
        track="causal, nominal parameters",
        page="model.md",
        make=lambda setting: model_law(Machine(robot=setting.robot), setting.controller or setting.arm),
        takes_machine=True,
    ),
    Entry(
        name="oracle",
        title="elastic feed-forward with the true parameters",
        track="oracle",
        page="oracle.md",
        make=lambda setting: oracle_law(setting.truth, setting.controller or setting.arm),
    ),
)

CATALOGUE: Mapping[str, Entry] = MappingProxyType({entry.name: entry for entry in _ENTRIES})
"""Every family member, in the order of tables."""


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
    if machine is None:
        return entry.make(setting)
    return model_law(machine, setting.controller or setting.arm, name=_name_of(name))


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
