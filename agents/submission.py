"""Agents of this package as submissions: kinds of files and names, and the making of an agent from each."""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from ffgym.agents.catalogue import CATALOGUE, find_entry, make_law
from ffgym.agents.declaration import AgentSetting
from ffgym.agents.law_agent import LawPolicy, causal
from ffgym.agents.law_files import load_law, unpack
from ffgym.agents.residual.policy import KIND, load_policy
from ffgym.control import FeedForwardLaw, Policy
from ffgym.core.errors import FFGymError
from ffgym.core.files import read_bytes
from ffgym.leaderboard.submission.manifest import AgentSource
from ffgym.robot import RobotDescription

LOADERS: Mapping[str, str] = {
    "law": "ffgym.agents.submission",
    "policy": "ffgym.agents.submission",
    "python": "ffgym.leaderboard.submission.python_agent",
}
"""Module whose `load` makes an agent, by its kind."""


def resolve_agent(agent: str) -> tuple[AgentSource, bytes | None]:
    """Resolve an agent into the source of a submission, and the content of its file if it has one.

    Args:
        agent: name in the catalogue, model:machine.toml, or a path: .npz of a law or a residual policy, .py.

    Raises:
        FFGymError: if there is no such agent, it is trained anew each time it is made, or its file cannot be read.
    """
    if agent.endswith(".py"):
        return AgentSource(kind="python", file="agent.py"), read_bytes(agent)
    if agent.endswith(".npz"):
        kind = "policy" if unpack(agent)[0].get("kind") == KIND else "law"
        return AgentSource(kind=kind, file="agent.npz"), read_bytes(agent)
    name, colon, file = agent.partition(":")
    entry = find_entry(name)
    if name not in SUBMITTED:
        raise FFGymError(
            f"Agent {name!r} cannot be submitted by its name: it learns, or needs a whole motion at once. Submit "
            f"{', '.join(SUBMITTED)}, the file (.npz) of a trained agent, or a .py."
        )
    if not colon:
        return AgentSource(kind="law", law=name), None
    if not entry.takes_machine:
        raise FFGymError(f"Agent {name!r} takes no file, got {agent!r}.")
    return AgentSource(kind="law", law=name, file="agent.toml"), read_bytes(file)


def load(source: Mapping[str, Any], folder: Path, robot: RobotDescription) -> Policy:
    """Load a policy from a source and the folder with its file.

    Raises:
        FFGymError: if the file is damaged, or holds something else.
    """
    if source["kind"] == "policy":
        return load_policy(folder / str(source["file"]))
    file, name = source["file"], source["law"]
    if name is None:
        law = causal(load_law(folder / str(file)))
        return LawPolicy(make=lambda robot: law, preview=law.preview)
    if name not in SUBMITTED:
        raise FFGymError(f"law = {name!r} must be one of {', '.join(SUBMITTED)}.")
    full = name if file is None else f"{name}:{folder / str(file)}"
    preview = causal(make_law(full, AgentSetting.of(robot))).preview
    return LawPolicy(make=lambda robot: make_law(full, AgentSetting.of(robot)), preview=preview)


def rows_beside(names: Sequence[str], robot: RobotDescription) -> dict[str, Policy]:
    """Make the laws that a submission is compared with, by name; all see equally far ahead, and so run side by side.

    Raises:
        FFGymError: if a law is unknown, or is not made from the robot's description alone.
    """

    def make(name: str, robot: RobotDescription) -> FeedForwardLaw:
        return make_law(name, AgentSetting.of(robot))

    for name in names:
        if find_entry(name).name not in SUBMITTED:
            raise FFGymError(f"Agent {name!r} learns, or needs a whole motion at once; choose {', '.join(SUBMITTED)}.")
    preview = max(causal(make(name, robot)).preview for name in names)
    return {name: LawPolicy(make=partial(make, name), preview=preview) for name in names}


SUBMITTED = tuple(
    name
    for name, entry in CATALOGUE.items()
    if entry.track == "causal, nominal parameters" and entry.package is None and entry.load is not None
)
"""Names of laws that are made from the robot's description alone."""
