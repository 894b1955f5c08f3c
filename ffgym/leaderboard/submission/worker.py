"""Process that holds an agent of a submission: it gets a nominal description and observations, and decides.

`AgentProcess` starts it, and sends the observations.
"""

import os
import random
import re
import sys
import threading
import time
import traceback
from collections.abc import Iterator, Mapping
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import IO, Any

import numpy as np

from ffgym.control import Agent, ObservationLayout
from ffgym.control.observation import size_actions
from ffgym.core.errors import FFGymError, check_number, check_whole
from ffgym.core.types import Array
from ffgym.leaderboard.submission.process import receive, send
from ffgym.robot import RobotDescription, load_robot

_GRACE_S = 5
"""Processor time between the signal of the reached limit and the end without a signal [s]."""


def main() -> None:
    """Serve until the other side sends no more."""
    threading.Thread(target=_end_with, args=(os.getppid(),), daemon=True).start()
    reads, writes = os.dup(0), os.dup(1)  # under other numbers, so that what an agent prints does not get into them
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    os.dup2(2, 1)
    with suppress(StopIteration, BrokenPipeError), open(reads, "rb") as asked, open(writes, "wb") as told:
        messages = _messages(asked)
        order, _ = next(messages)
        try:
            _serve(order, messages, told)
        except BaseException as error:  # whatever the agent raises, SystemExit included
            send(told, {"refused": failure_text(error, Path(order["folder"]))})


def _end_with(parent: int) -> None:
    """End when the parent process has ended, however it did: an agent that loops would not notice."""
    while os.getppid() == parent:
        time.sleep(0.5)
    os._exit(1)


def _messages(asked: IO[bytes]) -> Iterator[tuple[dict[str, Any], bytes]]:
    with suppress(EOFError):
        while True:
            yield receive(asked)


def _serve(order: Mapping[str, Any], messages: Iterator[tuple[dict[str, Any], bytes]], told: IO[bytes]) -> None:
    """Make the agent, send the arguments of its environment, and answer observations with actions."""
    clock = time.perf_counter  # which the agent's code does not replace
    _limit(**order["limits"])
    robot = load_robot(order["robot"])
    _seed(order["seed"], Path(order["folder"]))
    policy = import_module(order["loader"]).load(order["source"], Path(order["folder"]), robot)
    preview = check_whole("PREVIEW", policy.preview, unit="samples", low=0, high=1000)
    scale = check_number("ACTION_SCALE", policy.action_scale, unit="breakaway torques", low=0.0, open_low=True)
    channel, feedback = order["channel"], order["feedback"]
    size = size_actions(robot, scale, channel)
    layout = ObservationLayout(robot, preview, size, channel=channel, sees_errors=feedback)
    agent: Agent = policy.agent(robot, layout)
    send(told, {"preview": preview, "action_scale": scale})
    # observations in, actions out
    state: Any = None
    for message, numbers in messages:
        rows, columns = message["shape"]
        observation = np.frombuffer(numbers, dtype="<f8").reshape(rows, columns).astype(np.float64)
        began = clock()
        answer = agent.predict(observation, None if message["first"] else state, np.array(message["starts"]), True)
        elapsed = {"elapsed_us": (clock() - began) * 1e6}
        if not isinstance(answer, tuple) or len(answer) != 2:
            raise FFGymError("predict must return actions and state, a pair.")
        action, state = answer
        send(told, elapsed, _check_actions(action, rows, robot).astype("<f4").tobytes())


def _seed(seed: int, folder: Path) -> None:
    """Seed the random numbers of Python, of numpy, and of torch if a file in the agent's folder uses it."""
    random.seed(seed)
    np.random.seed(seed % 2**32)  # noqa: NPY002 - agents may use the old way
    if any(re.search(rb"torch|stable_baselines3|sb3_contrib", file.read_bytes()) for file in folder.glob("*.py")):
        import_module("torch").manual_seed(seed)


def _check_actions(action: Any, rows: int, robot: RobotDescription) -> Array:
    """Check actions (B, N), clip them to [-1, 1]; FFGymError if they are no finite numbers of the right shape."""
    numbers, shape = np.asarray(action), (rows, robot.n_joints)
    if numbers.dtype.kind not in "fiu":
        raise FFGymError(f"predict returned actions of type {numbers.dtype}, must be numbers.")
    if numbers.shape != shape:
        raise FFGymError(f"predict returned actions of shape {numbers.shape}, must be {shape}.")
    if not np.all(np.isfinite(numbers)):
        raise FFGymError("predict returned NaN or infinity.")
    return np.clip(numbers, -1.0, 1.0)


def failure_text(error: BaseException, folder: Path) -> str:
    """Return the reason of a refusal for an error; with file and line if it was raised from a file in `folder`."""
    text = " ".join(str(error).split())[:400]
    reason = text if isinstance(error, FFGymError) else f"it raised {type(error).__name__}: {text}"
    frames = [(Path(frame.f_code.co_filename), line) for frame, line in traceback.walk_tb(error.__traceback__)]
    lines = [f" ({file.name}, line {line})" for file, line in frames if file.parent == folder]
    return reason + "".join(lines[-1:])


def _limit(memory_bytes: int, cpu_seconds: int, **_others: float) -> None:
    """Bound memory, time, and the size of files, where the system can."""
    if sys.platform == "win32":
        return
    import resource

    limits = {resource.RLIMIT_AS: memory_bytes, resource.RLIMIT_FSIZE: 2**26, resource.RLIMIT_CORE: 0}
    for which, wanted in (limits | {resource.RLIMIT_CPU: cpu_seconds}).items():
        _, hard = resource.getrlimit(which)
        soft, grace = wanted, _GRACE_S if which == resource.RLIMIT_CPU else 0
        if hard != resource.RLIM_INFINITY:
            soft, grace = min(wanted, hard), min(grace, hard - min(wanted, hard))
        with suppress(ValueError, OSError):  # a system that knows the limit and cannot set it
            resource.setrlimit(which, (soft, soft + grace))


if __name__ == "__main__":
    main()
