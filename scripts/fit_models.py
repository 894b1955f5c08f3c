"""Fitted models of the leaderboard: the workcell recorded, all numbers fitted, diagnosed once; with several seeds.

`python -m scripts.fit_models` makes the artefacts of `agents/trained/model_fitted`, in about ten minutes per seed and
core; what is complete in the work folder is not made again.
"""

from dataclasses import dataclass
from pathlib import Path
from shutil import copyfile

from ffgym.agents.artefacts import TRAINED, add_artefacts, describe_artefact
from ffgym.agents.model import FITTED
from ffgym.cli.improve import run as improve
from ffgym.cli.log_options import Improve
from ffgym.leaderboard.plants import THESIS_WORKCELL, find_plant
from ffgym.recordings.io import read_folder

COMMAND = "python -m scripts.fit_models"


@dataclass(frozen=True)
class Config:
    """Models to fit."""

    work: Path = Path("out/fit_models")
    """Folder for recordings and models on the way."""
    seeds: tuple[int, ...] = (0, 1, 2, 3, 4)
    """Seeds of the sensors' noise, and of what the diagnosis draws."""
    threads: int = 0
    """Threads of the simulation, 0 for all cores."""
    out: Path = TRAINED
    """Folder of the artefacts."""


def main(config: Config) -> None:
    """Fit and store."""
    for seed in config.seeds:
        folder = config.work / f"seed_{seed}"
        folder.mkdir(parents=True, exist_ok=True)
        # one circle for the comparison, which nothing here depends on
        improve(
            Improve(
                rig=THESIS_WORKCELL,
                fit=True,
                rounds=1,
                seed=seed,
                out=folder,
                positions=("p2",),
                speeds_mm_s=(100.0,),
                radii_mm=(5.0,),
                threads=config.threads,
            )
        )
        store(seed, folder / "round_1", config.out)


def store(seed: int, folder: Path, out: Path) -> None:
    """Take the extended model of a round into the artefacts."""
    plant = find_plant(THESIS_WORKCELL)
    file = f"{THESIS_WORKCELL.replace(':', '_')}/seed_{seed}.toml"
    (out / FITTED / file).parent.mkdir(parents=True, exist_ok=True)
    copyfile(folder / "extended.toml", out / FITTED / file)
    entry = describe_artefact(
        FITTED,
        file,
        out,
        seed=seed,
        plant=THESIS_WORKCELL,
        fingerprint=plant.fingerprint,
        robot_seconds=sum(float(recording.t[-1]) for recording in read_folder(folder / "logs")),
        env_steps=0,
    )
    add_artefacts(FITTED, COMMAND, [entry], out)


if __name__ == "__main__":
    import tyro

    main(tyro.cli(Config))
