"""Feed-forward laws that a command line names: refused before any is made, then made for a robot and its motions."""

from collections.abc import Sequence
from pathlib import Path

from ffgym.agents.catalogue import CATALOGUE, find_law_name, make_law
from ffgym.agents.declaration import AgentSetting
from ffgym.agents.trials import RigTrial
from ffgym.cli.progress import progress_bar
from ffgym.control import FeedForwardLaw
from ffgym.core.errors import FFGymError
from ffgym.paths import Reference
from ffgym.robot import RigidArm, with_parameters
from ffgym.simulation import Rig, SimulatedRig


def check_laws(names: Sequence[str], option: str) -> list[str]:
    """Names of the laws that the `option` asks for: of entries, machine files, learned laws; some take minutes to make.

    Raises:
        FFGymError: if there is none, one is unknown or cannot be read, or two have one name.
    """
    if not names:
        raise FFGymError(f"There is no agent to run. Name some, e.g. {option} none elastic; {', '.join(CATALOGUE)}.")
    if len(set(names)) < len(names):
        raise FFGymError(f"Agents must have different names, got {' '.join(names)}.")
    own = [find_law_name(name) for name in names]
    if len(set(own)) < len(own):
        raise FFGymError(f"Laws must have different names; those of {' '.join(names)} are {', '.join(own)}.")
    return own


def setting_for(rig: Rig, references: Sequence[Reference], parameters: Path | None, n_threads: int) -> AgentSetting:
    """Give families what they make laws from: a machine on a rig, its motions, and the agents' model of it.

    Args:
        rig: where motions are run, under a controller that stays what it is.
        references: motions that will be run.
        parameters: file of parameters in which the agents' model differs from the controller's; None if it does not.
        n_threads: threads of the simulation.
    """
    trial = RigTrial(rig=rig, n_threads=n_threads)
    truth = None
    if isinstance(rig, SimulatedRig):
        truth = rig.robot if rig.machine is None else rig.machine.truth
    if parameters is None:
        return AgentSetting(arm=rig.arm, trial=trial, references=references, truth=truth)
    model = RigidArm(with_parameters(rig.robot, parameters))
    return AgentSetting(arm=model, controller=rig.arm, trial=trial, references=references, truth=truth)


def make_laws(names: Sequence[str], setting: AgentSetting) -> list[FeedForwardLaw]:
    """Laws by the names that `check_laws` accepts; those that learn are trained here."""
    laws = []
    with progress_bar("making agents", "agents") as progress:
        for i, name in enumerate(names):
            progress(i, len(names))
            laws.append(make_law(name, setting))
    return laws
