"""A residual policy in one environment: base law and network with stable-baselines3's `predict`."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ffgym.agents.residual.actor import Actor
from ffgym.agents.residual.composition import Composition, Memory, chosen
from ffgym.agents.residual.crew import ActorCrew
from ffgym.core.errors import FFGymError
from ffgym.core.types import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class AgentState:
    """What a residual agent remembers from one decision to the next."""

    memory: Memory
    residual: Array
    """What it added last, in [-1, 1], shape (B, N)."""
    network: Array
    """State of the network, see `Actor.initial_state`."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ResidualAgent:
    """A composition and the network on top of it, or several networks that share its rows."""

    composition: Composition
    actor: Actor | ActorCrew

    def __post_init__(self) -> None:
        features = self.composition.features
        if (self.actor.n_motors, self.actor.n_features) != (features.layout.n_joints, features.size):
            raise FFGymError(
                f"A policy for {self.actor.n_motors} motors and {self.actor.n_features} features does not fit an "
                f"environment with {features.layout.n_joints} motors, which has {features.size}."
            )

    def predict(
        self,
        observation: Array,
        state: AgentState | None = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> tuple[Array, AgentState]:
        """Actions for observations (B, D) or (D,), shape (B, N) or (N,), and what to remember for the next call.

        Args:
            observation: one observation, or a batch of them.
            state: what the last call returned, None at first.
            episode_start: True where an episode begins, shape (B,) or (); None is nowhere.
            deterministic: without effect, a trained policy does not explore.

        Raises:
            FFGymError: if observations are of another environment, or the state is of another batch.
        """
        seen_now = np.asarray(observation)
        size = self.composition.features.layout.size
        if seen_now.ndim not in (1, 2) or seen_now.shape[-1] < size:
            raise FFGymError(
                f"Observations must have {size} numbers each, as those of the environment that this agent was made "
                f"for, got shape {seen_now.shape}."
            )
        rows = np.atleast_2d(seen_now)
        if state is None:
            seen, network = self.composition.begin(rows), self.actor.initial_state((len(rows),))
            begins = np.ones(len(rows), dtype=np.bool_)
        else:
            if len(state.residual) != len(rows):
                raise FFGymError(
                    f"The state of {len(state.residual)} robots is not what predict returned for {len(rows)}; give "
                    f"None where a batch begins."
                )
            begins = np.zeros(len(rows), dtype=np.bool_) if episode_start is None else _flags(episode_start, len(rows))
            seen, network = self.composition.follow(state.memory, rows, state.residual), state.network
            if begins.any():
                seen = chosen(begins, self.composition.begin(rows), seen)
        residual, network = self.actor.act(seen.features, network, begins)
        action = self.composition.action(seen, residual)
        known = AgentState(memory=seen.memory, residual=residual, network=network)
        return (action[0] if seen_now.ndim == 1 else action), known


def _flags(episode_start: Any, count: int) -> Any:
    flags = np.atleast_1d(np.asarray(episode_start, dtype=np.bool_))
    if flags.shape != (count,):
        raise FFGymError(f"episode_start has shape {flags.shape}, must be ({count},): one for each observation.")
    return flags
