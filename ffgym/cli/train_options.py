"""The options of `ffgym train` and `scripts.train` that ask for a training."""

import json

from ffgym.agents.residual.hyperparameters import Value, hyperparameters
from ffgym.agents.residual.plan import Training
from ffgym.cli.train import Options
from ffgym.core.errors import FFGymError


def options_of(training: Training, base: str | None = None) -> list[str]:
    """Options that ask for a training, but its seed; those that are not needed are left out.

    Args:
        training: what to ask for.
        base: law below the policy as the option has it; one with a machine file needs it, e.g. 'model:machine.toml'.

    Raises:
        FFGymError: if options cannot ask for it.
    """
    words = ["--algorithm", training.algorithm, "--base", base or training.base, "--steps", str(training.total)]
    usual = Options()
    for name in ("robot", "memory", "bound", "reward"):
        value = getattr(training, name)
        words += [f"--{name}", str(value)] if value != getattr(usual, name) else []
    words += [] if training.factored or training.algorithm == "recurrent_ppo" else ["--joint"]
    words += [] if training.randomization else ["--nominal"]
    file = hyperparameters(training.algorithm)
    changes = [f"{name}={_text(value)}" for name, value in training.hyperparameters.items() if value != file[name]]
    words += ["--set", *changes] if changes else []
    _check_said(training, words)
    return words


def _check_said(training: Training, words: list[str]) -> None:
    """Read options as a command does, and compare.

    Raises:
        FFGymError: if they ask for something else.
    """
    import tyro

    wanted, said = training.document(), tyro.cli(Options, args=words).with_seed(training.seed).document()
    lost = [name for name, value in wanted.items() if said[name] != value]
    if lost:
        raise FFGymError(
            f"No options of ffgym train ask for this training: its {' and '.join(lost)} would differ. Train with "
            f"ffgym train or scripts.train."
        )


def _text(value: Value) -> str:
    """A hyper-parameter as `--set` reads it."""
    return value if isinstance(value, str) else json.dumps(value, separators=(",", ":"))
