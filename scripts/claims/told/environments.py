"""What pages of docs/environments tell of defaults of the code."""

from collections.abc import Iterator
from inspect import signature
from typing import Any

import gymnasium as gym

from ffgym.envs.adapt import AdaptTasks
from ffgym.envs.circle_path import CircleTasks
from ffgym.envs.joint_motion import RandomTasks
from ffgym.envs.one_axis import SineTasks
from ffgym.envs.rewards import AbsolutePathError, LogRMSError, RelativePathError
from ffgym.paths.excitations import FREQUENCIES
from scripts.claims.claim import claim

CODE = "the code itself"


def default(tasks: type, name: str) -> Any:
    """Find the default of an argument of tasks."""
    return signature(tasks).parameters[name].default


def listed(values: Any, digits: int | None = None) -> str:
    """Write numbers as pages list them."""
    return ", ".join(f"{value:g}" if digits is None else f"{value:.{digits}f}" for value in values)


@claim(CODE)
def episodes_of_environments() -> Iterator[str]:
    """Motions of the environments."""
    small, middle, large = (f"{1e3 * radius:g}" for radius in default(CircleTasks, "radii"))
    slow, usual, fast = (f"{1e3 * speed:g}" for speed in default(CircleTasks, "speeds"))
    yield f"circles of {small}, {middle}, {large} mm at {slow}, {usual} or {fast} mm/s at one of four positions"
    low, high = default(SineTasks, "frequencies")
    yield f"a sine of {low:g} or {high:g} Hz for {default(SineTasks, 'duration'):g} s"
    yield f"a random smooth motion of all joints for {default(RandomTasks, 'duration'):g} s"


@claim(CODE)
def scales_of_rewards() -> Iterator[str]:
    """Lengths that path errors are compared with."""
    yield f"distance of the TCP from its path / {1e3 * AbsolutePathError().scale:g} mm"
    yield f"distance of the TCP from its path / {1e6 * RelativePathError().scale:g} µm"
    yield f"RMS path error of the circle / {1e6 * LogRMSError().scale:g} µm"


@claim(CODE)
def defaults_of_second_versions() -> Iterator[str]:
    """Keywords of ids that end in v1."""
    circle, axis, joints = (gym.spec(f"ffgym/{name}-v1") for name in ("CirclePath", "OneAxis", "JointMotion"))
    yield f"| `bound` | {circle.kwargs['bound']:g} |"
    yield f"| `features`, `preview` | {circle.kwargs['features']}, {circle.kwargs['preview']} |"
    assert axis.max_episode_steps == joints.max_episode_steps
    yield (f"| `horizon` | {circle.max_episode_steps} ({axis.max_episode_steps} on one axis and for joint motions) |")


@claim(CODE)
def defaults_of_adapt() -> Iterator[str]:
    """Keywords of `ffgym/Adapt-v0`."""
    yield f"| `budget` | {default(AdaptTasks, 'budget'):.1f} |"
    for name in ("practice_speed", "practice_radius", "scored"):
        yield f"| `{name}` | {default(AdaptTasks, name):g} |"
    for name in ("speeds", "radii"):
        yield f"| `{name}` | ({listed(default(AdaptTasks, name))}) |"


@claim(CODE)
def defaults_of_circle_path() -> Iterator[str]:
    """Keywords of `ffgym/CirclePath-v0`."""
    for name in ("speeds", "radii"):
        yield f"| `{name}` | ({listed(default(CircleTasks, name), 3)}) |"


@claim(CODE)
def defaults_of_one_axis() -> Iterator[str]:
    """Keywords of `ffgym/OneAxis-v0`."""
    yield f"| `frequencies` | ({listed(default(SineTasks, 'frequencies'), 1)}) |"
    for name in ("amplitude", "duration"):
        yield f"| `{name}` | {default(SineTasks, name):.1f} |"


@claim(CODE)
def defaults_of_joint_motion() -> Iterator[str]:
    """Keywords of `ffgym/JointMotion-v0`, and its frequencies."""
    low, high = FREQUENCIES
    yield f"a sum of sines of random frequency ({low:g} to {high:g} Hz) and phase"
    yield f"| `peak_speeds` | ({listed(default(RandomTasks, 'peak_speeds'), 1)}) |"
    for name in ("duration", "spread"):
        yield f"| `{name}` | {default(RandomTasks, name):.1f} |"
