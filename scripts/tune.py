"""Search for hyper-parameters of residual policies with Optuna, on circles that are neither trained on nor scored.

python -m scripts.tune --algorithm ppo --trials 30 --out tuned

What is minimised is the mean of ln(RMS path error / that of the base) of `agents.residual.validation`, after a short
training with each of `--seeds`. A search that was stopped goes on with the same command, as if it had not been.
"""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from hashlib import sha256
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal

import numpy as np
import optuna
from optuna.samplers import TPESampler
from optuna.storages import JournalStorage
from optuna.storages.journal import JournalFileBackend
from optuna.trial import TrialState

from agents.residual.bases import base_named
from agents.residual.hyperparameters import changed
from agents.residual.plan import Training
from agents.residual.validation import validate
from ffgym.errors import FFGymError, check_whole
from ffgym.files import read_text, write_json
from ffgym.provenance import versions

JOURNAL, NUMBERS, CONFIG = "trials.journal", "tuned.json", "config.json"

_ALL = {"learning_rate": (3e-4, 1e-2, True), "gamma": (0.8, 0.98, False), "first_std": (0.05, 0.4, True)}
_ON_POLICY = _ALL | {"gae_lambda": (0.6, 0.95, False), "clip_range": (0.1, 0.4, False)}
_OFF_POLICY = _ALL | {"first_ent_coef": (1e-3, 1e-1, True), "entropy_per_motor": (-4.0, -1.0, False)}
SPACES: Mapping[str, Mapping[str, tuple[float, float, bool]]] = MappingProxyType(
    {"ppo": _ON_POLICY, "recurrent_ppo": _ON_POLICY, "sac": _OFF_POLICY, "tqc": _OFF_POLICY}
)
"""Lowest and highest value of what is searched for, and whether it is drawn evenly in its logarithm."""


@dataclass(frozen=True)
class Tune:
    """Search for hyper-parameters of one algorithm on one base."""

    algorithm: Literal["ppo", "sac", "tqc", "recurrent_ppo"] = "ppo"
    """Of stable-baselines3 and sb3-contrib."""
    base: str = "elastic"
    """Law below the policy."""
    trials: int = 30
    """Trainings with other hyper-parameters."""
    steps: int | None = None
    """Control steps of each training; none given is three segments."""
    seeds: tuple[int, ...] = (1000,)
    """Of the trainings; none that results are shown of."""
    seed: int = 0
    """Of the search."""
    bounds: tuple[float, float] = (0.3, 1.0)
    """Largest residual torque that is searched for, in breakaway torques."""
    set: tuple[str, ...] = ()
    """Hyper-parameters in place of those of the algorithm's file."""
    plants: int = 2
    """Robots drawn for each circle of the validation."""
    out: Path | None = None
    """Folder of the search and its trainings."""


def main(config: Tune) -> dict[str, Any]:
    """Search; returns the best trial and writes all of them.

    Raises:
        FFGymError: if there is no folder, it is of another search, or something cannot be trained.
    """
    check_whole("trials", config.trials, low=1)
    if config.out is None:
        raise FFGymError("Say where trials go: --out FOLDER.")
    if not config.seeds:
        raise FFGymError("seeds must be one or more numbers, got none.")
    config.out.mkdir(parents=True, exist_ok=True)
    _check_same(config, config.out)
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    storage = JournalStorage(JournalFileBackend(str(config.out / JOURNAL)))
    study = optuna.create_study(storage=storage, study_name="tune", direction="minimize", load_if_exists=True)
    for stopped in study.get_trials(states=(TrialState.RUNNING,)):  # it is proposed again, and its training goes on
        study.tell(stopped.number, state=TrialState.FAIL)
    while (done := len(study.get_trials(states=(TrialState.COMPLETE,)))) < config.trials:
        draws = int(np.random.SeedSequence([config.seed, done]).generate_state(1)[0])
        study.sampler = TPESampler(seed=draws)  # of each trial, so that a search goes on as if never stopped
        study.optimize(lambda trial: objective(trial, config), n_trials=1)
        value = study.trials[-1].value
        print(f"trial {done + 1} of {config.trials}: {value:+.4f}  best {study.best_value:+.4f}")
    complete = study.get_trials(states=(TrialState.COMPLETE,))
    best = {"value": study.best_value, "parameters": study.best_params}
    rows = [{"value": trial.value, "parameters": trial.params} for trial in complete]
    write_json(config.out / NUMBERS, {"config": _plain(config), "versions": versions(), "best": best, "trials": rows})
    return best


def objective(trial: optuna.Trial, config: Tune) -> float:
    """Mean of ln(error / that of the base) over seeds, of what a trial proposes."""
    from agents.residual.learning.training import train

    own = changed(config.algorithm, config.set)
    for name, (low, high, log) in SPACES[config.algorithm].items():
        own[name] = trial.suggest_float(name, low, high, log=log)
    own["final_learning_rate"] = 0.1 * float(own["learning_rate"])  # type: ignore[arg-type]
    bound = trial.suggest_float("bound", *config.bounds)
    base, machine = base_named(config.base)
    assert config.out is not None  # main asks for it
    values = []
    for seed in config.seeds:
        training = Training(
            algorithm=config.algorithm,
            base=base,
            machine=machine,
            factored=config.algorithm != "recurrent_ppo",
            bound=bound,
            seed=seed,
            steps=config.steps or 3 * int(own["segment_steps"]),  # type: ignore[arg-type]
            hyperparameters=own,
        )
        key = sha256(json.dumps(training.document(), sort_keys=True).encode()).hexdigest()[:16]
        trained = train(training, config.out / key)
        values.append(validate(trained.policy, training.robot, plants=config.plants).log_ratio)
    return float(np.mean(values))


def _check_same(config: Tune, folder: Path) -> None:
    """Write what is searched for, or compare with what was; more trials may follow.

    Raises:
        FFGymError: if the folder is of another search.
    """
    place, ours = folder / CONFIG, _plain(config) | {"trials": None, "out": None}
    if not place.exists():
        write_json(place, ours)
        return
    theirs = json.loads(read_text(place))
    changes = [
        f"{name} was {theirs.get(name)!r}, now {value!r}" for name, value in ours.items() if theirs.get(name) != value
    ]
    if changes:
        raise FFGymError(f"{folder}: holds another search: {'; '.join(changes)}. Choose another folder.")


def _plain(config: Tune) -> dict[str, Any]:
    plain: dict[str, Any] = json.loads(json.dumps(asdict(config), default=str))
    return plain


if __name__ == "__main__":
    import tyro

    main(tyro.cli(Tune))
