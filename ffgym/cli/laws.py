"""Laws and policies that a command line names: refused before any is made, then made for a robot and its motions."""

from collections.abc import Sequence
from pathlib import Path

from ffgym.agents.artefacts import ANYWHERE, locate_artefact, read_manifest
from ffgym.agents.catalogue import CATALOGUE, find_law_name, list_entries, make_law
from ffgym.agents.declaration import AgentSetting
from ffgym.agents.law_files import load_law, unpack
from ffgym.agents.residual.policy import KIND, load_policy
from ffgym.agents.submission import LOADERS
from ffgym.agents.trials import RigTrial
from ffgym.cli.progress import progress_bar
from ffgym.control import FeedForwardLaw, Policy
from ffgym.core.errors import FFGymError, check_choice
from ffgym.leaderboard.submission.entrant import load_submission
from ffgym.paths import Reference
from ffgym.robot import RigidArm, builtin_robots, with_parameters
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


def make_agent(name: str, setting: AgentSetting, fingerprint: str) -> tuple[str, FeedForwardLaw | Policy]:
    """Return the title of an agent, and the agent: a law, which runs along whole motions, or a policy, which observes.

    A trained agent of the leaderboard is read, with its first seed, if it learned on this machine or may run on any;
    other agents that learn are trained here.

    Args:
        name: of docs/agents or of a row of the leaderboard, model:<machine file>, a file of a law or a policy (.npz),
            or a submission (.zip).
        setting: the machine, and the motions to come.
        fingerprint: fingerprint of the physics of the machine.

    Raises:
        FFGymError: if there is no such agent, its file cannot be read, or it was not trained for this machine.
    """
    if name.endswith(".zip"):
        robot = check_choice("built-in robot of a submission", setting.robot.name, builtin_robots())
        return load_submission(Path(name), robot, LOADERS)
    if name.endswith(".npz"):
        return Path(name).stem, load_policy(name) if unpack(name)[0].get("kind") == KIND else load_law(name)
    # rows of the leaderboard
    kind = name.partition(":")[0]
    entries = {entry.name: entry for entry in list_entries() if entry.name in CATALOGUE or read_manifest(entry.name)}
    entry, manifest = entries[check_choice("agent", kind, list(entries))], read_manifest(kind)
    for artefact in () if manifest is None or kind != name else manifest.artefacts:
        if artefact.plant == ANYWHERE or artefact.fingerprint == fingerprint:
            return entry.title, entry.load(locate_artefact(kind, artefact), setting.arm)
    if entry.name not in CATALOGUE:
        raise FFGymError(f"Agent {name!r} was trained on another machine, and cannot be trained here.")
    return (entry.title if kind == name else name), make_law(name, setting)
