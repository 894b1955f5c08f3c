"""Options of a search for hyper-parameters."""

from dataclasses import dataclass, replace
from pathlib import Path

import tyro

from ffgym.agents.residual.plan import Training
from ffgym.cli.train_policy import Options, need_training
from ffgym.core.errors import FFGymError, check_number, check_whole
from ffgym.core.provenance import installed
from scripts.tuning.space import SPACES, Space


@dataclass(frozen=True)
class Tune(Options):
    """Search for hyper-parameters of one algorithm on one base."""

    trials: int = 30
    """Trainings with other hyper-parameters."""
    steps: int | None = None
    """Control steps of each training; none given is three segments."""
    bound: tyro.conf.Suppress[tyro.conf.Fixed[float]] = Options.bound
    """Is searched for, see `bounds`."""
    bounds: tuple[float, float] = (0.3, 1.0)
    """Largest residual torque that is searched for, in breakaway torques."""
    seeds: tuple[int, ...] = (1000,)
    """Of the trainings; none that results are shown of."""
    seed: int = 0
    """Of the search."""
    plants: int = 2
    """Robots drawn for each circle of the validation."""
    out: Path | None = None
    """Folder of the search and its trainings."""

    @property
    def space(self) -> Space:
        """What is searched for."""
        return {**SPACES[self.algorithm], "bound": (*self.bounds, False)}

    @property
    def searched(self) -> frozenset[str]:
        """Names of hyper-parameters that a search chooses."""
        return frozenset(SPACES[self.algorithm]) | {"final_learning_rate"}

    def tried_with(self, seed: int, parameters: dict[str, float]) -> Training:
        """Training with some of the space.

        Raises:
            FFGymError: if it makes no sense.
        """
        plain = self.with_seed(seed)
        own = {name: value for name, value in parameters.items() if name != "bound"}
        own["final_learning_rate"] = 0.1 * own["learning_rate"]
        steps = 3 * plain.integer("segment_steps") if self.steps is None else self.steps
        values = {**plain.hyperparameters, **own}
        return replace(plain, bound=parameters["bound"], steps=steps, hyperparameters=values)


def checked(config: Tune) -> tuple[Path, Training]:
    """Folder of a search, and one of its trainings.

    Raises:
        FFGymError: if a package is missing, or an option makes no sense.
    """
    need_training()
    if not installed("optuna"):
        raise FFGymError("scripts.tune needs optuna; pip install 'ffgym[tune]'.")
    check_whole("trials", config.trials, low=1)
    check_whole("plants", config.plants, low=1, high=10_000)
    check_whole("seed", config.seed, low=0)
    low, high = (check_number("bounds", bound, low=0.0, open_low=True) for bound in config.bounds)
    if low >= high:
        raise FFGymError(f"bounds = {low} {high} must rise: the least bound that is tried, then the largest.")
    if not config.seeds or len(set(config.seeds)) < len(config.seeds):
        raise FFGymError(f"seeds = {config.seeds} must be one or more different numbers.")
    for change in config.set:
        if (name := change.partition("=")[0]) in config.searched:
            raise FFGymError(f"--set {change}: {name} is searched for, so that no value can be set; leave it out.")
    edges = [{name: limits[k] for name, limits in config.space.items()} for k in (0, 1)]
    trainings = [config.tried_with(seed, edge) for seed in config.seeds for edge in edges]
    if config.out is None:
        raise FFGymError("Say where trials go: --out FOLDER.")
    return config.out, trainings[0]
