"""Entrants of the leaderboard: every declared agent, read from its artefacts or made on the machine that it runs on."""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from types import MappingProxyType

from ffgym.agents.artefacts import Artefact, ArtefactManifest, locate_artefact, read_manifest
from ffgym.agents.catalogue import list_entries
from ffgym.agents.declaration import AgentEntry, AgentSetting
from ffgym.agents.law_agent import LawPolicy
from ffgym.agents.submission import LOADERS
from ffgym.agents.trials import CountedTrial, RigTrial, Trial, add_sensors
from ffgym.control import (
    CausalLaw,
    FeedForwardLaw,
    Policy,
    SetpointChannel,
    SetpointResponse,
    find_channel,
    sees_errors,
)
from ffgym.core.errors import FFGymError
from ffgym.leaderboard.entrants import Entrant, Maker, ReadyAgent, Registry, one_by_one
from ffgym.leaderboard.plants import DRAW, NOMINAL, TestPlant
from ffgym.leaderboard.submission.entrant import make_entrant
from ffgym.leaderboard.tasks import Task, make_references
from ffgym.simulation.shared_rig import learn_together

REGISTRY = Registry("ffgym.agents.entrants:ENTRANTS", maker="ffgym.agents.entrants:make_submitted")
"""Names by which other processes find the entrants, and the function that makes one of a submission."""
SEEDS = (0, 1, 2, 3, 4)
"""Seeds of every row that a seed changes."""
_PRACTISED = "per task"
"""Track of laws that practise the scored motions."""


def make_submitted(path: Path) -> Entrant:
    """Make the entrant of a submission, see `make_entrant`."""
    return make_entrant(path, LOADERS)


def _entrant(entry: AgentEntry) -> Entrant | None:
    """Make the entrant of an agent, from artefacts if there are some; None if it cannot be made."""
    manifest = read_manifest(entry.name)
    if not entry.on_leaderboard or (entry.make is None and manifest is None):
        return None
    practises = entry.track == _PRACTISED
    # command and seeds without artefacts
    again = f"ffgym leaderboard --agents {entry.name}" if practises else None
    unread = SEEDS if practises or entry.seeded else (0,)
    # the maker: practice on the tasks, a new law for each plant, or an artefact
    ready: Maker
    if practises:
        ready = partial(_practise, entry)
    else:
        ready = one_by_one(partial(_make if manifest is None or entry.load is None else _read, entry, manifest))

    def sha256_of(plant: str, seed: int) -> str | None:
        artefact = _artefact(manifest, plant, seed)
        return None if artefact is None else artefact.sha256

    return Entrant(
        name=entry.name,
        title=entry.title,
        track=entry.track,
        about=entry.about,
        page=entry.page,
        base=entry.base,
        feedback=entry.feedback,
        channel=entry.channel,
        seeds=unread if manifest is None or practises else manifest.seeds,
        command=again if manifest is None else manifest.command,
        ranked=entry.ranked,
        slow=practises,
        artefact=sha256_of,
        learning_curve=lambda: () if manifest is None else manifest.learning_curve,
        ready=ready,
    )


def _make(
    entry: AgentEntry, manifest: ArtefactManifest | None, plant: TestPlant, seed: int, tasks: tuple[Task, ...]
) -> ReadyAgent | None:
    """Make a law from the description, from trials, or from the truth; None where that is shut away."""
    if entry.track == "oracle" and plant.truth is None:
        return None
    assert entry.make is not None  # see _entrant
    trial = CountedTrial(RigTrial(rig=add_sensors(plant.rig), seed=seed))
    law = entry.make(AgentSetting(arm=plant.rig.arm, trial=trial, truth=plant.truth, seed=seed))
    artefact = _artefact(manifest, plant.name, seed)
    return ReadyAgent(
        law=law,
        timed=_run_in_steps(law, entry.channel),
        channel=entry.channel,
        artefact=None if artefact is None else artefact.sha256,
        robot_seconds=trial.robot_seconds,
        env_steps=0 if artefact is None else artefact.env_steps,
    )


def _practise(
    entry: AgentEntry, plant: TestPlant, seeds: Sequence[int], tasks: tuple[Task, ...]
) -> list[ReadyAgent | None]:
    """Let a law practise the tasks through the machine's sensors; all seeds learn side by side."""
    references, make = make_references(plant.rig.arm, tasks), entry.make
    assert make is not None  # see _entrant

    def learn(seed: int, trial: Trial) -> ReadyAgent:
        counted = CountedTrial(trial)
        law = make(AgentSetting(arm=plant.rig.arm, trial=counted, references=references, seed=seed))
        # learned beforehand, so that nothing is timed
        return ReadyAgent(law=law, channel=entry.channel, robot_seconds=counted.robot_seconds)

    found = learn_together(add_sensors(plant.rig), {seed: (seed, partial(learn, seed)) for seed in seeds})
    return [found[seed] for seed in seeds]


def _read(
    entry: AgentEntry, manifest: ArtefactManifest | None, plant: TestPlant, seed: int, tasks: tuple[Task, ...]
) -> ReadyAgent | None:
    """Read a trained agent, on drawn plants the one of the nominal plant; None if it was not trained for a plant."""
    artefact = _artefact(manifest, plant.name, seed)
    if artefact is None:
        return None
    assert entry.load is not None  # see _entrant
    loaded = entry.load(locate_artefact(entry.name, artefact), plant.rig.arm)
    law, policy = (loaded, None) if isinstance(loaded, FeedForwardLaw) else (None, loaded)
    if (policy is not None and sees_errors(policy)) != entry.feedback:
        raise FFGymError(
            f"Agent {entry.name!r} is declared with feedback={entry.feedback}, and {artefact.file} holds "
            f"{'a law' if policy is None else 'a policy'} with feedback={not entry.feedback}; declare what it is."
        )
    if policy is not None and (find_channel(policy) == "setpoint") != (entry.channel is not None):
        raise FFGymError(
            f"Agent {entry.name!r} is declared with channel={entry.channel}, and {artefact.file} holds a policy that "
            f"acts through channel={find_channel(policy)!r}; declare what it is."
        )
    return ReadyAgent(
        law=law,
        policy=policy,
        timed=None if law is None else _run_in_steps(law, entry.channel),
        channel=None if law is None else entry.channel,
        artefact=artefact.sha256,
        robot_seconds=artefact.robot_seconds,
        env_steps=artefact.env_steps,
    )


def _run_in_steps(law: FeedForwardLaw, channel: SetpointChannel | None) -> Policy | None:
    """Return a policy that runs a law sample by sample; None if the law cannot, or a delay is compensated."""
    if not isinstance(law, CausalLaw) or (channel is not None and channel.compensated != SetpointResponse()):
        return None
    return LawPolicy(make=lambda robot: law, preview=law.preview, channel="torque" if channel is None else "setpoint")


def _artefact(manifest: ArtefactManifest | None, plant: str, seed: int) -> Artefact | None:
    """Find the artefact that runs on a plant; drawn plants take the one of the nominal plant."""
    return None if manifest is None else manifest.find(NOMINAL if plant.startswith(DRAW) else plant, seed)


ENTRANTS: Mapping[str, Entrant] = MappingProxyType(
    {entrant.name: entrant for entrant in map(_entrant, list_entries()) if entrant is not None}
)
"""All entrants by name, in the order of tables."""
