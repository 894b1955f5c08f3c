"""Training of a residual policy in segments, so that an interruption leaves no trace in the result.

Each segment begins from its checkpoint alone, in an undisturbed training too: a new algorithm gets the networks,
optimisers, replay buffer and counters of the checkpoint, and torch, numpy, python and the environment are seeded by
training seed and number of the segment. Training that was killed is therefore equal, bit for bit, to one that was not.
"""

import hashlib
import json
import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import sb3_contrib
import stable_baselines3
import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.logger import Logger, configure

from ffgym.agents.residual.learning.algorithms import algorithm_of
from ffgym.agents.residual.learning.checkpoint import check_same, read_newest, write_checkpoint
from ffgym.agents.residual.learning.curve import Curve, Points
from ffgym.agents.residual.learning.environment import ResidualVecEnv, environment_of
from ffgym.agents.residual.learning.export import actor_of
from ffgym.agents.residual.plan import Training
from ffgym.agents.residual.policy import ResidualPolicy, encode_policy, load_policy
from ffgym.core.claims import claimed
from ffgym.core.errors import FFGymError
from ffgym.core.files import made_folder, read_bytes, read_text, write_bytes, write_json
from ffgym.core.provenance import installed, versions

POLICY, NUMBERS = "policy.npz", "training.json"
"""What is written when a training is done."""
CHECKPOINTS, TENSORBOARD = "checkpoints", "tensorboard"
"""Folders beside them; the first is removed at the end."""

Watch = Callable[[int, int], object]
"""Is told steps that are done, and all."""


@dataclass(frozen=True, kw_only=True)
class Trained:
    """A training that is done."""

    policy: ResidualPolicy = field(repr=False)
    file: Path
    sha256: str
    """Of the file."""

    @property
    def env_steps(self) -> int:
        """Control steps of all robots together."""
        return int(self.policy.meta["env_steps"])

    @property
    def curve(self) -> list[tuple[int, float]]:
        """Steps, mean reward per step since the point before, with exploration."""
        return [(int(steps), float(reward)) for steps, reward in self.policy.meta["learning_curve"]]


def train(training: Training, out: Path, *, watch: Watch | None = None) -> Trained:
    """Train, or go on where a training of the same kind in the same folder stopped; done ones are read.

    Torch is set to one thread, and the generators of torch, numpy and python are seeded.

    Args:
        training: what to train.
        out: folder for the policy, numbers, checkpoints and TensorBoard's files.
        watch: is told how far it is.

    Raises:
        FFGymError: if the folder holds another training or a damaged one, another process trains in it, or learning
            diverged.
    """
    about = _plain({"training": training.document(), "origin": training.origin(), "versions": library_versions()})
    with made_folder(out), claimed(out):
        if not (out / NUMBERS).exists():
            torch.set_num_threads(1)
            env = environment_of(training)
            try:
                model, points = _learned(training, env, out, about, watch)
            finally:
                env.close()
            _write(training, model, points, out, about)
        return _finished(out, about)


def _learned(
    training: Training, env: ResidualVecEnv, out: Path, about: Mapping[str, Any], watch: Watch | None
) -> tuple[BaseAlgorithm, Points]:
    """The algorithm after all segments, and the learning curve."""
    place = out / CHECKPOINTS
    standing = read_newest(place, about)
    curve = Curve(training, () if standing is None else standing.curve, watch)
    for segment in range(0 if standing is None else standing.segment, training.n_segments):
        model = algorithm_of(training, env, seed=segment_seed(training.seed, segment), segment=segment)
        if standing is not None:
            standing.restore(model)
        _learn(model, training, segment, curve, out / TENSORBOARD)
        with made_folder(place):
            write_checkpoint(place, model, segment=segment + 1, curve=curve.points, about=about)
        standing = read_newest(place, about)
    assert standing is not None  # there is one segment at least
    model = algorithm_of(training, env, seed=0, segment=training.n_segments - 1)
    standing.restore(model)
    return model, standing.curve


def _write(training: Training, model: BaseAlgorithm, points: Points, out: Path, about: Mapping[str, Any]) -> None:
    """Write what a training gave, and remove its checkpoints."""
    head = {"algorithm": training.algorithm, "seed": training.seed, "robot": training.robot}
    numbers = {"env_steps": model.num_timesteps, "learning_curve": [list(point) for point in points]}
    meta = head | dict(about) | numbers
    policy = ResidualPolicy(
        base=training.base,
        machine=training.machine,
        actor=actor_of(model.policy),
        memory=training.memory,
        bound=training.bound,
        action_scale=training.action_scale,
        preview=training.preview,
        meta=meta,
    )
    data = encode_policy(policy)
    write_bytes(out / POLICY, data)
    write_json(out / NUMBERS, meta | {"sha256": hashlib.sha256(data).hexdigest()})
    shutil.rmtree(out / CHECKPOINTS, ignore_errors=True)


def segment_seed(seed: int, segment: int) -> int:
    """Seed of everything that is random in a segment."""
    return int(np.random.SeedSequence([seed, segment]).generate_state(1)[0] >> 1)


def library_versions() -> dict[str, str]:
    """Versions of everything that can change a trained policy."""
    own = {"torch": torch.__version__, "stable_baselines3": stable_baselines3.__version__}
    return versions() | own | {"sb3_contrib": sb3_contrib.__version__}


def _learn(model: BaseAlgorithm, training: Training, segment: int, curve: Curve, logs: Path) -> None:
    """Run a segment.

    Raises:
        FFGymError: if numbers of the networks are no longer finite.
    """
    logger = configure(str(logs), ["tensorboard"]) if installed("tensorboard") else Logger(None, [])
    model.set_logger(logger)
    steps = min(training.integer("segment_steps"), training.total - segment * training.integer("segment_steps"))
    try:
        model.learn(steps, callback=curve, reset_num_timesteps=False)
    except ValueError as error:  # torch refuses to draw actions about NaN
        _check_finite(model, training, error)
        raise
    finally:
        logger.close()
    _check_finite(model, training, None)


def _check_finite(model: BaseAlgorithm, training: Training, cause: Exception | None) -> None:
    if not all(bool(torch.isfinite(values).all()) for values in model.policy.state_dict().values()):
        raise FFGymError(
            f"The training diverged after {model.num_timesteps} steps: weights are no longer finite. Lower the "
            f"learning rate, which is {training.hyperparameters['learning_rate']}."
        ) from cause


def _finished(out: Path, about: Mapping[str, Any]) -> Trained:
    """The training that is done in a folder.

    Raises:
        FFGymError: if it is another one, or its files are damaged.
    """
    try:
        numbers = json.loads(read_text(out / NUMBERS))
        theirs, wanted = {key: numbers[key] for key in about}, numbers["sha256"]
    except (KeyError, TypeError, json.JSONDecodeError) as error:
        raise FFGymError(f"{out / NUMBERS}: is damaged. Remove the folder {out} to train again.") from error
    check_same(theirs, about, out)
    found = hashlib.sha256(read_bytes(out / POLICY)).hexdigest()
    if found != wanted:
        raise FFGymError(f"{out / POLICY}: is not what was written. Remove the folder {out} to train again.")
    return Trained(policy=load_policy(out / POLICY), file=out / POLICY, sha256=found)


def _plain(values: Mapping[str, Any]) -> dict[str, Any]:
    """As JSON gives it back, so that what is read compares with what is."""
    plain: dict[str, Any] = json.loads(json.dumps(values, allow_nan=False))
    return plain
