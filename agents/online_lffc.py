"""Learning feed-forward control online: a B-spline network that adapts at every sample while it compensates.

Idea and source: thesis (3.13) and (3.15), which the thesis states and leaves out in practice (5.2.2), as its robot's
controller could not be changed. With u_p, the feedback without its integral part, in place of y_m - y:

    w_s(k + 1) = w_s(k) + rate u_p(k) mu_s(v(k)),       u_p = K_p e + K_v de

where v is the motor speed of the reference now, e and de the observed motor error and its rate. The torque returned is
that of the new weights at the speed of the next sample. Weights stay as they are at standstill (v = 0).

Run it (the weights are the agent's state, one set per sub-environment; they outlive episodes):

    agent = OnlineLFFC.for_env(ExtendedBSN.zero(1), env, load_robot("one_axis").servo)
    action, state = agent.predict(observation, state, episode_start)
    network = agent.network_of(state)

Logged: nothing; `network_of` returns the learned network as a law.

Departures from the source: none in the update; the rate is smaller than that of (5.5), since it is applied 250 times a
second and not once a motion.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ffgym.agents.bspline import BSplineNetwork
from ffgym.agents.law_agent import LawAgent
from ffgym.control import servo_torque
from ffgym.core.errors import FFGymError, check_number, check_shape
from ffgym.core.types import Array
from ffgym.robot import Servo

RATE = 0.1
"""Share of u_p that goes into the weights at each sample; chosen, see docs/agents/online_lffc.md."""


@dataclass(frozen=True, kw_only=True, eq=False)
class OnlineLFFC:
    """An agent that learns; it never changes, its learned weights are the state that `predict` returns."""

    agent: LawAgent
    """Agent with the first network."""
    servo: Servo
    """Gains of the drive."""
    rate: float = RATE
    """Share of u_p that goes into the weights at each sample."""

    def __post_init__(self) -> None:
        if not isinstance(self.agent.law, BSplineNetwork):
            raise FFGymError(f"{self.agent.law.name} is no B-spline network, so that it cannot learn online.")
        if len(self.servo.position_gain) != self.network.n_joints:
            raise FFGymError(
                f"A servo of {len(self.servo.position_gain)} motors does not fit a network for {self.network.n_joints}."
            )
        check_number("rate", self.rate, low=0.0, high=1.0, open_low=True)

    @classmethod
    def for_env(cls, network: BSplineNetwork, env: Any, servo: Servo, rate: float = RATE) -> "OnlineLFFC":
        """Return the agent for an environment of ffgym; see `LawAgent.for_env`."""
        return cls(agent=LawAgent.for_env(network, env), servo=servo, rate=rate)

    @property
    def network(self) -> BSplineNetwork:
        """Network that every sub-environment begins with."""
        network = self.agent.law
        assert isinstance(network, BSplineNetwork)
        return network

    def predict(
        self,
        observation: Array,
        state: Any = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> tuple[Array, Any]:
        """Compute actions (..., N) for observations (..., D), and the weights after this sample, shape (..., N H S).

        Args:
            observation: one observation, or a batch of them.
            state: weights that the last call returned, None at first.
            episode_start: without effect, weights outlive episodes.
            deterministic: without effect, nothing is random.
        """
        window = self.agent.window(observation)
        n, batch, first = self.network.n_joints, window.q.shape[:-2], self.network.coefficients
        if state is None:
            weights = np.tile(first.reshape(n, -1), (*batch, 1, 1))
        else:
            weights = check_shape("state", state, (*batch, first.size)).reshape(*batch, n, -1).copy()
        # update of the weights at the speed of this sample
        error, error_rate = (self.agent.layout.read(observation, name) for name in ("error", "error_rate"))
        u_p = servo_torque(self.servo, error, error_rate, np.zeros_like(error)).u_p
        dq, ddq, located = window.motor_dq, window.motor_ddq, self.network.locate(window.q)
        values, places = self.network.active(dq[..., 0, :], ddq[..., 0, :], located[..., 0, :])
        missing = np.where(dq[..., 0, :] == 0, 0.0, u_p)
        learned = np.take_along_axis(weights, places, axis=-1) + self.rate * missing[..., None] * values
        np.put_along_axis(weights, places, learned, axis=-1)
        # torque of the new weights at the speed of the next sample
        values, places = self.network.active(dq[..., 1, :], ddq[..., 1, :], located[..., 1, :])
        torque = (values * np.take_along_axis(weights, places, axis=-1)).sum(axis=-1)
        action = torque / self.agent.layout["added_torque"].scale
        return action, weights.reshape(*weights.shape[:-2], -1)

    def network_of(self, state: Array) -> BSplineNetwork:
        """Return the network that one sub-environment has learned; `state` is its row, shape (N H S,)."""
        return self.network.with_weights({"coefficients": state.reshape(self.network.coefficients.shape)})
