"""Everybody on the leaderboard: all that is declared, made where it runs, or read where it ships with the package."""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from types import MappingProxyType

from ffgym.agents.artefacts import Artefact, Manifest, manifest_of, path_of
from ffgym.agents.catalogue import declared
from ffgym.agents.declaration import Entry, Setting
from ffgym.agents.law_agent import LawPolicy
from ffgym.agents.shared_trials import learn_together
from ffgym.agents.submission import LOADERS
from ffgym.agents.trials import CountedTrial, RigTrial, Trial, measured
from ffgym.control import CausalLaw, FeedForwardLaw, Policy
from ffgym.leaderboard.entrants import Entrant, Maker, Ready, Registry, one_by_one
from ffgym.leaderboard.plants import DRAW, NOMINAL, TestPlant
from ffgym.leaderboard.submission.entrant import entrant_of
from ffgym.leaderboard.tasks import Task, references_of

REGISTRY = Registry("ffgym.agents.entrants:ENTRANTS", maker="ffgym.agents.entrants:submitted")
"""Where other processes find them, and what makes an entrant of a submission."""
SEEDS = (0, 1, 2, 3, 4)
"""Of every row that a seed changes."""
_PRACTISED = "per task"
"""Track of laws that practise what is scored."""


def submitted(path: Path) -> Entrant:
    """Entrant of a submission, see `entrant_of`."""
    return entrant_of(path, LOADERS)


def _entrant(entry: Entry) -> Entrant | None:
    """An agent read from artefacts if there are some, made where it runs otherwise; None if it cannot be made."""
    manifest = manifest_of(entry.name)
    if not entry.on_leaderboard or (entry.make is None and manifest is None):
        return None
    practises = entry.track == _PRACTISED
    again = f"ffgym leaderboard --agents {entry.name}" if practises else None
    unread = SEEDS if practises or entry.seeded else (0,)
    ready: Maker
    if practises:
        ready = partial(_practised, entry)
    else:
        ready = one_by_one(partial(_made, entry) if manifest is None else partial(_read, entry, manifest))

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
        seeds=unread if manifest is None or practises else manifest.seeds,
        command=again if manifest is None else manifest.command,
        ranked=entry.ranked,
        slow=practises,
        artefact=sha256_of,
        learning_curve=lambda: () if manifest is None else manifest.learning_curve,
        ready=ready,
    )


def _made(entry: Entry, plant: TestPlant, seed: int, tasks: tuple[Task, ...]) -> Ready | None:
    """A law from the description, from trials, or from the truth; None where that is shut away."""
    if entry.track == "oracle" and plant.truth is None:
        return None
    assert entry.make is not None  # see _entrant
    trial = CountedTrial(RigTrial(rig=measured(plant.rig), seed=seed))
    law = entry.make(Setting(arm=plant.rig.arm, trial=trial, truth=plant.truth, seed=seed))
    return Ready(law=law, timed=_timed(law), robot_seconds=trial.robot_seconds)


def _practised(entry: Entry, plant: TestPlant, seeds: Sequence[int], tasks: tuple[Task, ...]) -> list[Ready | None]:
    """A law that practised the tasks, seen through the machine's sensors; all seeds learn side by side."""
    references, make = references_of(plant.rig.arm, tasks), entry.make
    assert make is not None  # see _entrant

    def learned(seed: int, trial: Trial) -> Ready:
        counted = CountedTrial(trial)
        law = make(Setting(arm=plant.rig.arm, trial=counted, references=references, seed=seed))
        return Ready(law=law, robot_seconds=counted.robot_seconds)  # learned beforehand, so that nothing is timed

    found = learn_together(measured(plant.rig), {seed: (seed, partial(learned, seed)) for seed in seeds})
    return [found[seed] for seed in seeds]


def _read(entry: Entry, manifest: Manifest, plant: TestPlant, seed: int, tasks: tuple[Task, ...]) -> Ready | None:
    """A trained agent; on drawn plants it is what it was on the nominal one. None if it was not trained for a plant."""
    artefact = _artefact(manifest, plant.name, seed)
    if artefact is None:
        return None
    loaded = entry.load(path_of(manifest.name, artefact), plant.rig.arm)
    law, policy = (loaded, None) if isinstance(loaded, FeedForwardLaw) else (None, loaded)
    return Ready(
        law=law,
        policy=policy,
        timed=None if law is None else _timed(law),
        artefact=artefact.sha256,
        robot_seconds=artefact.robot_seconds,
        env_steps=artefact.env_steps,
    )


def _timed(law: FeedForwardLaw) -> Policy | None:
    """A law as what decides sample by sample, if it can."""
    return LawPolicy(make=lambda robot: law, preview=law.preview) if isinstance(law, CausalLaw) else None


def _artefact(manifest: Manifest | None, plant: str, seed: int) -> Artefact | None:
    """Artefact that runs on a plant: drawn ones are met with what was learned on the nominal one."""
    return None if manifest is None else manifest.find(NOMINAL if plant.startswith(DRAW) else plant, seed)


ENTRANTS: Mapping[str, Entrant] = MappingProxyType(
    {entrant.name: entrant for entrant in map(_entrant, declared()) if entrant is not None}
)
"""By name, in the order of tables."""
