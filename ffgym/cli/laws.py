"""Laws and policies that a command line names: refused before any is made, then made for a robot and its motions."""

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

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
from ffgym.envs.settings import ERROR_LIMIT
from ffgym.leaderboard.evaluation.closed_loop import run_references
from ffgym.leaderboard.submission.entrant import load_submission
from ffgym.leaderboard.submission.process import isolation_note
from ffgym.paths import Reference
from ffgym.recordings import Recording
from ffgym.robot import RigidArm, with_parameters
from ffgym.simulation import RECORD_DT, Rig, SimulatedRig
from ffgym.studies.selection import record_all


def check_laws(names: Sequence[str], option: str, *, policies: bool = False) -> list[str]:
    """Names of the laws that the `option` asks for: of entries, machine files, learned laws; some take minutes to make.

    Args:
        names: as they are given.
        option: option that they are given with.
        policies: True if it takes what `record_agents` runs, policies too.

    Raises:
        FFGymError: if there is none, one is unknown or cannot be read, or two have one name.
    """
    if not names:
        raise FFGymError(f"There is no agent to run. Name some, e.g. {option} none elastic; {', '.join(CATALOGUE)}.")
    if len(set(names)) < len(names):
        raise FFGymError(f"Agents must have different names, got {' '.join(names)}.")
    own = [_find_name(name) if policies else find_law_name(name) for name in names]
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


def is_trained(name: str) -> bool:
    """Check if only `make_agent` makes an agent: a policy, a submission, or a row that was trained before."""
    if name.endswith(".npz"):
        return unpack(name)[0].get("kind") == KIND
    return name.endswith(".zip") or (name not in CATALOGUE and read_manifest(name) is not None)


def _find_name(name: str) -> str:
    """Find the name of an agent in tables."""
    if not is_trained(name):
        return find_law_name(name)
    return Path(name).stem if name.endswith((".npz", ".zip")) else name


def make_agent(
    name: str, setting: AgentSetting, *, controller: str, fingerprint: str
) -> tuple[str, FeedForwardLaw | Policy]:
    """Return the title of an agent, and the agent: a law, which runs along whole motions, or a policy, which observes.

    A trained agent of the leaderboard is read, with its first seed, if it learned on this machine or may run on any. An
    adapter practises one lap on the machine. Other agents that learn are trained here.

    Args:
        name: of docs/agents, of a row of the leaderboard or of an adapter, model:<machine file>, a file of a law or a
            policy (.npz), or a submission (.zip).
        setting: the machine, and the motions to come.
        controller: name of the nominal robot of the machine's controller, which a submission has too.
        fingerprint: fingerprint of the physics of the machine.

    Raises:
        FFGymError: if there is no such agent, its file cannot be read, or it was not trained for this machine.
    """
    if name.endswith(".zip"):
        if (note := isolation_note()) is not None:
            print(f"note: {note}", file=sys.stderr)
        return load_submission(Path(name), controller, LOADERS)
    if name.endswith(".npz"):
        return Path(name).stem, load_policy(name) if unpack(name)[0].get("kind") == KIND else load_law(name)
    # rows of the leaderboard
    kind = name.partition(":")[0]
    entries = {entry.name: entry for entry in list_entries() if entry.name in CATALOGUE or read_manifest(entry.name)}
    entry, manifest = entries[check_choice("agent", kind, list(entries))], read_manifest(kind)
    for artefact in () if manifest is None or kind != name or entry.load is None else manifest.artefacts:
        if artefact.plant == ANYWHERE or artefact.fingerprint == fingerprint:
            assert entry.load is not None  # as it has artefacts here
            return entry.title, entry.load(locate_artefact(kind, artefact), setting.arm)
    if entry.name not in CATALOGUE:
        raise FFGymError(f"Agent {name!r} was trained on another machine, and cannot be trained here.")
    return (entry.title if kind == name else name), make_law(name, setting)


def record_agents(
    names: Sequence[str],
    rig: Rig,
    references: Mapping[Any, Reference],
    setting: AgentSetting,
    *,
    controller: str,
    seed: int,
    record_dt: float = RECORD_DT,
    n_threads: int = 0,
) -> dict[Any, Recording]:
    """Record every motion with every agent, by the agent's name and the parts of the motion's key; laws come first.

    Laws run along whole motions on the rig; policies act in an environment with the same machine.

    Args:
        names: names that `check_laws` accepts with policies.
        rig: where motions are run; with policies, a machine without parts left out.
        references: motions by key.
        setting: what families make laws from.
        controller: name of the nominal robot of the rig's controller.
        seed: seed of the sensors' noise.
        record_dt: sample time of the recordings [s].
        n_threads: threads of the simulation.

    Raises:
        FFGymError: if an agent cannot be made or run here, or stops the robot.
    """
    agents: dict[str, FeedForwardLaw | Policy] = {}
    with progress_bar("making agents", "agents") as progress:
        for name in names:
            progress(len(agents), len(names))
            agents[_find_name(name)] = (
                make_agent(name, setting, controller=controller, fingerprint=rig.fingerprint)[1]
                if is_trained(name)
                else make_law(name, setting)
            )
    laws = [agent for agent in agents.values() if isinstance(agent, FeedForwardLaw)]
    recordings: dict[Any, Recording] = {}
    with progress_bar("simulating", "s") as progress:
        options: dict[str, Any] = {"seed": seed, "record_dt": record_dt, "n_threads": n_threads, "progress": progress}
        if laws:
            recordings |= record_all(rig, references, laws, **options)
        for name, agent in agents.items():
            if isinstance(agent, FeedForwardLaw):
                continue
            try:
                found = run_references(rig, agent, [*references.values()], **options)
            except FFGymError as error:
                raise FFGymError(f"{name} cannot run on {rig.robot.name}: {error}") from error
            for (key, reference), recording in zip(references.items(), found, strict=True):
                if recording is None:
                    raise FFGymError(
                        f"{name} stops the robot on {reference.name}: the error of a motor passes {ERROR_LIMIT} rad, "
                        f"so that there is nothing to compare. Leave it out."
                    )
                recordings[name, *(key if isinstance(key, tuple) else (key,))] = recording
    return recordings


def refuse_with_policies(names: Sequence[str], given: Sequence[str]) -> None:
    """Refuse options that policies cannot follow.

    Raises:
        FFGymError: if some are `given`, and a name is that of a policy.
    """
    policies = [name for name in names if is_trained(name)]
    if policies and given:
        raise FFGymError(f"{given[0]} has no effect on {policies[0]}, which was trained before; leave one of them out.")
