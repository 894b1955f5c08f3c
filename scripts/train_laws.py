"""Learning laws of the leaderboard, trained with several seeds on the nominal robot and on the workcell.

`python -m scripts.train_laws` makes all artefacts of `agents/trained` that trials on a machine make, in about half
an hour; `--agents narx --plants nominal` some of them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from ffgym.agents.artefacts import TRAINED, Artefact, add_artefacts, describe_artefact
from ffgym.agents.catalogue import list_entries, make_law
from ffgym.agents.declaration import AgentSetting
from ffgym.agents.law_files import StoredLaw, save_law
from ffgym.agents.trials import CountedTrial, Trial, add_sensors
from ffgym.control import FeedForwardLaw
from ffgym.core.errors import FFGymError
from ffgym.leaderboard.plants import NOMINAL, THESIS_WORKCELL, find_plant
from ffgym.simulation import Rig
from ffgym.simulation.shared_rig import learn_together

COMMAND = "python -m scripts.train_laws"


@dataclass(frozen=True)
class Config:
    """Laws to train."""

    agents: tuple[str, ...] = tuple(entry.name for entry in list_entries() if entry.learns)
    """Names in the catalogue."""
    plants: tuple[str, ...] = (NOMINAL, THESIS_WORKCELL)
    """Plants to learn on."""
    seeds: tuple[int, ...] = (0, 1, 2, 3, 4)
    """Seeds of the sensors' noise and of first weights."""
    out: Path = TRAINED
    """Folder of the artefacts."""


Learned = tuple[FeedForwardLaw, float]
"""A law, and the time that the machine moved for it [s]."""


def main(config: Config) -> None:
    """Train and write."""
    for plant in config.plants:
        rig = add_sensors(find_plant(plant).rig)
        learners: dict[tuple[str, int], tuple[int, Callable[[Trial], Learned]]] = {
            (name, seed): (seed, partial(learn, name, rig, seed)) for name in config.agents for seed in config.seeds
        }
        found = learn_together(rig, learners)
        for name in config.agents:
            own = {seed: found[name, seed] for seed in config.seeds}
            store(name, plant, rig.fingerprint, own, config.out)


def learn(name: str, rig: Rig, seed: int, trial: Trial) -> Learned:
    """A member of the catalogue, trained."""
    counted = CountedTrial(trial)
    law = make_law(name, AgentSetting(arm=rig.arm, trial=counted, seed=seed))
    return law, counted.robot_seconds


def store(name: str, plant: str, fingerprint: str, laws: dict[int, Learned], out: Path) -> None:
    """Write the laws of one name on one plant, and their manifest."""
    folder = plant.replace(":", "_")
    (out / name / folder).mkdir(parents=True, exist_ok=True)
    entries: list[Artefact] = []
    for seed, (law, robot_seconds) in laws.items():
        if not isinstance(law, StoredLaw):
            raise FFGymError(f"Agent {name!r} learns nothing that a file could hold; it needs no artefact.")
        file = f"{folder}/seed_{seed}.npz"
        save_law(out / name / file, law, {"plant": plant, "seed": seed, "robot_seconds": robot_seconds})
        what = {
            "seed": seed,
            "plant": plant,
            "fingerprint": fingerprint,
            "robot_seconds": robot_seconds,
            "env_steps": 0,
        }
        entries.append(describe_artefact(name, file, out, **what))
    add_artefacts(name, COMMAND, entries, out)


if __name__ == "__main__":
    import tyro

    main(tyro.cli(Config))
