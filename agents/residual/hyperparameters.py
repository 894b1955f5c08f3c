"""Hyper-parameters of the algorithms that train residual policies, and their limits."""

import tomllib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from ffgym.agents.residual.actor import ACTIVATIONS
from ffgym.core.errors import FFGymError, check_choice, check_number, check_whole

FILE = Path(__file__).with_suffix(".toml")
"""File with a table for each algorithm, every number with its reason."""
Value = float | int | str | tuple[int, ...]
"""Value of a hyper-parameter."""


Check = Callable[[str, Any], Value]
"""Function that checks the value of a hyper-parameter, given its name; raises FFGymError if it is out of range."""


def _number(low: float, high: float, *, open_low: bool = False) -> Check:
    return lambda name, value: check_number(name, value, low=low, high=high, open_low=open_low)


def _count(low: int, high: int = 10**9) -> Check:
    return lambda name, value: check_whole(name, value, low=low, high=high)


def _widths(name: str, value: Any) -> Value:
    """Check the widths of the hidden layers of a network."""
    if not isinstance(value, list | tuple) or not 1 <= len(value) <= 4:
        raise FFGymError(f"{name} = {value!r} must be a list of one to four widths, e.g. [32, 32].")
    return tuple(check_whole(name, width, low=1, high=4096) for width in value)


_SHARE = _number(0.0, 1.0)
_SHARE_ABOVE_0 = _number(0.0, 1.0, open_low=True)
_ALL: dict[str, Check] = {
    "learning_rate": _SHARE_ABOVE_0,
    "final_learning_rate": _SHARE,
    "gamma": _SHARE,
    "first_std": _SHARE_ABOVE_0,
    "hidden": _widths,
    "critic_hidden": _widths,
    "activation": lambda name, value: check_choice(name, str(value), tuple(ACTIVATIONS)),
    "n_envs": _count(1, 100_000),
    "batch_size": _count(2),
    "segment_steps": _count(1),
    "max_grad_norm": _number(0.0, 1e6, open_low=True),
}
_ON_POLICY: dict[str, Check] = {
    "n_steps": _count(2, 1_000_000),
    "n_epochs": _count(1, 1000),
    "gae_lambda": _SHARE,
    "clip_range": _number(0.0, 10.0, open_low=True),
    "ent_coef": _number(0.0, 100.0),
    "vf_coef": _number(0.0, 100.0),
}
_OFF_POLICY: dict[str, Check] = {
    "buffer_size": _count(10),
    "tau": _SHARE_ABOVE_0,
    "train_freq": _count(1, 100_000),
    "gradient_steps": _count(1, 100_000),
    "learning_starts": _count(0),
    "prefill_std": _SHARE_ABOVE_0,
    "first_ent_coef": _number(0.0, 100.0, open_low=True),
    "entropy_per_motor": _number(-100.0, 100.0),
}
_SAC = {name: check for name, check in _ALL.items() if name != "max_grad_norm"} | _OFF_POLICY

ALGORITHMS: Mapping[str, Mapping[str, Check]] = MappingProxyType(
    {
        "ppo": _ALL | _ON_POLICY,
        "sac": _SAC,
        "tqc": _SAC
        | {"n_critics": _count(1, 100), "n_quantiles": _count(1, 1000), "top_quantiles_to_drop": _count(0, 1000)},
        "recurrent_ppo": _ALL | _ON_POLICY | {"lstm_cells": _count(1, 4096)},
    }
)
"""Algorithms, and the checks of their hyper-parameters."""


def hyperparameters(algorithm: str, changes: Sequence[str] = ()) -> dict[str, Value]:
    """Read the hyper-parameters of an algorithm, some changed as in ['gamma=0.95', 'hidden=[64,64]'].

    Raises:
        FFGymError: if there is no such algorithm, or a change is no name=value, named twice, or not valid.
    """
    check_choice("algorithm", algorithm, list(ALGORITHMS))
    values: dict[str, Any] = tomllib.loads(FILE.read_text(encoding="utf-8"))[algorithm]
    seen: set[str] = set()
    for change in changes:
        name, equals, text = change.partition("=")
        if not equals or name in seen:
            what = "stands twice" if name in seen else "is no name=value"
            raise FFGymError(f"{change!r} {what}. Say what to change once each, e.g. gamma=0.95 hidden=[64,64].")
        seen.add(name)
        check_choice(f"hyper-parameter of {algorithm}", name, list(ALGORITHMS[algorithm]))
        try:
            values[name] = tomllib.loads(f"value = {text}")["value"]
        except tomllib.TOMLDecodeError:
            values[name] = text  # a word
    return check_hyperparameters(algorithm, values)


def check_hyperparameters(algorithm: str, values: Mapping[str, Any]) -> dict[str, Value]:
    """Check that hyper-parameters of an algorithm are complete, each within its limits.

    Raises:
        FFGymError: if one is unknown, missing or out of range, or some do not fit each other.
    """
    known = ALGORITHMS[check_choice("algorithm", algorithm, list(ALGORITHMS))]
    for name in values:
        check_choice(f"hyper-parameter of {algorithm}", name, list(known))
    missing = sorted(set(known) - set(values))
    if missing:
        raise FFGymError(f"Hyper-parameters of {algorithm} lack {', '.join(missing)}.")
    found = {name: check(name, values[name]) for name, check in known.items()}
    # steps of all robots together between two updates
    rollout = int(found["n_steps"] if "n_steps" in found else found["train_freq"]) * int(found["n_envs"])  # type: ignore[arg-type]
    segment, batch = found["segment_steps"], found["batch_size"]
    if int(segment) % rollout:  # type: ignore[arg-type]
        raise FFGymError(
            f"segment_steps = {segment} of {algorithm} must be a multiple of {rollout}, the steps of all robots "
            f"together between two updates."
        )
    if "n_steps" in found and rollout % int(batch):  # type: ignore[arg-type]
        raise FFGymError(f"batch_size = {batch} of {algorithm} must divide n_steps * n_envs = {rollout}.")
    if algorithm == "tqc" and int(found["top_quantiles_to_drop"]) >= int(found["n_quantiles"]):  # type: ignore[arg-type]
        raise FFGymError(
            f"top_quantiles_to_drop = {found['top_quantiles_to_drop']} must be less than n_quantiles = "
            f"{found['n_quantiles']}."
        )
    return found
