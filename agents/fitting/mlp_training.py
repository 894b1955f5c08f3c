"""How the weights of a multi-layer perceptron are found, with torch: all at once, or sample by sample.

All arithmetic is in double precision on one thread, and joints do not touch each other: Adam treats every weight by
itself, so that what one motor learns does not depend on the others.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, BoolArray, IntArray

if TYPE_CHECKING:
    from torch import Tensor

N_STEPS = 200
"""Full-batch steps of Adam in an update. Chosen: with 50, ten updates leave a tenth more motor error."""
STEP_SIZE = 0.02
"""Of Adam. Chosen: at 0.005, learning takes twice the trials."""
N_ROWS = 500
"""Samples of a lesson in an update, evenly in time. Chosen: a speed of the motors counts alike in each lesson, and an
update of six motors on three motions takes about a second."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Examples:
    """What a network shall say: R rows for each of N joints."""

    inputs: Array
    """Scaled speed and acceleration, shape (N, R, 2)."""
    targets: Array
    """Torque in units of its scale, shape (N, R)."""


def fitted(weights: Mapping[str, Array], examples: Examples) -> dict[str, Array]:
    """Weights (see `ffgym.agents.feedback_error.MLP`) after `N_STEPS` steps towards the least mean square error.

    Raises:
        FFGymError: if torch is missing.
    """
    torch = _require_torch()
    with _one_thread(torch):
        x, y = torch.from_numpy(examples.inputs.copy()), torch.from_numpy(examples.targets.copy())
        tensors = _tensors(torch, weights)
        adam = torch.optim.Adam(tensors.values(), lr=STEP_SIZE)
        for _ in range(N_STEPS):
            adam.zero_grad()
            _cost(torch, tensors, x, y).backward()
            adam.step()
        return {name: tensor.detach().numpy().copy() for name, tensor in tensors.items()}


def walked(weights: Mapping[str, Array], examples: Examples, rate: float) -> dict[str, Array]:
    """Weights after one gradient step of `rate` on each row, in order: thesis (3.15) for all weights of a network.

    Raises:
        FFGymError: if torch is missing.
    """
    torch = _require_torch()
    with _one_thread(torch):
        x, y = torch.from_numpy(examples.inputs.copy()), torch.from_numpy(examples.targets.copy())
        tensors = _tensors(torch, weights)
        descent = torch.optim.SGD(tensors.values(), lr=rate)
        for row in range(x.shape[1]):
            descent.zero_grad()
            (0.5 * _cost(torch, tensors, x[:, row : row + 1], y[:, row : row + 1])).backward()
            descent.step()
        return {name: tensor.detach().numpy().copy() for name, tensor in tensors.items()}


def evenly(moving: BoolArray) -> IntArray:
    """Indices of at most `N_ROWS` rows, spread evenly over those that move."""
    rows = np.flatnonzero(moving)
    if len(rows) <= N_ROWS:
        return rows
    return np.asarray(rows[np.linspace(0, len(rows) - 1, N_ROWS).round().astype(np.int64)])


def _tensors(torch: ModuleType, weights: Mapping[str, Array]) -> "dict[str, Tensor]":
    return {name: torch.tensor(value, dtype=torch.float64, requires_grad=True) for name, value in weights.items()}


def _cost(torch: ModuleType, weights: "dict[str, Tensor]", x: "Tensor", y: "Tensor") -> "Tensor":
    """Mean square error over rows, summed over joints."""
    inside = x @ weights["hidden"].transpose(1, 2) + weights["bias"][:, None]
    said = (torch.tanh(inside) * weights["output"][:, None]).sum(-1) + weights["offset"][:, None]
    cost: Tensor = ((said - y) ** 2).mean(1).sum()
    return cost


def _require_torch() -> ModuleType:
    try:
        import torch
    except ImportError as error:
        raise FFGymError("Training a multi-layer perceptron needs torch; pip install 'ffgym[rl]'.") from error
    return torch


@contextmanager
def _one_thread(torch: ModuleType) -> Iterator[None]:
    """Compute on one thread, so that sums do not depend on the machine; put the caller's setting back."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(threads)
