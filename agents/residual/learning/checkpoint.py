"""Where a training stands between two segments: a folder that appears whole, beside those before it until then."""

import hashlib
import io
import json
import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.buffers import ReplayBuffer

from ffgym.core.errors import FFGymError
from ffgym.core.files import decode_arrays, encode_arrays, new_folder, read_bytes, read_text, write_bytes, write_json

HEADER = "checkpoint.json"
_PREFIX = "segment_"
_ARRAYS = ("observations", "next_observations", "actions", "rewards", "dones", "timeouts")
"""Of the replay buffer."""


@dataclass(frozen=True, kw_only=True)
class Standing:
    """A checkpoint that was read."""

    segment: int
    """Number of the segment that is next."""
    curve: tuple[tuple[int, float], ...]
    """Steps, mean reward per step since the point before."""
    files: Mapping[str, bytes]

    def restore(self, model: BaseAlgorithm) -> None:
        """Give a new algorithm everything that it had: networks, optimisers, replay buffer, counters."""
        state = torch.load(io.BytesIO(self.files["state.pt"]), weights_only=True)
        model.set_parameters(state["parameters"], exact_match=True, device="cpu")
        for name, values in state["tensors"].items():
            getattr(model, name).data.copy_(values)
        model.num_timesteps, model._n_updates = state["num_timesteps"], state["n_updates"]
        buffer = getattr(model, "replay_buffer", None)
        if isinstance(buffer, ReplayBuffer):
            for name, values in decode_arrays(self.files["replay.npz"]).items():
                getattr(buffer, name)[: len(values)] = values
            buffer.pos, buffer.full = state["replay"]


def write_checkpoint(
    folder: Path, model: BaseAlgorithm, *, segment: int, curve: tuple[tuple[int, float], ...], about: Mapping[str, Any]
) -> None:
    """Write a checkpoint, then remove those before it.

    Args:
        folder: of all checkpoints of a training.
        model: as the last segment left it.
        segment: number of the next segment.
        curve: of learning so far.
        about: what the training is, see `read_newest`.

    Raises:
        FFGymError: if it cannot be written.
    """
    older = _all(folder)
    files = _files_of(model)
    with new_folder(folder / f"{_PREFIX}{segment:06d}") as place:
        for name, data in files.items():
            write_bytes(place / name, data)
        sums = {name: hashlib.sha256(data).hexdigest() for name, data in files.items()}
        write_json(place / HEADER, {"segment": segment, "curve": curve, "about": about, "sha256": sums})
    for place in older:
        shutil.rmtree(place, ignore_errors=True)


def read_newest(folder: Path, about: Mapping[str, Any]) -> Standing | None:
    """The newest checkpoint of a training; None if there is none.

    Args:
        folder: of its checkpoints.
        about: what the training is, as JSON has it.

    Raises:
        FFGymError: if it is of another training, or damaged.
    """
    places = _all(folder)
    if not places:
        return None
    place = places[-1]
    try:
        header = json.loads(read_text(place / HEADER))
        files = {name: read_bytes(place / name) for name in header["sha256"]}
        segment, curve, theirs = header["segment"], header["curve"], header["about"]
        wrong = [name for name, data in files.items() if hashlib.sha256(data).hexdigest() != header["sha256"][name]]
        if wrong or "state.pt" not in files:
            raise FFGymError(f"{' and '.join(wrong) or 'state.pt'} is not what was written")
    except (KeyError, TypeError, AttributeError, ValueError) as error:  # ours are ValueErrors too
        reason = str(error).rstrip(".")
        raise FFGymError(
            f"{place}: the checkpoint is damaged: {reason}. Remove the folder {folder} to begin the training anew."
        ) from error
    check_same(theirs, about, folder.parent)
    return Standing(segment=int(segment), curve=tuple((int(n), float(r)) for n, r in curve), files=files)


def check_same(theirs: Mapping[str, Any], ours: Mapping[str, Any], folder: Path, what: str = "training") -> None:
    """Check that a folder is of this training, or whatever it holds.

    Raises:
        FFGymError: if not; the message says what differs.
    """
    flat, own = _flat(theirs), _flat(ours)
    changes = [
        f"{name} was {_short(flat.get(name))}, now {_short(own.get(name))}"
        for name in sorted(set(flat) | set(own))
        if flat.get(name) != own.get(name)
    ]
    if changes:
        raise FFGymError(
            f"{folder}: holds another {what}: {'; '.join(changes)}. Choose another folder, or remove this one."
        )


def _files_of(model: BaseAlgorithm) -> dict[str, bytes]:
    _, tensors = model._get_torch_save_params()
    state: dict[str, Any] = {
        "parameters": model.get_parameters(),
        "tensors": {name: getattr(model, name).detach() for name in tensors},
        "num_timesteps": model.num_timesteps,
        "n_updates": model._n_updates,
    }
    files = {}
    buffer = getattr(model, "replay_buffer", None)
    if isinstance(buffer, ReplayBuffer):
        used = buffer.buffer_size if buffer.full else buffer.pos
        files["replay.npz"] = encode_arrays({name: getattr(buffer, name)[:used] for name in _ARRAYS})
        state["replay"] = (buffer.pos, buffer.full)
    stream = io.BytesIO()
    torch.save(state, stream)
    return files | {"state.pt": stream.getvalue()}


def _all(folder: Path) -> list[Path]:
    """Checkpoints from old to new."""
    return sorted(folder.glob(f"{_PREFIX}*")) if folder.is_dir() else []


def _flat(values: Mapping[str, Any]) -> dict[str, Any]:
    """Entries of tables in tables by one name each."""
    flat: dict[str, Any] = {}
    for name, value in values.items():
        if isinstance(value, Mapping):
            flat |= {f"{name}.{inner}": each for inner, each in _flat(value).items()}
        else:
            flat[name] = value
    return flat


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
