"""Trained residual policies of a sweep, taken into the package: `python -m scripts.publish NAME FOLDER`.

The folder is one that `scripts.train` filled; its trainings must differ in nothing but the seed.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from shutil import copyfile
from typing import Any

import numpy as np
import tyro

from agents.artefacts import ANYWHERE, TRAINED, Manifest, described, write_manifest
from agents.residual.policy import ResidualPolicy, load_policy
from ffgym.errors import FFGymError
from ffgym.leaderboard.plants import NOMINAL, plant_named
from ffgym.provenance import versions

POLICY = "policy.npz"


@dataclass(frozen=True)
class Config:
    """What to publish."""

    name: tyro.conf.Positional[str]
    """Of the row."""
    folder: tyro.conf.Positional[Path]
    """With a folder seed_<k> for each training."""
    out: Path = TRAINED
    """Folder of the artefacts."""


def main(config: Config) -> Manifest:
    """Copy the policies and write their manifest."""
    places = sorted(config.folder.glob(f"seed_*/{POLICY}"), key=lambda place: _seed(place))
    if not places:
        raise FFGymError(f"{config.folder}: has no seed_<k>/{POLICY}; train first, see scripts.train.")
    policies = {_seed(place): load_policy(place) for place in places}
    command = command_of(list(policies.values()), config)
    (config.out / config.name / ANYWHERE).mkdir(parents=True, exist_ok=True)
    entries = []
    for place, (seed, policy) in zip(places, policies.items(), strict=True):
        file = f"{ANYWHERE}/seed_{seed}.npz"
        copyfile(place, config.out / config.name / file)
        entries.append(
            described(
                config.name,
                file,
                config.out,
                seed=seed,
                plant=ANYWHERE,
                fingerprint=plant_named(NOMINAL).fingerprint,
                robot_seconds=0.0,
                env_steps=int(policy.meta["env_steps"]),
            )
        )
    curve = mean_curve([policy.meta["learning_curve"] for policy in policies.values()])
    manifest = Manifest(
        name=config.name, command=command, artefacts=tuple(entries), versions=versions(), learning_curve=curve
    )
    write_manifest(manifest, config.out)
    return manifest


def command_of(policies: Sequence[ResidualPolicy], config: Config) -> str:
    """What trains them again, and publishes them.

    Raises:
        FFGymError: if they differ in more than the seed.
    """
    trainings = [dict(policy.meta["training"]) for policy in policies]
    seeds = [training.pop("seed") for training in trainings]
    if any(training != trainings[0] for training in trainings):
        raise FFGymError(f"{config.folder}: trainings in it differ in more than the seed; publish one configuration.")
    options = " ".join(_options(trainings[0]))
    listed, folder = " ".join(map(str, seeds)), f"out/{config.name}"
    train = f"python -m scripts.train {options} --seeds {listed} --out {folder}"
    return f"{train} && python -m scripts.publish {config.name} {folder}"


def _options(training: dict[str, Any]) -> list[str]:
    """Options of `scripts.train` for what differs from its defaults."""
    from agents.residual.hyperparameters import hyperparameters
    from agents.residual.plan import Training

    algorithm = training["algorithm"]
    plain = Training(algorithm=algorithm, factored=algorithm != "recurrent_ppo").document()
    options = [f"--algorithm {algorithm}", f"--base {training['base']}", f"--steps {training['steps']}"]
    options += [f"--{name} {training[name]}" for name in ("memory", "bound", "reward") if training[name] != plain[name]]
    options += ["--joint"] if not training["factored"] and algorithm != "recurrent_ppo" else []
    options += [] if training["randomization"] else ["--nominal"]
    usual = {name: list(v) if isinstance(v, tuple) else v for name, v in hyperparameters(algorithm).items()}
    changed = {name: value for name, value in training["hyperparameters"].items() if usual.get(name) != value}
    if changed:
        options.append("--set " + " ".join(f"{name}={json.dumps(value)}" for name, value in changed.items()))
    return options


def mean_curve(curves: Sequence[Sequence[Sequence[float]]]) -> tuple[tuple[float, float], ...]:
    """Mean over seeds at the steps that all have."""
    steps = [point[0] for point in curves[0]]
    values = np.array([[value for step, value in curve if step in steps] for curve in curves])
    return tuple((float(step), float(f"{value:.5g}")) for step, value in zip(steps, values.mean(axis=0), strict=True))


def _seed(place: Path) -> int:
    return int(place.parent.name.removeprefix("seed_"))


if __name__ == "__main__":
    print(main(tyro.cli(Config)).command)
