"""What an agent is, and what chooses the environment that it acts in."""

from typing import Any, Protocol, runtime_checkable

from ffgym.control.observation import ObservationLayout
from ffgym.core.types import Array
from ffgym.robot import RobotDescription


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


@runtime_checkable
class Policy(Protocol):
    """What makes an agent for an environment, from nothing but what a controller knows."""

    @property
    def preview(self) -> int:
        """Samples of the reference that it must see ahead, as the environment's keyword argument."""

    @property
    def action_scale(self) -> float:
        """Torque of an action of 1 in breakaway torques, as the environment's keyword argument."""

    def agent(self, robot: RobotDescription, layout: ObservationLayout) -> Agent:
        """Return the agent.

        Args:
            robot: what the controller of the machine knows of it.
            layout: of the observations.
        """
