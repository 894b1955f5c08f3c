"""Trained residual policies of a sweep, taken into the package: `python -m scripts.publish NAME FOLDER`.

The folder is one that `scripts.train` filled; its trainings must differ in nothing but the seed.
"""

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import tyro

from ffgym.agents.artefacts import ANYWHERE, TRAINED, Artefact, ArtefactManifest, describe_artefact, write_manifest
from ffgym.agents.residual.plan import Training
from ffgym.agents.residual.policy import RESIDUALS, ResidualPolicy, load_policy
from ffgym.cli.train_policy import options_of
from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.files import filled_folder, read_bytes, write_bytes

POLICY = "policy.npz"
_ABOUT = ("training", "origin", "versions")
"""Entries of a policy about its training, the same for all seeds."""
_NUMBERS = ("env_steps", "learning_curve")


@dataclass(frozen=True)
class Config:
    """Policies to publish."""

    name: tyro.conf.Positional[str]
    """Name of the row."""
    folder: tyro.conf.Positional[Path]
    """Folder with a subfolder seed_<k> for each training."""
    out: Path = TRAINED
    """Folder of the artefacts."""


def main(config: Config) -> ArtefactManifest:
    """Copy the policies, write their manifest, and remove what else was published under that name.

    Raises:
        FFGymError: if there are none, they are not of one training, or it is not that of the row.
    """
    places = _places(config.folder)
    policies = {seed: load_policy(place) for seed, place in places.items()}
    trainings = {seed: _training(policies[seed], seed, place) for seed, place in places.items()}
    _check_same(policies, config.folder)
    first = next(iter(policies))
    training = trainings[first]
    row = RESIDUALS[check_choice("row of trained residual policies", config.name, list(RESIDUALS))]
    wanted, found = (row.algorithm, row.base, row.machines), (training.algorithm, training.base, training.machines > 0)
    if found != wanted:
        raise FFGymError(
            f"{config.name} is a row of {_kind(*wanted)}, these are of {_kind(*found)}. Publish them under another "
            f"name, or add a row in agents/residual/policy.py."
        )
    command = command_of(config.name, training, list(places))
    files, artefacts = {seed: f"seed_{seed}.npz" for seed in places}, list[Artefact]()
    with filled_folder(config.out / config.name / ANYWHERE) as folder:
        for seed, policy in policies.items():
            write_bytes(folder / files[seed], read_bytes(places[seed]))
            entry = describe_artefact(
                config.name,
                f"{ANYWHERE}/{files[seed]}",
                config.out,
                seed=seed,
                plant=ANYWHERE,
                fingerprint=str(policy.meta["origin"]["physics_fingerprint"]),
                robot_seconds=0.0,
                env_steps=int(policy.meta["env_steps"]),
            )
            artefacts.append(entry)
        manifest = ArtefactManifest(
            name=config.name,
            command=command,
            artefacts=tuple(artefacts),
            versions=policies[first].meta["versions"],
            learning_curve=mean_curve([policy.meta["learning_curve"] for policy in policies.values()]),
        )
        write_manifest(manifest, config.out)
        for gone in {*folder.glob("seed_*.npz")} - {folder / file for file in files.values()}:
            gone.unlink()
    return manifest


def _kind(algorithm: str, base: str, machines: bool) -> str:
    return f"{algorithm} on {base}, trained on {'machines with effects' if machines else 'robots'}"


def command_of(name: str, training: Training, seeds: Sequence[int]) -> str:
    """Write the command that trains policies again, and publishes them.

    Raises:
        FFGymError: if options cannot ask for the training.
    """
    folder = f"out/{name}"
    sweep = [*options_of(training), "--seeds", *map(str, seeds), "--out", folder]
    train, publish = ["python", "-m", "scripts.train", *sweep], ["python", "-m", "scripts.publish", name, folder]
    return f"{shlex.join(train)} && {shlex.join(publish)}"


def mean_curve(curves: Sequence[Sequence[Sequence[float]]]) -> tuple[tuple[float, float], ...]:
    """Mean over seeds at the steps that all have."""
    steps = [point[0] for point in curves[0]]
    values = np.array([[value for step, value in curve if step in steps] for curve in curves])
    return tuple((float(step), float(f"{value:.5g}")) for step, value in zip(steps, values.mean(axis=0), strict=True))


def _places(folder: Path) -> dict[int, Path]:
    """Policies in a folder, by seed; refuses a folder without any, and one of another name."""
    places = {}
    for place in folder.glob(f"seed_*/{POLICY}"):
        number = place.parent.name.removeprefix("seed_")
        if not number.isdecimal() or number != str(int(number)):
            raise FFGymError(f"{place.parent}: its name must be seed_<number>; rename it, or move it elsewhere.")
        places[int(number)] = place
    if not places:
        raise FFGymError(f"{folder}: has no seed_<k>/{POLICY}; train first, see scripts.train.")
    return dict(sorted(places.items()))


def _training(policy: ResidualPolicy, seed: int, place: Path) -> Training:
    """Training that a policy tells of; refuses one that does not tell all, or is of another seed than its folder."""
    lacks = [name for name in (*_ABOUT, *_NUMBERS) if name not in policy.meta]
    if lacks:
        raise FFGymError(f"{place}: does not say its {', '.join(lacks)}; publish what scripts.train wrote.")
    try:
        training = Training(**policy.meta["training"])
        if training.document() != policy.meta["training"]:
            raise FFGymError("some of its settings are others here.")
    except (TypeError, FFGymError) as error:
        raise FFGymError(f"{place}: is of a training that this ffgym has not: {error} Train again.") from error
    if training.seed != seed:
        raise FFGymError(f"{place}: was trained with seed {training.seed}; its folder must be seed_{training.seed}.")
    return training


def _check_same(policies: Mapping[int, ResidualPolicy], folder: Path) -> None:
    """Refuse trainings that differ in more than the seed, and say in what."""
    (first, one), *others = policies.items()
    for seed, other in others:
        changes = [
            f"{about}.{name}"
            for about in _ABOUT
            for name in sorted({*one.meta[about], *other.meta[about]} - {"seed"})
            if one.meta[about].get(name) != other.meta[about].get(name)
        ]
        if changes:
            raise FFGymError(
                f"{folder}: seed_{first} and seed_{seed} differ in more than the seed: {', '.join(changes)}. Publish "
                f"one configuration."
            )


if __name__ == "__main__":
    print(main(tyro.cli(Config)).command)
