"""Whether a submission is what it says: its files, its physics, its actions, its agent."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from ffgym.control import Agent
from ffgym.core.types import Array
from ffgym.leaderboard.evaluation.closed_loop import Flight
from ffgym.leaderboard.submission import plan as plans
from ffgym.leaderboard.submission.alone import check_alone
from ffgym.leaderboard.submission.archive import decode_archive
from ffgym.leaderboard.submission.checks import (
    check_actions,
    check_claims,
    check_files,
    check_physics,
    logged_actions,
)
from ffgym.leaderboard.submission.limits import Limits
from ffgym.leaderboard.submission.manifest import ACTIONS, MANIFEST, Claim, Manifest, decode_manifest
from ffgym.leaderboard.submission.plan import Plan, controller_of
from ffgym.leaderboard.submission.process import AgentProcess
from ffgym.leaderboard.submission.refusal import Refused
from ffgym.leaderboard.submission.runs import (
    Contract,
    Replay,
    Stage,
    Watched,
    claims_of,
    run,
    silent,
)
from ffgym.leaderboard.tasks import Task
from ffgym.robot import load_robot

CHECKS: Mapping[str, str] = {
    "archive": "a readable ZIP file of a few plain files, small, with nothing outside of it",
    "manifest": "complete, and as it was written",
    "files": "each as it was packed, none missing, none more",
    "physics": "the plants here are those of the claims",
    "replay": "the logged actions give the claimed errors in the simulation here",
    "time": "one decision for one robot fits into a control step, and all of a run keep up",
    "agent": "for one robot alone and for all, it decides what was logged, and does nothing that it must not",
    "score": "the errors of that run are the claimed ones",
}
"""What is checked, in this order."""


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """What was found of a submission that is accepted."""

    manifest: Manifest
    claims: tuple[Claim, ...]
    """Errors of the run here."""
    inference_us: float
    """Median time of one decision for one robot, here [us]."""
    action_difference: float
    """Largest, in the largest logged action of that motor and task."""


@dataclass(frozen=True, kw_only=True)
class Verifier:
    """How submissions are checked."""

    loaders: Mapping[str, str]
    """Modules that load agents, by kind."""
    plan: Plan | None = None
    """What is run; None is the standard."""
    limits: Limits | None = None
    """What agents may use."""
    n_threads: int = 0
    """Of the simulation, 0 for all cores."""
    stage: Stage = silent
    """Shows how far the work is."""

    def verify(self, data: bytes) -> Verdict:
        """Check the bytes of a submission.

        Raises:
            Refused: with the first check that it does not pass.
        """
        files = decode_archive(data)
        if MANIFEST not in files:
            raise Refused("archive", f"it has no {MANIFEST}.")
        manifest = decode_manifest(files[MANIFEST])
        tasks = (self.plan or plans.STANDARD).tasks
        check_files(manifest, files)
        check_physics(manifest, tasks)
        actions = logged_actions(files[ACTIONS], tasks)
        seen = self._replay(manifest, tasks, actions)
        time_us = self._decide_alone(manifest, files, next(iter(tasks)), actions, seen)
        claims, difference = self._run_again(manifest, files, tasks, actions)
        return Verdict(manifest=manifest, claims=claims, inference_us=time_us, action_difference=difference)

    def _flights(
        self, manifest: Manifest, name: str, tasks: Sequence[Task], agent: Agent, title: str
    ) -> Sequence[Flight]:
        """What an agent does on the tasks of a plant, in the environment that the manifest asks for."""
        return run(
            name,
            tasks,
            Contract(manifest.preview, manifest.action_scale),
            agent,
            seed=manifest.seed,
            n_threads=self.n_threads,
            stage=self.stage,
            title=title,
        )

    def _replay(
        self, manifest: Manifest, tasks: Mapping[str, Sequence[Task]], actions: Mapping[str, list[Array]]
    ) -> list[Array]:
        """Check claims by logged actions; returns first observations of all motions of the first plant."""
        found: list[Claim] = []
        seen: list[Array] = []
        for name in tasks:
            watched = Watched(Replay(actions[name]))
            flights = self._flights(manifest, name, tasks[name], watched, "replaying")
            found += claims_of(name, tasks[name], flights, "replay")
            seen = seen or watched.seen
            for logged, flight in zip(actions[name], flights, strict=True):
                if len(logged) != len(flight.actions):
                    raise Refused(
                        "replay", f"{ACTIONS} has {len(logged)} steps of a motion that has {len(flight.actions)}."
                    )
        check_claims(manifest.claims, found, "replay")
        return seen

    def _process(self, manifest: Manifest, files: Mapping[str, bytes], plant: str) -> AgentProcess:
        agent = manifest.agent
        content = None if agent.file is None else files[agent.file]
        robot = controller_of(plant)
        return AgentProcess(agent, content, robot, loaders=self.loaders, seed=manifest.seed, limits=self.limits)

    def _decide_alone(
        self,
        manifest: Manifest,
        files: Mapping[str, bytes],
        plant: str,
        actions: Mapping[str, Sequence[Array]],
        seen: Sequence[Array],
    ) -> float:
        """Check what the agent decides for each robot alone; returns the time of a decision [us]."""
        return check_alone(
            partial(self._process, manifest, files, plant),
            Contract(manifest.preview, manifest.action_scale),
            load_robot(controller_of(plant)).servo.control_dt,
            actions[plant],
            seen,
            plant,
        )

    def _run_again(
        self,
        manifest: Manifest,
        files: Mapping[str, bytes],
        tasks: Mapping[str, Sequence[Task]],
        actions: Mapping[str, list[Array]],
    ) -> tuple[tuple[Claim, ...], float]:
        """Errors of the agent itself, and the largest difference of its actions from the logged ones."""
        found: list[Claim] = []
        largest = 0.0
        for name in tasks:
            with self._process(manifest, files, name) as agent:
                flights = self._flights(manifest, name, tasks[name], agent, "running the agent")
            for k, (logged, flight) in enumerate(zip(actions[name], flights, strict=True)):
                largest = max(largest, check_actions(logged, flight.actions, f"{name}, motion {k}"))
            found += claims_of(name, tasks[name], flights, "score")
        check_claims(manifest.claims, found, "score")
        return tuple(found), largest
