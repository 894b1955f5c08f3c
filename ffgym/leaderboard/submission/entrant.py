"""A submission beside the other agents of the leaderboard: its agent decides in a process of its own."""

import re
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

from ffgym.control import Policy, SetpointChannel
from ffgym.core.errors import FFGymError
from ffgym.leaderboard.entrants import Entrant, ReadyAgent, one_by_one
from ffgym.leaderboard.plants import TestPlant
from ffgym.leaderboard.submission.judge import controller_of, make_view
from ffgym.leaderboard.submission.manifest import Manifest, Refused, decode_submission, read_archive, sha256_of
from ffgym.leaderboard.submission.process import AgentProcess
from ffgym.leaderboard.submission.python_agent import View
from ffgym.leaderboard.tasks import Task

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}")
"""Pattern of a row's name, as its result file is named after it."""


def make_entrant(path: Path, loaders: Mapping[str, str]) -> Entrant:
    """Make the entrant of a file of `ffgym leaderboard submit`; its claims are checked by `ffgym leaderboard verify`.

    It is shown and not ranked, as torques of public plants and circles can be stored; its rank is that of a
    verification, on what is drawn then.

    FFGymError if it cannot be read, is damaged, or has a name that no file may have.
    """
    manifest, content, known = _read(path)
    # the name becomes that of a file, so that it must not lead elsewhere
    if not _NAME.fullmatch(manifest.name):
        raise FFGymError(
            f"{path}: the name {manifest.name!r} must be letters, digits, _ and -, at most 64, as its result file is "
            f"named after it. Submit it with another --name."
        )

    # one process for each plant and seed
    def ready(plant: TestPlant, seed: int, tasks: Sequence[Task]) -> ReadyAgent:
        policy = _make_policy(manifest, content, controller_of(plant.name), loaders)
        # robot time is what is counted here, and no motion is practised before it is scored
        return ReadyAgent(policy=policy, artefact=known, robot_seconds=0.0, env_steps=manifest.env_steps)

    return Entrant(
        name=manifest.name,
        title=manifest.title,
        track=manifest.track,
        feedback=manifest.sees_errors,
        channel=SetpointChannel() if manifest.channel == "setpoint" else None,
        about=f"Submitted by {manifest.author}, who claims {manifest.robot_seconds:g} s of robot time in training; "
        "not ranked, as torques of public circles can be stored: its rank is that of ffgym leaderboard verify.",
        ranked=False,
        artefact=lambda plant, seed: known,
        ready=one_by_one(ready),
    )


def load_submission(path: Path, robot: str, loaders: Mapping[str, str]) -> tuple[str, Policy]:
    """Return the title of a submission, and a policy that decides in a process of its own for each environment.

    Args:
        path: file of `ffgym leaderboard submit`.
        robot: name of the nominal description of the controller.
        loaders: modules that load agents, by kind.

    Raises:
        FFGymError: if it cannot be read, or is damaged.
    """
    manifest, content, _ = _read(path)
    return manifest.title, _make_policy(manifest, content, robot, loaders)


def _read(path: Path) -> tuple[Manifest, bytes | None, str]:
    """Read a submission: manifest, content of the agent's file, and sha256 of the whole."""
    try:
        data = read_archive(path)
        manifest, files = decode_submission(data)
    except Refused as refusal:
        raise FFGymError(f"{path}: {refusal}") from refusal
    return manifest, None if manifest.agent.file is None else files[manifest.agent.file], sha256_of(data)


def _make_policy(manifest: Manifest, content: bytes | None, robot: str, loaders: Mapping[str, str]) -> View:
    """Make the policy of a submission; each of its agents runs in a process of its own."""
    start = partial(
        AgentProcess,
        manifest.agent,
        content,
        robot,
        loaders=loaders,
        seed=manifest.seed,
        feedback=manifest.sees_errors,
        channel=manifest.channel,
        whose=f"The submission {manifest.name!r} was ended: ",
    )
    return make_view(manifest, lambda robot, layout: start())
