"""What an agent decides for one robot alone: what it decided beside others, and in time."""

from collections.abc import Callable, Sequence

import numpy as np

from ffgym.core.types import Array
from ffgym.leaderboard.submission.checks import check_first_actions
from ffgym.leaderboard.submission.process import AgentProcess
from ffgym.leaderboard.submission.refusal import Refused
from ffgym.leaderboard.submission.runs import Contract


def check_alone(
    start: Callable[[], AgentProcess],
    contract: Contract,
    control_dt: float,
    logged: Sequence[Array],
    seen: Sequence[Array],
    plant: str,
) -> float:
    """Check what an agent decides for each motion of a plant in a process that sees no other; returns the time [us].

    Args:
        start: makes a process of the agent.
        contract: what it must ask of an environment.
        control_dt: time that it has for a decision [s].
        logged: actions of each motion, shape (T, N) each.
        seen: observations of all motions (B, D), of the first steps.
        plant: name.

    Returns:
        Median time of one decision.

    Raises:
        Refused: if it asks for another environment, is too slow, or decides otherwise than beside the others.
    """
    times: list[float] = []
    for k, actions in enumerate(logged):
        observations = [each[k] for each in seen[: len(actions)]]
        with start() as agent:
            _check_contract(agent, contract)
            found, each = _decide(agent, observations)
        _check_time(each, control_dt)
        check_first_actions(actions, found, f"{plant}, motion {k} alone")
        times += each
    return float(np.median(times))


def _decide(agent: AgentProcess, observations: Sequence[Array]) -> tuple[Array, list[float]]:
    """Actions (T, N), and the time of each [us], measured beside the agent."""
    state, actions, times = None, [], []
    for k, observation in enumerate(observations):
        action, state = agent.predict(observation[None], state, np.array([k == 0]))
        actions.append(action[0])
        times.append(agent.elapsed_ns / 1e3)
    return np.array(actions), times


def _check_contract(agent: AgentProcess, contract: Contract) -> None:
    found, wanted = (agent.preview, agent.action_scale), (contract.preview, contract.action_scale)
    if found != wanted:
        raise Refused("agent", f"it asks for preview and action scale {found}, and {wanted} is what it ran with.")


def _check_time(times: Sequence[float], control_dt: float) -> None:
    """A decision must fit into a control step; the first is left out of the mean, as it may load what is needed."""
    limit = control_dt * 1e6
    for which, time in {"median": np.median(times), "mean": np.mean(times[1:] or times)}.items():
        if time > limit:
            raise Refused(
                "time",
                f"one decision for one robot takes {time:.0f} us, must take at most {limit:.0f} us ({which} of "
                f"{len(times)}).",
            )
