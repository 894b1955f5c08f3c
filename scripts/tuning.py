"""Options of a search for hyper-parameters, the record of its trials, and what to try next.

Trials are kept in one file, written whole after each. The next one is proposed by Optuna's tree-structured Parzen
estimator, begun anew for each trial.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import tyro

from ffgym.agents.law_files import check_same
from ffgym.agents.residual.plan import Training
from ffgym.cli.learning_options import PolicyOptions
from ffgym.cli.train_policy import need_training
from ffgym.core.errors import FFGymError, check_number, check_whole
from ffgym.core.files import read_text, write_json
from ffgym.core.provenance import is_installed
from ffgym.core.typed_json import from_json

FAILED = 10.0
"""Value of a trial that failed: worse than any that learns, as of 22 000 times the error of the base; chosen."""


@dataclass(frozen=True, kw_only=True)
class Trial:
    """Hyper-parameters that were tried, and how good they are."""

    parameters: dict[str, float]
    """Values of the parameters that are searched for."""
    value: float
    """Mean of ln(error / that of the base); FAILED where there is none."""
    failure: str | None = None
    """Why there is none."""
    folders: tuple[str, ...]
    """Folders of its trainings, one for each seed."""


def read_trials(file: Path, search: Mapping[str, Any]) -> list[Trial]:
    """Trials of a search that were written, in their order; none if nothing was.

    Raises:
        FFGymError: if the file is of another search, or damaged.
    """
    if not file.exists():
        return []
    text = read_text(file)
    try:
        tree = json.loads(text)
        theirs, trials = dict(tree["search"]), [from_json(Trial, entry, "trial") for entry in tree["trials"]]
        if any(trial.parameters.keys() != theirs["space"].keys() for trial in trials):
            raise FFGymError("a trial is not of what is searched for")
    except (KeyError, TypeError, ValueError) as error:
        raise FFGymError(
            f"{file}: is damaged: {error}. Remove it and give the same command again; trainings that are done are not "
            f"done again."
        ) from error
    check_same(theirs, search, file.parent, "another search", "Choose another folder, or remove this one.")
    return trials


def write_trials(
    file: Path, search: Mapping[str, Any], trials: Sequence[Trial], best: Mapping[str, Any] | None
) -> None:
    """Write all trials of a search, and the best of them if there is one."""
    write_json(file, {"search": search, "best": best, "trials": [asdict(trial) for trial in trials]})


Space = Mapping[str, tuple[float, float, bool]]
"""Lowest and highest value of what is searched for, and whether it is drawn evenly in its logarithm."""

_ALL = {"learning_rate": (3e-4, 1e-2, True), "gamma": (0.8, 0.98, False), "first_std": (0.05, 0.4, True)}
_ON_POLICY = _ALL | {"gae_lambda": (0.6, 0.95, False), "clip_range": (0.1, 0.4, False)}
_OFF_POLICY = _ALL | {"first_ent_coef": (1e-3, 1e-1, True), "entropy_per_motor": (-4.0, -1.0, False)}
SPACES: Mapping[str, Space] = MappingProxyType(
    {"ppo": _ON_POLICY, "recurrent_ppo": _ON_POLICY, "sac": _OFF_POLICY, "tqc": _OFF_POLICY}
)
"""Hyper-parameters that are searched for, by algorithm; the final learning rate is a tenth of the first one."""


def proposal(space: Space, trials: Sequence[Trial], seed: int) -> dict[str, float]:
    """Propose parameters after `trials`; these, the seed and nothing else decide it, so a stopped search goes on."""
    import optuna
    from optuna.distributions import FloatDistribution
    from optuna.samplers import TPESampler

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    ranges = {name: FloatDistribution(low, high, log=log) for name, (low, high, log) in space.items()}
    draws = int(np.random.SeedSequence([seed, len(trials)]).generate_state(1)[0])
    study = optuna.create_study(direction="minimize", sampler=TPESampler(seed=draws))
    for trial in trials:
        done = optuna.trial.create_trial(params=trial.parameters, distributions=dict(ranges), value=trial.value)
        study.add_trial(done)
    asked = study.ask(dict(ranges))
    return {name: float(asked.params[name]) for name in space}


@dataclass(frozen=True)
class Tune(PolicyOptions):
    """Search for hyper-parameters of one algorithm on one base."""

    trials: int = 30
    """Trainings with other hyper-parameters."""
    steps: int | None = None
    """Control steps of each training; none given is three segments."""
    bound: tyro.conf.Suppress[tyro.conf.Fixed[float]] = PolicyOptions.bound
    """Is searched for, see `bounds`."""
    bounds: tuple[float, float] = (0.3, 1.0)
    """Largest residual torque that is searched for, in breakaway torques."""
    seeds: tuple[int, ...] = (1000,)
    """Seeds of the trainings; results are shown of other seeds."""
    seed: int = 0
    """Seed of the search."""
    plants: int = 2
    """Robots drawn for each circle of the validation."""
    out: Path | None = None
    """Folder of the search and its trainings."""

    @property
    def space(self) -> Space:
        """Space that is searched."""
        return {**SPACES[self.algorithm], "bound": (*self.bounds, False)}

    @property
    def searched(self) -> frozenset[str]:
        """Names of hyper-parameters that a search chooses."""
        return frozenset(SPACES[self.algorithm]) | {"final_learning_rate"}

    def record_trial(self, seed: int, parameters: dict[str, float]) -> Training:
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


def check(config: Tune) -> tuple[Path, Training]:
    """Folder of a search, and one of its trainings.

    Raises:
        FFGymError: if a package is missing, or an option makes no sense.
    """
    need_training()
    if not is_installed("optuna"):
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
    trainings = [config.record_trial(seed, edge) for seed in config.seeds for edge in edges]
    if config.out is None:
        raise FFGymError("Say where trials go: --out FOLDER.")
    return config.out, trainings[0]
