"""Search for hyper-parameters of residual policies with Optuna, on circles that are neither trained on nor scored.

python -m scripts.tune --algorithm ppo --trials 30 --out tuned

What is minimised is the mean of ln(RMS path error / that of the base) of `ffgym.agents.residual.validation`, after a
short training with each of `--seeds`, which has a learning-rate schedule of its own: what is rewarded is fast learning.
A trial that fails counts as a bad one. A search that was stopped goes on with the same command, as if it had not been.
"""

import json
import shlex
from collections.abc import Sequence
from hashlib import sha256
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
import tyro

from ffgym.agents.residual.plan import Training
from ffgym.agents.residual.validation import base_errors, validate
from ffgym.cli.progress import progress_bar
from ffgym.cli.train_policy import options_of
from ffgym.core.errors import FFGymError
from ffgym.core.files import filled_folder
from scripts.tuning import FAILED, Trial, Tune, check, proposal, read_trials, write_trials

NUMBERS = "tuned.json"


def main(config: Tune) -> dict[str, Any]:
    """Search; returns the best trial and writes all of them.

    Raises:
        FFGymError: if something is missing or makes no sense, the folder is of another search, or every trial failed.
    """
    out, training = check(config)
    search = _search(config, training)
    with filled_folder(out) as folder:
        trials = read_trials(folder / NUMBERS, search)
        if len(trials) < config.trials:
            check_runs(training, config.plants)
        best = _best(trials, config)
        write_trials(folder / NUMBERS, search, trials, best)
        for number in range(len(trials), config.trials):
            trials.append(_try(config, folder, number, proposal(config.space, trials, config.seed)))
            best = _best(trials, config)
            write_trials(folder / NUMBERS, search, trials, best)
            told = trials[-1].failure or f"{trials[-1].value:+.4f}"
            print(f"trial {number + 1} of {config.trials}: {told}" + (f"  best {best['value']:+.4f}" if best else ""))
    if best is None:
        raise FFGymError(f"{out}: no trial gave a policy. The last failed: {trials[-1].failure}")
    print(f"ffgym train policy {best['options']} --out FOLDER")
    return best


def objective(config: Tune, trainings: dict[str, Training], folder: Path, title: str) -> float:
    """Mean of ln(error / that of the base) over trainings, each in a folder of its own."""
    from ffgym.agents.residual.training import train

    values = []
    for name, training in trainings.items():
        with progress_bar(f"{title}, seed {training.seed}", "steps") as progress:
            trained = train(training, folder / name, watch=progress)
        effects = training.machines > 0
        found = validate(trained.policy, training.robot, plants=config.plants, effects=effects)
        values.append(found.log_ratio)
    return float(np.mean(values))


def check_runs(training: Training, plants: int) -> None:
    """Make the environment and run the base on the validation, before a training is begun for nothing.

    Raises:
        FFGymError: if the environment cannot be made, or the robot has no such places.
    """
    from ffgym.agents.residual.environment import make_environment

    make_environment(training, n_envs=1).close()
    own = (training.action_scale, training.preview)
    base_errors(training.base, training.machine, *own, training.robot, plants, effects=training.machines > 0)


def _search(config: Tune, training: Training) -> dict[str, Any]:
    """All that decides what a search finds, as JSON gives it back; more trials may follow."""
    import optuna

    from ffgym.agents.residual.training import library_versions

    own = {name: value for name, value in training.document().items() if name not in ("bound", "seed")}
    given = {name: value for name, value in own["hyperparameters"].items() if name not in config.searched}
    search = {
        "training": own | {"hyperparameters": given},
        "space": config.space,
        "seeds": config.seeds,
        "seed": config.seed,
        "plants": config.plants,
        "origin": training.origin(),
        "versions": library_versions() | {"optuna": optuna.__version__},
    }
    plain: dict[str, Any] = json.loads(json.dumps(search))
    return plain


def _try(config: Tune, folder: Path, number: int, parameters: dict[str, float]) -> Trial:
    """Train with hyper-parameters; a file that cannot be read or written is no fault of theirs.

    Raises:
        FFGymError: of such a file.
    """
    trainings = {}
    for seed in config.seeds:  # a folder has the same name for the same training
        training = config.record_trial(seed, parameters)
        document = json.dumps(training.document(), sort_keys=True).encode()
        trainings[sha256(document).hexdigest()[:16]] = training
    failure = None
    try:
        value = objective(config, trainings, folder, f"trial {number + 1} of {config.trials}")
        if not isfinite(value):
            failure = f"the mean of ln(error / that of the base) is {value}."
    except FFGymError as error:
        if _of_a_file(error):
            raise
        failure = str(error)
    value = value if failure is None else FAILED
    return Trial(parameters=parameters, value=value, failure=failure, folders=tuple(trainings))


def _of_a_file(error: BaseException | None) -> bool:
    return error is not None and (isinstance(error, OSError) or _of_a_file(error.__cause__))


def _best(trials: Sequence[Trial], config: Tune) -> dict[str, Any] | None:
    """The best trial that gave a policy, with options of `ffgym train policy` that train it again, or None."""
    good = [trial for trial in trials if trial.failure is None]
    if not good:
        return None
    best = min(good, key=lambda trial: trial.value)
    training = config.record_trial(config.seeds[0], best.parameters)
    options = [*options_of(training, config.base), "--seed", str(training.seed)]
    return {"value": best.value, "parameters": best.parameters, "options": shlex.join(options)}


if __name__ == "__main__":
    main(tyro.cli(Tune))
