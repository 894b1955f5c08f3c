"""`ffgym train policy`: a residual policy on top of a feed-forward law, by reinforcement learning in simulation."""

import json
import os
from pathlib import Path

import tyro

from ffgym.agents.residual.hyperparameters import hyperparameters
from ffgym.agents.residual.plan import Training
from ffgym.cli.learning_options import PolicyOptions, PolicyTraining
from ffgym.cli.outputs import claim_outputs, given_folder, need_extra, print_places, provenance, write_numbers
from ffgym.cli.progress import progress_bar
from ffgym.core.errors import FFGymError

PACKAGES = ("torch", "stable-baselines3", "sb3-contrib")
"""Packages that training needs."""


def options_of(training: Training, base: str | None = None) -> list[str]:
    """Options that ask for a training, but its seed; those that are not needed are left out.

    Args:
        training: what to ask for.
        base: law below the policy as the option has it; one with a machine file needs it, e.g. 'model:machine.toml'.

    Raises:
        FFGymError: if options cannot ask for it.
    """
    words = ["--algorithm", training.algorithm, "--base", base or training.base, "--steps", str(training.total)]
    usual = PolicyOptions()
    for name in ("robot", "memory", "bound", "reward", "gain_margin", "delay_margin", "machines"):
        value = getattr(training, name)
        words += [f"--{name.replace('_', '-')}", str(value)] if value != getattr(usual, name) else []
    words += [] if training.factored or training.algorithm == "recurrent_ppo" else ["--joint"]
    words += [] if training.randomization else ["--nominal"]
    file = hyperparameters(training.algorithm)
    changed = {name: value for name, value in training.hyperparameters.items() if value != file[name]}
    texts = {n: v if isinstance(v, str) else json.dumps(v, separators=(",", ":")) for n, v in changed.items()}
    words += ["--set", *(f"{name}={text}" for name, text in texts.items())] if changed else []
    # what a command would read of these words must be the same training
    wanted, said = training.document(), tyro.cli(PolicyOptions, args=words).with_seed(training.seed).document()
    if lost := [name for name, value in wanted.items() if said[name] != value]:
        raise FFGymError(
            f"No options of ffgym train policy ask for this training: its {' and '.join(lost)} would differ. Train "
            f"with ffgym train policy or scripts.train."
        )
    return words


def need_training() -> None:
    """Check that all is installed that training needs."""
    need_extra("ffgym train policy", *PACKAGES, extra="rl")


def run(config: PolicyTraining) -> None:
    """Check, train, print."""
    need_training()
    out = given_folder(config.out, "the policy goes")
    if config.json is not None and Path(os.path.realpath(config.json)).is_relative_to(os.path.realpath(out)):
        raise FFGymError(f"--json {config.json}: lies in --out {out}, whose files are the training's own.")
    claim_outputs({"--json": config.json})
    training = config.with_seed(config.seed)
    robot = training.known()
    from ffgym.agents.residual.training import train

    with progress_bar("training", "steps") as progress:
        trained = train(training, out, watch=progress)
    fingerprint = str(trained.policy.meta["origin"]["physics_fingerprint"])
    info = provenance("ffgym train policy", config, robot.name, fingerprint, config.seed)
    info |= {"training": training.document(), "env_steps": trained.env_steps, "sha256": trained.sha256}
    write_numbers(config, info | {"learning_curve": [list(point) for point in trained.curve]})
    (_, first), (_, last) = trained.curve[0], trained.curve[-1]
    print(f"{training.algorithm} on {training.base}, seed {training.seed}: {trained.env_steps} steps")
    print(f"reward per step, with exploration: {first:.4f} at first, {last:.4f} at last")
    print_places(policy=trained.file, numbers=config.json)
