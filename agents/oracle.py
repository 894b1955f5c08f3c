"""Oracle: elastic feed-forward with the machine's true parameters, which no real controller has.

Idea: the same law as in `ffgym.agents.elastic`, made with the true masses, springs, rotors and friction of the machine,
where any other law has a nominal model. Its remaining error is the error of the law itself, without any error of the
model. It is shown beside the others and never ranked. Reading the truth is allowed here and nowhere else.

Run it:

    ffgym demo --agents lugre_dynamic elastic oracle --parameters FILE

Logged: nothing; the law learns nothing. Departures from `ffgym.agents.elastic`: the parameters alone.
"""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ffgym.agents.declaration import AgentEntry, declare
from ffgym.agents.elastic import ElasticLaw, elastic_law
from ffgym.agents.law_agent import LawAgent, acting_in, find_attribute
from ffgym.control import LawStyle, ObservationLayout
from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.robot import RigidArm, RobotDescription

if TYPE_CHECKING:
    from ffgym.envs.core import TrackingCore


def oracle_law(truth: RobotDescription | None, controller: RigidArm) -> ElasticLaw:
    """Make elastic feed-forward for a machine that is `truth`, whose existing controller was made for `controller`."""
    return elastic_law(RigidArm(known_truth(truth)), controller, name="oracle")


def known_truth(truth: RobotDescription | None) -> RobotDescription:
    """Return the true description of a machine.

    Raises:
        FFGymError: if it is shut away.
    """
    if truth is None:
        raise FFGymError("The oracle needs the truth, which is shut away on this machine; leave it out.")
    return truth


@dataclass(frozen=True, kw_only=True, eq=False)
class OracleAgent:
    """The oracle in an environment: at each step it looks up the simulated robots, also randomised ones."""

    core: "TrackingCore"
    """Engine of the environment."""
    layout: ObservationLayout
    """Layout of its observations."""
    control_dt: float
    """Time between samples [s]."""
    _agents: dict[int, tuple[RobotDescription, LawAgent]] = field(default_factory=dict, init=False, repr=False)
    """Agents by identity of the robot, for the robots of the present episodes."""

    @classmethod
    def for_env(cls, env: Any) -> "OracleAgent":
        """Return the oracle of an environment of ffgym: single, vector, or stable-baselines3's.

        Raises:
            FFGymError: if no law can act in it, see `LawAgent.for_env`.
        """
        layout, dt = acting_in(env)
        return cls(core=find_attribute(env, "core"), layout=layout, control_dt=dt)

    def predict(
        self, observation: Array, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[Array, Any]:
        """Act as `LawAgent.predict`; observations must be of all sub-environments, (B, D), or of the only one, (D,).

        Raises:
            FFGymError: if there are observations of fewer or more, one of the robots is not for this law, or the truth
                of one is shut away.
        """
        batch, n = np.atleast_2d(observation), self.core.n
        if len(batch) != n:
            raise FFGymError(f"The oracle needs the observations of all {n} sub-environments, {len(batch)} are given.")
        starts = np.zeros(n, dtype=np.bool_) if episode_start is None else np.atleast_1d(episode_start)
        action, memory = np.empty((n, self.layout.n_joints)), [np.empty(0)] * n
        for agent, rows in self._teams():
            known = None if state is None else np.atleast_2d(state)[rows]
            action[rows], remembered = agent.predict(batch[rows], known, starts[rows])
            for row, part in zip(rows, remembered, strict=True):
                memory[row] = part
        shape = np.shape(observation)[:-1]
        return action.reshape(*shape, -1), np.stack(memory).reshape(*shape, -1)

    def _teams(self) -> list[tuple[LawAgent, list[int]]]:
        """Return an agent for each distinct robot, and the sub-environments where it is simulated."""
        rows: dict[int, list[int]] = {}
        for i, machine in enumerate(self.core.plant.machines):
            robot = known_truth(machine.truth)
            rows.setdefault(id(robot), []).append(i)
            if id(robot) not in self._agents:
                law = oracle_law(robot, self.core.tasks.arm)
                agent = LawAgent(law=law, layout=self.layout, control_dt=self.control_dt)
                self._agents[id(robot)] = (robot, agent)
        for key in self._agents.keys() - rows.keys():
            del self._agents[key]
        return [(self._agents[key][1], chosen) for key, chosen in rows.items()]


declare(
    AgentEntry(
        name="oracle",
        title="elastic feed-forward with the true parameters",
        about="Elastic feed-forward with the machine's true parameters, which no controller knows. Not ranked.",
        track="oracle",
        order=100,
        page="oracle.md",
        style=LawStyle(label="oracle (true parameters)", colour="#A50F15", marker="H", line=":"),
        make=lambda setting: oracle_law(setting.truth, setting.controller or setting.arm),
        ranked=False,
    )
)
