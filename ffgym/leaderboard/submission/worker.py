"""The process that holds an agent of others: it is told what a controller knows, sees observations, and decides.

It is started by `ffgym.leaderboard.submission.launch`, and speaks `ffgym.leaderboard.submission.protocol`.
"""

import json
import os
import random
import sys
import threading
import time
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from ffgym.control import Agent, ObservationLayout
from ffgym.core.errors import FFGymError, check_number, check_whole
from ffgym.core.types import Array, BoolArray
from ffgym.leaderboard.submission import guard
from ffgym.leaderboard.submission.failure import failure_text
from ffgym.leaderboard.submission.judge import HIDDEN
from ffgym.leaderboard.submission.launch import PACKAGE
from ffgym.leaderboard.submission.protocol import (
    ACTIONS,
    JSON,
    OBSERVATIONS,
    REFUSED,
    Channel,
    Closed,
    pack_actions,
    unpack_observations,
)
from ffgym.robot import RobotDescription, load_robot

_LOOKS_EVERY = 0.5
"""[s]."""
_GRACE_S = 5
"""Processor time between the signal that tells which limit was reached and the end without one [s]."""


def main() -> None:
    """Serve until the other side has no more to ask."""
    channel = _own_channel()
    _end_with(os.getppid())

    def refuse(tried: str) -> None:
        channel.send_json({"reason": f"it tried to {tried}."}, REFUSED)

    try:
        _, payload = channel.receive()
        order = json.loads(payload)
        try:
            _serve(channel, _begin(channel, order, refuse))
        except Closed:
            raise
        except BaseException as error:  # whatever the agent raises, SystemExit included
            channel.send_json({"reason": failure_text(error, Path(order["folder"]))}, REFUSED)
    except Closed:
        return


def _end_with(parent: int) -> None:
    """End when the process that asks has ended, however it did: an agent that loops would not notice."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(_LOOKS_EVERY)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def _own_channel() -> Channel:
    """The pipes under other numbers, so that what an agent prints or reads does not get into them."""
    reads, writes = os.dup(0), os.dup(1)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.dup2(2, 1)
    return Channel(reads, writes)


def _begin(channel: Channel, order: Mapping[str, Any], refuse: Callable[[str], None]) -> "_Decider":
    """Make the agent, and tell what it asks of an environment."""
    folder, stopwatch = Path(order["folder"]), _stopwatch()
    _check_package(order["package"])
    _limit(order["memory_bytes"], order["cpu_seconds"])
    loader = import_module(order["loader"])
    robot = load_robot(order["robot"])
    if hasattr(loader, "prepare"):
        loader.prepare(order["source"], folder)
    random.seed(order["seed"])
    np.random.seed(order["seed"] % 2**32)  # noqa: NPY002 - agents may use the old way
    if "torch" in sys.modules:
        sys.modules["torch"].manual_seed(order["seed"])
    guard.install(refuse, folder, getattr(loader, "HIDDEN", HIDDEN))
    policy = loader.load(order["source"], folder, robot)
    preview = check_whole("PREVIEW", policy.preview, unit="samples", low=0, high=1000)
    scale = check_number("ACTION_SCALE", policy.action_scale, unit="breakaway torques", low=0.0, open_low=True)
    layout = ObservationLayout(robot, preview, scale * robot.friction.static)
    decider = _Decider(policy.agent(robot, layout), robot, stopwatch)
    channel.send_json({"preview": preview, "action_scale": scale})
    return decider


def _check_package(asked: str) -> None:
    """Check that this is the package that asks: another version decides otherwise.

    Raises:
        FFGymError: if it is not.
    """
    if str(PACKAGE) != asked:
        raise FFGymError(f"The agent's process found ffgym in {PACKAGE}, it must be the one in {asked}.")


def _stopwatch() -> Callable[..., tuple[Any, int]]:
    """Function that calls another and says how long it took [ns], by a clock that later code does not replace."""
    clock = time.perf_counter_ns

    def timed(call: Callable[..., Any], *arguments: Any) -> tuple[Any, int]:
        began = clock()
        answer = call(*arguments)
        return answer, clock() - began

    return timed


class _Decider:
    """An agent, and its state."""

    def __init__(self, agent: Agent, robot: RobotDescription, stopwatch: Callable[..., tuple[Any, int]]) -> None:
        self._agent, self._n, self._timed = agent, robot.n_joints, stopwatch
        self._state: Any = None

    def __call__(self, observation: Array, starts: BoolArray, first: bool) -> tuple[Array, int]:
        """Actions (B, N), and the time that they took [ns].

        Raises:
            FFGymError: if they are no finite numbers of the right shape.
        """
        state = None if first else self._state
        answer, elapsed = self._timed(self._agent.predict, observation, state, starts, True)
        if not isinstance(answer, tuple) or len(answer) != 2:
            raise FFGymError("predict must return actions and state, a pair.")
        action, self._state = answer
        return self._checked(action, len(observation)), elapsed

    def _checked(self, action: Any, rows: int) -> Array:
        numbers = np.asarray(action)
        if numbers.dtype.kind not in "fiu":
            raise FFGymError(f"predict returned actions of type {numbers.dtype}, must be numbers.")
        if numbers.shape != (rows, self._n):
            raise FFGymError(f"predict returned actions of shape {numbers.shape}, must be {(rows, self._n)}.")
        if not np.all(np.isfinite(numbers)):
            raise FFGymError("predict returned NaN or infinity.")
        return np.clip(numbers, -1.0, 1.0)


def _serve(channel: Channel, decide: _Decider) -> None:
    while True:
        kind, payload = channel.receive()
        if kind == OBSERVATIONS:
            channel.send(ACTIONS, pack_actions(*decide(*unpack_observations(payload))))
        elif kind == JSON:  # the only further order is to end
            return


def _limit(memory_bytes: int, cpu_seconds: int) -> None:
    """Bound memory, time, and the size of files, where the system can."""
    try:
        import resource
    except ImportError:  # Windows
        return
    limits = {
        resource.RLIMIT_AS: (memory_bytes, memory_bytes),
        resource.RLIMIT_CPU: (cpu_seconds, cpu_seconds + _GRACE_S),
        resource.RLIMIT_FSIZE: (2**26, 2**26),
        resource.RLIMIT_CORE: (0, 0),
    }
    for which, wanted in limits.items():
        _, hard = resource.getrlimit(which)
        soft, last = (each if hard == resource.RLIM_INFINITY else min(each, hard) for each in wanted)
        try:
            resource.setrlimit(which, (soft, last))
        except (ValueError, OSError):  # a system that knows the limit and cannot set it
            continue
