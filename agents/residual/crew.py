"""Residual policies that differ in nothing but their weights, side by side: the base law runs once for all of them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.agents.residual.actor import Actor
from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, BoolArray


@dataclass(frozen=True, kw_only=True, eq=False)
class ActorCrew:
    """Actors of one shape as one, on equal shares of the rows: the first actor's in front."""

    actors: tuple[Actor, ...]

    def __post_init__(self) -> None:
        if not same_shape(self.actors):
            raise FFGymError("A crew is of one or more actors of the same shape.")

    @property
    def n_motors(self) -> int:
        """N."""
        return self.actors[0].n_motors

    @property
    def n_features(self) -> int:
        """Of all motors together."""
        return self.actors[0].n_features

    def initial_state(self, shape: tuple[int, ...] = ()) -> Array:
        """See `Actor.initial_state`."""
        return self.actors[0].initial_state(shape)

    def act(self, features: Array, state: Array, begins: BoolArray | None = None) -> tuple[Array, Array]:
        """See `Actor.act`; rows (B, N F) with B a multiple of the number of actors.

        Raises:
            FFGymError: if rows cannot be shared out equally.
        """
        count = len(self.actors)
        if len(features) % count:
            raise FFGymError(f"{len(features)} rows cannot be shared out equally among {count} actors.")
        flags = np.zeros(len(features), dtype=np.bool_) if begins is None else begins
        shares = zip(*(np.split(rows, count) for rows in (features, state, flags)), strict=True)
        acted = [actor.act(*share) for actor, share in zip(self.actors, shares, strict=True)]
        return np.concatenate([residual for residual, _ in acted]), np.concatenate([known for _, known in acted])


def _shape_of(actor: Actor) -> tuple[object, ...]:
    """What actors of one crew have in common."""
    weights = ((name, weight.shape) for name, weight in actor.arrays().items())
    return (*actor.settings().items(), *weights)


def same_shape(actors: Sequence[Actor]) -> bool:
    """Whether actors can be one crew; nobody is none."""
    return len({_shape_of(actor) for actor in actors}) == 1
