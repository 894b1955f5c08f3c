"""Feed-forward laws that a command line names: refused before any is made, then made for a robot and its motions."""

from collections.abc import Sequence
from pathlib import Path

from agents.catalogue import CATALOGUE, Setting, entry_of, law_named
from agents.common.law_files import load_law
from agents.common.trials import SimulatedTrial
from ffgym.cli.progress import progress_bar
from ffgym.control import FeedForwardLaw, Reference
from ffgym.errors import FFGymError
from ffgym.robot import ModelOptions, RigidArm, with_parameters


def check_laws(names: Sequence[str], option: str) -> list[str]:
    """Names of the laws of catalogue entries and files, which the `option` asks for; some take minutes to make.

    Raises:
        FFGymError: if there is none, one is unknown or cannot be read, or two have one name.
    """
    if not names:
        raise FFGymError(f"There is no agent to run. Name some, e.g. {option} none elastic; {', '.join(CATALOGUE)}.")
    if len(set(names)) < len(names):
        raise FFGymError(f"Agents must have different names, got {' '.join(names)}.")
    own = [load_law(name).name if name.endswith(".npz") else entry_of(name).name for name in names]
    if len(set(own)) < len(own):
        raise FFGymError(f"Laws must have different names; those of {' '.join(names)} are {', '.join(own)}.")
    return own


def setting_for(
    arm: RigidArm,
    references: Sequence[Reference],
    parameters: Path | None,
    n_threads: int,
    options: ModelOptions | None = None,
) -> Setting:
    """What families make laws from: a simulated robot, its motions, and the model that the agents have of it.

    Args:
        arm: of the simulated robot, whose servo and rigid feed-forward stay what they are.
        references: motions that will be run.
        parameters: file of parameters in which the agents' model differs from the robot; None if it does not.
        n_threads: threads of the simulation.
        options: what to leave out of the simulated robot.
    """
    trial = SimulatedTrial(arm=arm, options=options, n_threads=n_threads)
    if parameters is None:
        return Setting(arm=arm, trial=trial, references=references)
    model = RigidArm(with_parameters(arm.robot, parameters))
    return Setting(arm=model, controller=arm, trial=trial, references=references, truth=arm.robot)


def make_laws(names: Sequence[str], setting: Setting) -> list[FeedForwardLaw]:
    """Laws by the names that `check_laws` accepts; those that learn are trained here."""
    laws = []
    with progress_bar("making agents", "agents") as progress:
        for i, name in enumerate(names):
            progress(i, len(names))
            laws.append(law_named(name, setting))
    return laws
