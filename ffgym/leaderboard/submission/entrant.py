"""A submission beside the other agents of the leaderboard: its agent decides in a process of its own."""

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from weakref import finalize

from ffgym.control import Agent, ObservationLayout
from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.leaderboard.entrants import Entrant, Ready, one_by_one
from ffgym.leaderboard.plants import TestPlant
from ffgym.leaderboard.submission.archive import decode_archive, read_archive, sha256_of
from ffgym.leaderboard.submission.checks import check_files
from ffgym.leaderboard.submission.manifest import MANIFEST, Manifest, decode_manifest
from ffgym.leaderboard.submission.plan import controller_of
from ffgym.leaderboard.submission.process import AgentProcess
from ffgym.leaderboard.submission.refusal import Refused
from ffgym.leaderboard.tasks import Task
from ffgym.robot import RobotDescription

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}")
"""Of a row, as its result file is named after it."""


def entrant_of(path: Path, loaders: Mapping[str, str]) -> Entrant:
    """Entrant of a submission; what it claims is left to `ffgym verify`.

    Args:
        path: file of `ffgym submit`.
        loaders: modules that load agents, by kind.

    Raises:
        FFGymError: if it cannot be read, is damaged, or has a name that no file may have.
    """
    try:
        data = read_archive(path)
        files = decode_archive(data)
        if MANIFEST not in files:
            raise Refused("archive", f"it has no {MANIFEST}.")
        manifest = decode_manifest(files[MANIFEST])
        check_files(manifest, files)
    except Refused as refusal:
        raise FFGymError(f"{path}: {refusal}") from refusal
    if not _NAME.fullmatch(manifest.name):
        raise FFGymError(
            f"{path}: the name {manifest.name!r} must be letters, digits, _ and -, at most 64, as its result file is "
            f"named after it. Submit it with another --name."
        )
    known = sha256_of(data)
    content = None if manifest.agent.file is None else files[manifest.agent.file]

    def ready(plant: TestPlant, seed: int, tasks: Sequence[Task]) -> Ready:
        policy = _Submitted(manifest=manifest, content=content, loaders=loaders, controller=controller_of(plant.name))
        return Ready(policy=policy, artefact=known, robot_seconds=manifest.robot_seconds, env_steps=manifest.env_steps)

    return Entrant(
        name=manifest.name,
        title=manifest.title,
        track=manifest.track,
        about=f"Submitted by {manifest.author}; what it learned from is what its author says.",
        artefact=lambda plant, seed: known,
        ready=one_by_one(ready),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Submitted:
    """Policy whose agents live elsewhere."""

    manifest: Manifest
    content: bytes | None = field(repr=False)
    loaders: Mapping[str, str]
    controller: str
    """Name of the description that the controller knows."""

    @property
    def preview(self) -> int:
        """See `ffgym.control.Policy`."""
        return self.manifest.preview

    @property
    def action_scale(self) -> float:
        """See `ffgym.control.Policy`."""
        return self.manifest.action_scale

    def agent(self, robot: RobotDescription, layout: ObservationLayout) -> Agent:
        """See `ffgym.control.Policy`; it begins a process."""
        source, seed = self.manifest.agent, self.manifest.seed
        process = AgentProcess(source, self.content, self.controller, loaders=self.loaders, seed=seed)
        return _Asked(self.manifest.name, process)


class _Asked:
    """An agent in another process, which ends when nobody can ask it any more."""

    def __init__(self, name: str, process: AgentProcess) -> None:
        self._name = name
        with self._named():
            self._process = process.__enter__()
        finalize(self, process.close)

    @contextmanager
    def _named(self) -> Iterator[None]:
        try:
            yield
        except Refused as refusal:
            raise FFGymError(f"The submission {self._name!r} was ended: {refusal}") from refusal

    def predict(
        self, observation: Array, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[Array, Any]:
        """See `ffgym.control.Agent`."""
        with self._named():
            return self._process.predict(observation, state, episode_start, deterministic)
