"""What an agent is."""

from typing import Any, Protocol, runtime_checkable

from ffgym.types import Array


@runtime_checkable
class Agent(Protocol):
    """Anything with the `predict` of stable-baselines3."""

    def predict(
        self,
        observation: Array,
        state: Any = None,
        episode_start: Any = None,
        deterministic: bool = False,
    ) -> tuple[Array, Any]:
        """Actions (B, N) for observations (B, D), and the state to pass in next time."""
