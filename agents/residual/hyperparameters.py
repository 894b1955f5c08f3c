"""Hyper-parameters of the algorithms that train residual policies: which there are, and within which limits."""

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from ffgym.agents.residual.actor import ACTIVATIONS
from ffgym.core.errors import FFGymError, check_choice, check_number, check_whole

FILE = Path(__file__).with_suffix(".toml")
"""A table for each algorithm, every number with its reason."""
Value = float | int | str | tuple[int, ...]
"""Of a hyper-parameter."""


@dataclass(frozen=True, kw_only=True)
class Number:
    """A number that may be chosen within limits."""

    low: float
    high: float
    whole: bool = False
    open_low: bool = False

    def checked(self, name: str, value: Any) -> Value:
        """The value.

        Raises:
            FFGymError: if it is out of range.
        """
        if self.whole:
            return check_whole(name, value, low=round(self.low), high=round(self.high))
        return check_number(name, value, low=self.low, high=self.high, open_low=self.open_low)


@dataclass(frozen=True, kw_only=True)
class Widths:
    """Widths of the hidden layers of a network."""

    def checked(self, name: str, value: Any) -> Value:
        """The value.

        Raises:
            FFGymError: if it is no list of one to four widths.
        """
        if not isinstance(value, list | tuple) or not 1 <= len(value) <= 4:
            raise FFGymError(f"{name} = {value!r} must be a list of one to four widths, e.g. [32, 32].")
        return tuple(check_whole(name, width, low=1, high=4096) for width in value)


@dataclass(frozen=True, kw_only=True)
class Choice:
    """One of some words."""

    words: tuple[str, ...]

    def checked(self, name: str, value: Any) -> Value:
        """The value.

        Raises:
            FFGymError: if it is none of them.
        """
        return check_choice(name, str(value), self.words)


def _count(low: int, high: int = 10**9) -> Number:
    return Number(low=low, high=high, whole=True)


_POSITIVE = Number(low=0.0, high=1e6, open_low=True)
_SHARE = Number(low=0.0, high=1.0)
_ALL: dict[str, Number | Widths | Choice] = {
    "learning_rate": Number(low=0.0, high=1.0, open_low=True),
    "final_learning_rate": Number(low=0.0, high=1.0),
    "gamma": _SHARE,
    "first_std": Number(low=0.0, high=1.0, open_low=True),
    "hidden": Widths(),
    "critic_hidden": Widths(),
    "activation": Choice(words=tuple(ACTIVATIONS)),
    "n_envs": _count(1, 100_000),
    "batch_size": _count(2),
    "segment_steps": _count(1),
    "max_grad_norm": _POSITIVE,
}
_ON_POLICY: dict[str, Number | Widths | Choice] = {
    "n_steps": _count(2, 1_000_000),
    "n_epochs": _count(1, 1000),
    "gae_lambda": _SHARE,
    "clip_range": Number(low=0.0, high=10.0, open_low=True),
    "ent_coef": Number(low=0.0, high=100.0),
    "vf_coef": Number(low=0.0, high=100.0),
}
_OFF_POLICY: dict[str, Number | Widths | Choice] = {
    "buffer_size": _count(10),
    "tau": Number(low=0.0, high=1.0, open_low=True),
    "train_freq": _count(1, 100_000),
    "gradient_steps": _count(1, 100_000),
    "learning_starts": _count(0),
    "prefill_std": Number(low=0.0, high=1.0, open_low=True),
    "first_ent_coef": Number(low=0.0, high=100.0, open_low=True),
    "entropy_per_motor": Number(low=-100.0, high=100.0),
}
_SAC = {name: kind for name, kind in _ALL.items() if name != "max_grad_norm"} | _OFF_POLICY

ALGORITHMS: Mapping[str, Mapping[str, Number | Widths | Choice]] = MappingProxyType(
    {
        "ppo": _ALL | _ON_POLICY,
        "sac": _SAC,
        "tqc": _SAC
        | {"n_critics": _count(1, 100), "n_quantiles": _count(1, 1000), "top_quantiles_to_drop": _count(0, 1000)},
        "recurrent_ppo": _ALL | _ON_POLICY | {"lstm_cells": _count(1, 4096)},
    }
)
"""Algorithms, and what may be said of each."""


def hyperparameters(algorithm: str) -> dict[str, Value]:
    """Hyper-parameters of an algorithm as its file has them.

    Raises:
        FFGymError: if there is no such algorithm.
    """
    check_choice("algorithm", algorithm, list(ALGORITHMS))
    return checked(algorithm, tomllib.loads(FILE.read_text(encoding="utf-8"))[algorithm])


def checked(algorithm: str, values: Mapping[str, Any]) -> dict[str, Value]:
    """Hyper-parameters of an algorithm, all of them, each within its limits.

    Raises:
        FFGymError: if one is unknown, missing or out of range, or some do not fit each other.
    """
    known = ALGORITHMS[check_choice("algorithm", algorithm, list(ALGORITHMS))]
    for name in values:
        check_choice(f"hyper-parameter of {algorithm}", name, list(known))
    missing = sorted(set(known) - set(values))
    if missing:
        raise FFGymError(f"Hyper-parameters of {algorithm} lack {', '.join(missing)}.")
    found = {name: kind.checked(name, values[name]) for name, kind in known.items()}
    _check_fit(algorithm, found)
    return found


def changed(algorithm: str, changes: Sequence[str]) -> dict[str, Value]:
    """Hyper-parameters of an algorithm with some changed, as in ['gamma=0.95', 'hidden=[64,64]'].

    Raises:
        FFGymError: if a change is no name=value, named twice, or not valid.
    """
    values: dict[str, Any] = dict(hyperparameters(algorithm))
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
    return checked(algorithm, values)


def rollout_steps(values: Mapping[str, Value]) -> int:
    """Steps of all robots together between two updates."""
    per_robot = values["n_steps"] if "n_steps" in values else values["train_freq"]
    return int(per_robot) * int(values["n_envs"])  # type: ignore[arg-type]


def _check_fit(algorithm: str, values: Mapping[str, Value]) -> None:
    rollout, segment, batch = rollout_steps(values), values["segment_steps"], values["batch_size"]
    if int(segment) % rollout:  # type: ignore[arg-type]
        raise FFGymError(
            f"segment_steps = {segment} of {algorithm} must be a multiple of {rollout}, the steps of all robots "
            f"together between two updates."
        )
    if "n_steps" in values and rollout % int(batch):  # type: ignore[arg-type]
        raise FFGymError(f"batch_size = {batch} of {algorithm} must divide n_steps * n_envs = {rollout}.")
    if algorithm == "tqc" and int(values["top_quantiles_to_drop"]) >= int(values["n_quantiles"]):  # type: ignore[arg-type]
        raise FFGymError(
            f"top_quantiles_to_drop = {values['top_quantiles_to_drop']} must be less than n_quantiles = "
            f"{values['n_quantiles']}."
        )
