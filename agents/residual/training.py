"""Training of a residual policy in segments, so that an interruption leaves no trace in the result.

Each segment begins from its checkpoint alone, in an undisturbed training too: a new algorithm gets the networks,
optimisers, replay buffer and counters of the checkpoint, and torch, numpy, python and the environment are seeded by
training seed and number of the segment. Training that was killed is therefore equal, bit for bit, to one that was not.
"""

import hashlib
import io
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import sb3_contrib
import stable_baselines3
import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.buffers import ReplayBuffer
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import Logger, configure

from ffgym.agents.law_files import check_same
from ffgym.agents.residual.environment import ResidualVecEnv, make_environment
from ffgym.agents.residual.plan import Training
from ffgym.agents.residual.policy import ResidualPolicy, encode_policy, load_policy
from ffgym.agents.residual.sb3 import export_actor, make_algorithm
from ffgym.core.errors import FFGymError
from ffgym.core.files import filled_folder, read_bytes, read_text, write_bytes, write_json
from ffgym.core.provenance import is_installed, versions
from ffgym.core.typed_json import parse_json

Points = tuple[tuple[int, float], ...]
"""Points of a learning curve: steps, mean reward per step since the point before."""

POINTS = 4
"""Points of the curve in a segment, if it has as many steps."""


class RewardCurve(BaseCallback):
    """Mean reward per step, with exploration, in even parts of every segment, after the points so far."""

    def __init__(
        self,
        training: Training,
        points: Points,
        watch: Callable[[int, int], object] | None,
    ) -> None:
        super().__init__()
        self.points = points
        self._every = -(-training.integer("segment_steps") // POINTS)
        self._total, self._watch = training.total, watch
        self._sum, self._count = 0.0, 0

    def _on_training_start(self) -> None:
        self._sum, self._count = 0.0, 0

    def _on_step(self) -> bool:
        rewards = self.locals["rewards"]
        self._sum += float(rewards.sum())
        self._count += len(rewards)
        if self._count >= self._every:
            self._close()
        if self._watch is not None:
            self._watch(min(self.num_timesteps, self._total), self._total)
        return True

    def _on_training_end(self) -> None:
        if self._count:
            self._close()

    def _close(self) -> None:
        mean = self._sum / self._count
        self.points = (*self.points, (self.num_timesteps, mean))
        self.logger.record("train/reward_per_step", mean)
        self.logger.dump(self.num_timesteps)  # now: SAC and TQC else write when episodes end, the last point alone
        self._sum, self._count = 0.0, 0


POLICY, NUMBERS = "policy.npz", "training.json"
"""Files of a finished training."""
CHECKPOINT, TENSORBOARD = "checkpoint.pt", "tensorboard"
"""File and folder beside them; the first is removed at the end."""

Watch = Callable[[int, int], object]
"""Function that is called with the number of steps done, and of all steps."""


@dataclass(frozen=True, kw_only=True)
class Trained:
    """A finished training."""

    policy: ResidualPolicy = field(repr=False)
    file: Path
    sha256: str
    """Hash of the file."""

    @property
    def env_steps(self) -> int:
        """Control steps of all robots together."""
        return int(self.policy.meta["env_steps"])

    @property
    def curve(self) -> list[tuple[int, float]]:
        """Learning curve: steps, mean reward per step since the point before, with exploration."""
        return [(int(steps), float(reward)) for steps, reward in self.policy.meta["learning_curve"]]


def train(training: Training, out: Path, *, watch: Watch | None = None) -> Trained:
    """Train, or go on where the same training in the same folder stopped; read it if it is finished.

    Torch is set to one thread, and the generators of torch, numpy and python are seeded.

    Args:
        training: the training.
        out: folder for the policy, numbers, checkpoints and TensorBoard's files.
        watch: function that is called with the progress.

    Raises:
        FFGymError: if the folder holds another training or a damaged one, another process trains in it, or learning
            diverged.
    """
    about = {"training": training.document(), "origin": training.origin(), "versions": library_versions()}
    about = json.loads(json.dumps(about, allow_nan=False))  # as a file gives it back
    with filled_folder(out):
        if not (out / NUMBERS).exists():
            torch.set_num_threads(1)
            env = make_environment(training)
            try:
                model, points = _run_segments(training, env, out, about, watch)
            finally:
                env.close()
            _write(training, model, points, out, about)
        return _read_trained(out, about)


def _run_segments(
    training: Training, env: ResidualVecEnv, out: Path, about: Mapping[str, Any], watch: Watch | None
) -> tuple[BaseAlgorithm, Points]:
    """Run all segments that are left; return the algorithm after them, and the learning curve."""
    place = out / CHECKPOINT
    standing = read_checkpoint(place, about)
    curve = RewardCurve(training, () if standing is None else standing["curve"], watch)
    for segment in range(0 if standing is None else standing["segment"], training.n_segments):
        model = make_algorithm(training, env, seed=segment_seed(training.seed, segment), segment=segment)
        if standing is not None:
            restore(model, standing)
        _learn(model, training, segment, curve, out / TENSORBOARD)
        write_checkpoint(place, model, segment=segment + 1, curve=curve.points, about=about)
        standing = read_checkpoint(place, about)
    assert standing is not None  # there is one segment at least
    model = make_algorithm(training, env, seed=0, segment=training.n_segments - 1)
    restore(model, standing)
    return model, standing["curve"]


def _write(training: Training, model: BaseAlgorithm, points: Points, out: Path, about: Mapping[str, Any]) -> None:
    """Write policy and numbers of a training, and remove its checkpoint."""
    head = {"algorithm": training.algorithm, "seed": training.seed, "robot": training.robot}
    numbers = {"env_steps": model.num_timesteps, "learning_curve": [list(point) for point in points]}
    meta = head | dict(about) | numbers
    policy = ResidualPolicy(
        base=training.base,
        machine=training.machine,
        actor=export_actor(model.policy),
        memory=training.memory,
        bound=training.bound,
        action_scale=training.action_scale,
        preview=training.preview,
        meta=meta,
    )
    data = encode_policy(policy)
    write_bytes(out / POLICY, data)
    write_json(out / NUMBERS, meta | {"sha256": hashlib.sha256(data).hexdigest()})
    (out / CHECKPOINT).unlink()


def segment_seed(seed: int, segment: int) -> int:
    """Derive the seed of everything that is random in a segment."""
    return int(np.random.SeedSequence([seed, segment]).generate_state(1)[0] >> 1)


def library_versions() -> dict[str, str]:
    """Return the versions of everything that can change a trained policy."""
    own = {"torch": torch.__version__, "stable_baselines3": stable_baselines3.__version__}
    return versions() | own | {"sb3_contrib": sb3_contrib.__version__}


def _learn(model: BaseAlgorithm, training: Training, segment: int, curve: RewardCurve, logs: Path) -> None:
    """Train through one segment."""
    logger = configure(str(logs), ["tensorboard"]) if is_installed("tensorboard") else Logger(None, [])
    model.set_logger(logger)
    steps = min(training.integer("segment_steps"), training.total - segment * training.integer("segment_steps"))
    cause: ValueError | None = None
    try:
        model.learn(steps, callback=curve, reset_num_timesteps=False)
    except ValueError as error:  # torch refuses to draw actions about NaN
        cause = error
    finally:
        logger.close()
    if not all(bool(torch.isfinite(values).all()) for values in model.policy.state_dict().values()):
        raise FFGymError(
            f"The training diverged after {model.num_timesteps} steps: weights are no longer finite. Lower the "
            f"learning rate, which is {training.hyperparameters['learning_rate']}."
        ) from cause
    if cause is not None:
        raise cause


def _read_trained(out: Path, about: Mapping[str, Any]) -> Trained:
    """Read the finished training in a folder."""
    try:
        numbers = parse_json(read_text(out / NUMBERS), str(out / NUMBERS))
        theirs, wanted = {key: numbers[key] for key in about}, numbers["sha256"]
    except (KeyError, TypeError, FFGymError) as error:
        raise FFGymError(f"{out / NUMBERS}: is damaged. Remove the folder {out} to train again.") from error
    _check_training(theirs, about, out)
    found = hashlib.sha256(read_bytes(out / POLICY)).hexdigest()
    if found != wanted:
        raise FFGymError(f"{out / POLICY}: is not what was written. Remove the folder {out} to train again.")
    return Trained(policy=load_policy(out / POLICY), file=out / POLICY, sha256=found)


def restore(model: BaseAlgorithm, standing: Mapping[str, Any]) -> None:
    """Restore an algorithm from a checkpoint: networks, optimisers, replay buffer, counters."""
    model.set_parameters(standing["parameters"], exact_match=True, device="cpu")
    for name, values in standing["tensors"].items():
        getattr(model, name).data.copy_(values)
    model.num_timesteps, model._n_updates = standing["num_timesteps"], standing["n_updates"]
    buffer = getattr(model, "replay_buffer", None)
    if isinstance(buffer, ReplayBuffer):
        for name, values in standing["replay"].items():
            getattr(buffer, name)[: len(values)] = values.numpy()
        buffer.pos, buffer.full = standing["replay_at"]


def write_checkpoint(
    file: Path, model: BaseAlgorithm, *, segment: int, curve: Points, about: Mapping[str, Any]
) -> None:
    """Write a checkpoint, `segment` next, in place of the one before it: its sha256, then the bytes that torch saves.

    Raises:
        FFGymError: if it cannot be written.
    """
    _, tensors = model._get_torch_save_params()
    state: dict[str, Any] = {
        "about": json.dumps(about),
        "segment": segment,
        "curve": curve,
        "parameters": model.get_parameters(),
        "tensors": {name: getattr(model, name).detach() for name in tensors},
        "num_timesteps": model.num_timesteps,
        "n_updates": model._n_updates,
    }
    buffer = getattr(model, "replay_buffer", None)
    if isinstance(buffer, ReplayBuffer):
        used = buffer.buffer_size if buffer.full else buffer.pos
        state["replay"] = {name: torch.tensor(getattr(buffer, name)[:used]) for name in _REPLAYED}
        state["replay_at"] = (buffer.pos, buffer.full)
    stream = io.BytesIO()
    torch.save(state, stream)
    data = stream.getvalue()
    write_bytes(file, hashlib.sha256(data).digest() + data)


def read_checkpoint(file: Path, about: Mapping[str, Any]) -> dict[str, Any] | None:
    """Read a checkpoint: the next `segment`, its `curve` and the state that `restore` needs; None if there is none.

    Raises:
        FFGymError: if it is of another training, or damaged.
    """
    if not file.exists():
        return None
    try:
        data = file.read_bytes()
    except OSError as error:
        raise FFGymError(f"{file}: cannot be read: {error.strerror}.") from error
    if hashlib.sha256(data[32:]).digest() != data[:32]:
        raise FFGymError(
            f"{file}: the checkpoint is damaged: it is not what was written. Remove it to begin the training anew."
        )
    state: dict[str, Any] = torch.load(io.BytesIO(data[32:]), weights_only=True)
    _check_training(json.loads(state["about"]), about, file.parent)
    return state


def _check_training(theirs: Mapping[str, Any], ours: Mapping[str, Any], folder: Path) -> None:
    check_same(theirs, ours, folder, "another training", "Choose another folder, or remove this one.")


_REPLAYED = ("observations", "next_observations", "actions", "rewards", "dones", "timeouts")
"""Arrays of a replay buffer."""
