"""A causal law as what `ffgym.control.Policy` describes, for the leaderboard and for submissions."""

from collections.abc import Callable
from dataclasses import dataclass

from ffgym.agents.common.law_agent import LawAgent
from ffgym.control import Agent, CausalLaw, FeedForwardLaw, ObservationLayout
from ffgym.core.errors import FFGymError
from ffgym.robot import RobotDescription

ACTION_SCALE = 200.0
"""Torque of an action of 1 for laws, in breakaway torques. Elastic feed-forward needs 102 on the fastest circles of the
nominal robot (`ffgym.envs.settings`); chosen: twice that, as identified machines may be softer."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LawPolicy:
    """A causal law as what `ffgym.control.Policy` describes."""

    make: Callable[[RobotDescription], FeedForwardLaw]
    preview: int
    action_scale: float = ACTION_SCALE

    def agent(self, robot: RobotDescription, layout: ObservationLayout) -> Agent:
        """See `ffgym.control.Policy`.

        Raises:
            FFGymError: if the law does not fit the robot.
        """
        return LawAgent(law=causal(self.make(robot)), layout=layout, control_dt=robot.servo.control_dt)


def causal(law: FeedForwardLaw) -> CausalLaw:
    """The law, if it runs sample by sample.

    Raises:
        FFGymError: if not.
    """
    if not isinstance(law, CausalLaw):
        raise FFGymError(f"Law {law.name!r} does not run sample by sample, so that it cannot act on observations.")
    return law
