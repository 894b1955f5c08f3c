"""One training of a residual policy for several seeds, each in a folder of its own; what is done is not done again.

python -m scripts.train --algorithm ppo --seeds 0 1 2 3 4 --out trained
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from ffgym.agents.residual.plan import Training
from ffgym.cli.learning_options import PolicyOptions
from ffgym.cli.progress import progress_bar
from ffgym.cli.train_policy import need_training
from ffgym.core.errors import FFGymError
from ffgym.core.executors import Executor
from ffgym.core.files import filled_folder


@dataclass(frozen=True)
class Sweep(PolicyOptions):
    """Train one configuration with several seeds."""

    seeds: tuple[int, ...] = (0, 1, 2, 3, 4)
    """A training each."""
    out: Path | None = None
    """Folder for a subfolder seed_<seed> each, as `ffgym train policy` writes them."""
    executor: Executor = field(default_factory=lambda: Executor(jobs=1))
    """Executor of trainings; one at a time unless more jobs are asked for."""


def train_one(job: tuple[Training, Path]) -> tuple[int, float, str]:
    """Train; returns steps, reward per step at last, and the sha256 of the policy."""
    from ffgym.agents.residual.training import train

    trained = train(*job)
    return trained.env_steps, trained.curve[-1][1], trained.sha256


def main(config: Sweep, run: Callable[[tuple[Training, Path]], tuple[int, float, str]] = train_one) -> list[Path]:
    """Train all seeds; returns the folders.

    Raises:
        FFGymError: if a package, a folder or a seed is missing, a seed stands twice, or a training fails.
    """
    need_training()
    if config.out is None:
        raise FFGymError("Say where the policies go: --out FOLDER.")
    if not config.seeds or len(set(config.seeds)) < len(config.seeds):
        raise FFGymError(f"seeds = {config.seeds} must be one or more different numbers.")
    jobs = [(config.with_seed(seed), config.out / f"seed_{seed}") for seed in config.seeds]
    jobs[0][0].known()
    with filled_folder(config.out), progress_bar("seeds", "trained") as progress:
        for done, (i, (steps, reward, sha256)) in enumerate(config.executor.run(run, jobs), start=1):
            progress(done, len(jobs))
            print(f"seed {config.seeds[i]}: {steps} steps, reward per step {reward:.4f}, sha256 {sha256[:16]}")
    return [folder for _, folder in jobs]


if __name__ == "__main__":
    import tyro

    main(tyro.cli(Sweep))
