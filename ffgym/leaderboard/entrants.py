"""Entrants of the leaderboard: agents by name, and the functions that make them for a plant."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeAlias

from ffgym.control import FeedForwardLaw, Policy, SetpointChannel
from ffgym.core.errors import FFGymError, check_choice
from ffgym.leaderboard.plants import TestPlant
from ffgym.leaderboard.results import Row, SentSetpoints
from ffgym.leaderboard.tasks import Task


@dataclass(frozen=True, kw_only=True, eq=False)
class ReadyAgent:
    """An agent for one plant: a law, which runs along whole references, or a policy, which acts in an environment."""

    law: FeedForwardLaw | None = None
    policy: Policy | None = None
    timed: Policy | None = None
    """A law as a policy, whose decisions are timed; None where a law needs the whole motion beforehand."""
    channel: SetpointChannel | None = None
    """Set-point channel that the law acts through; None adds its torque. A policy has an attribute `channel`."""
    artefact: str | None = None
    """sha256 of the file it was read from; None if it was not read from one."""
    robot_seconds: float = 0.0
    """Time that a machine moved while it learned for this plant [s]."""
    env_steps: int = 0
    """Control steps of simulated training."""

    def __post_init__(self) -> None:
        if (self.law is None) == (self.policy is None):
            raise FFGymError("An agent is either a law or a policy; give one of both.")
        if self.policy is not None and self.channel is not None:
            raise FFGymError("A policy acts through its own attribute channel, 'torque' or 'setpoint'; leave this out.")


Maker: TypeAlias = Callable[[TestPlant, Sequence[int], tuple[Task, ...]], list[ReadyAgent | None]]
"""Function that makes an agent once for each seed."""


def one_by_one(make: Callable[[TestPlant, int, tuple[Task, ...]], ReadyAgent | None]) -> Maker:
    """Return a maker that makes an agent seed by seed."""

    def each(plant: TestPlant, seeds: Sequence[int], tasks: tuple[Task, ...]) -> list[ReadyAgent | None]:
        return [make(plant, seed, tasks) for seed in seeds]

    return each


@dataclass(frozen=True, kw_only=True, eq=False)
class Entrant:
    """An agent that takes part; `Row` describes the fields that it shares."""

    name: str
    title: str
    track: str
    about: str
    page: str | None = None
    base: str | None = None
    feedback: bool = False
    channel: SetpointChannel | None = None
    """Set-point channel that it acts through; None adds torque."""
    seeds: tuple[int, ...] = (0,)
    """Seeds to run; one, unless a seed changes the agent."""
    command: str | None = None
    ranked: bool = True
    slow: bool = False
    """True if it practises on every task first, which takes minutes; it takes part only if it is named."""
    artefact: Callable[[str, int], str | None] = field(default=lambda plant, seed: None, repr=False)
    """sha256 of the file for a plant, by name, and a seed; None if it is not read from one."""
    learning_curve: Callable[[], tuple[tuple[float, float], ...]] = field(default=tuple, repr=False)
    ready: Maker = field(repr=False)
    """Function that makes the agent for a plant, each seed, and the tasks to come; None if it has none."""

    def __post_init__(self) -> None:
        if not isinstance(self.channel, SetpointChannel | None):
            raise FFGymError(
                f"channel of agent {self.name!r} must be a SetpointChannel(), or None for torque, got {self.channel!r}."
            )

    def row(self) -> Row:
        """Make its row, without outcomes."""
        names = ("name", "title", "track", "about", "page", "base", "feedback", "command", "ranked")
        said: dict[str, Any] = {name: getattr(self, name) for name in names}
        sent = None if self.channel is None else SentSetpoints.through(self.channel)
        return Row(
            **said, setpoints=sent, seeded=len(self.seeds) > 1, outcomes=(), learning_curve=self.learning_curve()
        )


@dataclass(frozen=True)
class Registry:
    """Source of entrants for this process and others; places are given as 'package.module:NAME'."""

    known: str
    """Place of a mapping from names to entrants."""
    maker: str = ""
    """Place of a function that makes an entrant from a file."""
    files: tuple[str, ...] = ()
    """Files of further entrants."""


def find_entrants(registry: Registry) -> Mapping[str, Entrant]:
    """Find all entrants of a registry; FFGymError if one of a file cannot be made, or has the name of another."""
    found: dict[str, Entrant] = dict(_at(registry.known))
    for file in registry.files:
        entrant = _make(registry.maker, file)
        if entrant.name in found:
            raise FFGymError(f"{file}: its name {entrant.name!r} is that of another agent; submit it with another one.")
        found[entrant.name] = entrant
    return MappingProxyType(found)


@cache
def _make(maker: str, file: str) -> Entrant:
    entrant: Entrant = _at(maker)(Path(file))
    return entrant


def _at(place: str) -> Any:
    module, _, name = place.partition(":")
    return getattr(import_module(module), name)


def find_entrant(registry: Registry, name: str) -> Entrant:
    """Find an entrant by its name."""
    every = find_entrants(registry)
    return every[check_choice("agent", name, list(every))]
