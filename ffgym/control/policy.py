"""Protocols of agents, and of policies that make an agent for an environment."""

from typing import Any, Protocol, cast, runtime_checkable

from ffgym.control.observation import CHANNELS, Channel, ObservationLayout
from ffgym.core.errors import check_choice
from ffgym.core.types import Array
from ffgym.robot import RobotDescription


@runtime_checkable
class Agent(Protocol):
    """Agent with the `predict` of stable-baselines3."""

    def predict(
        self,
        observation: Array,
        state: Any = None,
        episode_start: Any = None,
        deterministic: bool = False,
    ) -> tuple[Array, Any]:
        """Return actions (B, N) for observations (B, D), and the state to pass in next time."""


@runtime_checkable
class Policy(Protocol):
    """Maker of an agent for an environment, from the knowledge of a controller alone."""

    @property
    def preview(self) -> int:
        """Number of samples of the reference that it must see ahead, as the environment's keyword argument."""

    @property
    def action_scale(self) -> float:
        """Size of an action of 1 in breakaway torques, as the environment's keyword argument."""

    def agent(self, robot: RobotDescription, layout: ObservationLayout) -> Agent:
        """Return the agent.

        Args:
            robot: the machine as its controller knows it.
            layout: layout of the observations.
        """


def sees_errors(policy: Policy) -> bool:
    """Check that a policy observes present errors of the motors; it does unless its attribute `feedback` is False."""
    return bool(getattr(policy, "feedback", True))


def find_channel(policy: Policy) -> Channel:
    """Return the channel that a policy acts through: its attribute `channel`, 'torque' if it has none.

    Raises:
        FFGymError: if there is no such channel.
    """
    return cast(Channel, check_choice("channel of a policy", getattr(policy, "channel", "torque"), CHANNELS))
