"""Runs of a submission: what is claimed of them, the actions in them, and what agents saw."""

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import Any

import numpy as np

from ffgym.control import Agent, ObservationLayout
from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.leaderboard.evaluation.closed_loop import Flight, fly
from ffgym.leaderboard.evaluation.scoring import cells_of
from ffgym.leaderboard.plants import plant_named
from ffgym.leaderboard.submission.manifest import Claim
from ffgym.leaderboard.submission.refusal import Refused
from ffgym.leaderboard.tasks import Task
from ffgym.robot import RobotDescription
from ffgym.simulation.run import Progress

Stage = Callable[[str, str], AbstractContextManager[Progress | None]]
"""Context of a piece of work by its title and unit, which shows how far it is."""

WATCHED = 1000
"""Decisions of each motion that are made once more for one robot alone; chosen: a fast motion whole, and four seconds
of slower ones, which takes some seconds for all motions of a plant."""


def silent(title: str, unit: str) -> AbstractContextManager[None]:
    """Stage that shows nothing."""
    return nullcontext()


@dataclass(frozen=True)
class Contract:
    """What an agent asks of an environment."""

    preview: int
    action_scale: float

    def agent(self, robot: RobotDescription, layout: ObservationLayout) -> Agent:
        """See `ffgym.control.Policy`; who decides is told beside it."""
        raise FFGymError("A submission's agent lives in another process; give `fly` the agents.")


class Watched:
    """An agent, and the first observations that it decided on."""

    def __init__(self, agent: Agent) -> None:
        self._agent = agent
        self.seen: list[Array] = []
        """Of all motions, shape (B, D), by step."""

    def predict(
        self, observation: Array, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[Array, Any]:
        """See `ffgym.control.Agent`."""
        if len(self.seen) < WATCHED:
            self.seen.append(observation.copy())
        answer: tuple[Array, Any] = self._agent.predict(observation, state, episode_start, deterministic)
        return answer


class Replay:
    """Logged actions as an agent; nothing is added where a log has ended.

    Args:
        actions: of each robot, shape (T, N) each.
    """

    def __init__(self, actions: Sequence[Array]) -> None:
        self._rows = np.zeros((max(len(each) for each in actions) + 1, len(actions), actions[0].shape[1]))
        for i, each in enumerate(actions):
            self._rows[: len(each), i] = each

    def predict(
        self, observation: Array, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[Array, Any]:
        """See `ffgym.control.Agent`; the state counts decisions."""
        k = 0 if state is None else int(state)
        return self._rows[min(k, len(self._rows) - 1)], k + 1


def run(
    plant: str,
    tasks: Sequence[Task],
    contract: Contract,
    agent: Any,
    *,
    seed: int,
    n_threads: int,
    stage: Stage,
    title: str,
) -> list[Flight]:
    """Flights of an agent on a plant, one per task."""
    with stage(f"{title}, {plant}", "s") as progress:
        (flights,) = fly(
            plant_named(plant), [contract], tasks, agents=[agent], seeds=[seed], n_threads=n_threads, progress=progress
        )
    return flights


def claims_of(plant: str, tasks: Sequence[Task], flights: Sequence[Flight], check: str) -> list[Claim]:
    """Claims that flights support.

    Raises:
        Refused: if the robot stopped before the end of a motion.
    """
    claims: list[Claim] = []
    for task, flight in zip(tasks, flights, strict=True):
        if flight.recording is None:
            raise Refused(
                check,
                f"the robot stopped on {plant} after {len(flight.actions)} steps at {task.position}, "
                f"{task.speed * 1e3:g} mm/s: a motor was too far from its reference.",
            )
        claims += [Claim.of(plant, cell) for cell in cells_of(task, flight.recording)]
    return claims
