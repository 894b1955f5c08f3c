"""Packing and checking of submissions: an agent is run and its actions are logged; a check replays both.

An agent lives in a process of its own and sees observations only; the simulation, its truth and all errors are here.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, nullcontext
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from ffgym.control import Agent, ObservationLayout
from ffgym.core.errors import FFGymError
from ffgym.core.files import decode_arrays, encode_arrays
from ffgym.core.provenance import versions
from ffgym.core.types import Array
from ffgym.envs.machines import find_controller, is_workcell
from ffgym.leaderboard.evaluation.closed_loop import Rollout, run_rollouts
from ffgym.leaderboard.evaluation.jobs import score_circles
from ffgym.leaderboard.plants import NOMINAL, ROBOT, THESIS_WORKCELL, find_plant
from ffgym.leaderboard.submission import manifest as files_of
from ffgym.leaderboard.submission.manifest import (
    ACTIONS,
    MANIFEST,
    About,
    AgentSource,
    Claim,
    Manifest,
    Refused,
    join_names,
)
from ffgym.leaderboard.submission.process import AgentProcess, Limits
from ffgym.leaderboard.submission.python_agent import View
from ffgym.leaderboard.tasks import Task
from ffgym.paths import RADII
from ffgym.robot import RobotDescription, load_robot
from ffgym.simulation.run import Progress
from ffgym.studies import in_mm

_FAST, _MIDDLE, _SLOW = (Task("p2", speed, RADII, "positions") for speed in (0.1, 0.04, 0.01))
STANDARD: Mapping[str, tuple[Task, ...]] = {NOMINAL: (_FAST, _MIDDLE, _SLOW), THESIS_WORKCELL: (_FAST, _MIDDLE)}
"""Motions by plant, at a position held out from learning; slow circles on the workcell would take a minute."""
SCORE_TOLERANCE = 1e-4
"""Relative difference of errors that is allowed. On one machine they are the same bit for bit. Another processor rounds
in the sixteenth digit; noise in the seventh digit of every observation changes errors by 1e-8, which a test repeats.
Chosen: far above that, and far below the differences of agents."""
SCORE_FLOOR_MM = 1e-6
"""Difference of errors that is always allowed [mm], for the same reason."""
ACTION_TOLERANCE = 1e-3
"""Difference of actions that is allowed, in the largest logged one of that motor and task. The same noise changes them
by 3e-7; chosen as errors are, with room for agents of high gain."""
CHECKS: Mapping[str, str] = {
    "archive": "a readable ZIP file of a few plain files, small, with nothing outside of it",
    "manifest": "complete, and as it was written",
    "files": "each as it was packed, none missing, none more",
    "physics": "the plants here are those of the claims",
    "agent": "for one robot alone and for all, it decides what was logged",
    "replay": "the logged actions give the claimed errors in the simulation here",
    "time": "one decision for one robot fits into a control step, and all of a run keep up",
}
"""Checks, with a description of each."""


def controller_of(plant: str) -> str:
    """Return the name of the nominal description of a plant's controller, which agents have too."""
    return find_controller(plant) if is_workcell(plant) else ROBOT


def make_view(manifest: Manifest, make: Callable[[RobotDescription, ObservationLayout], Agent] | None = None) -> View:
    """Return the view of the agent of a submission, and what makes the agent if it is not passed in another way."""
    return View(
        preview=manifest.preview,
        action_scale=manifest.action_scale,
        feedback=manifest.sees_errors,
        channel=manifest.channel,
        make=make,
    )


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """An accepted submission, with the findings of its check."""

    data: bytes
    """The ZIP file."""
    manifest: Manifest
    claims: tuple[Claim, ...]
    """Errors of the replay here."""
    inference_us: float
    """Median time of one decision for one robot on the first plant, here [us]."""
    action_difference: float
    """Largest difference of actions, relative to the largest logged action of that motor and task."""


@dataclass(frozen=True, kw_only=True)
class Judge:
    """Judge that packs and checks submissions."""

    loaders: Mapping[str, str]
    """Modules that load agents, by kind."""
    plan: Mapping[str, Sequence[Task]] = field(default_factory=lambda: STANDARD)
    """Motions by plant."""
    limits: Limits | None = None
    """Limits of agents."""
    n_threads: int = 0
    """Threads of the simulation, 0 for all cores."""
    stage: Callable[[str, str], AbstractContextManager[Progress | None]] = lambda title, unit: nullcontext()
    """Context of a piece of work by its title and unit, which shows its progress."""

    def pack(self, about: About, source: AgentSource, content: bytes | None) -> Verdict:
        """Run an agent, made from a source and the content of its file, on every plant; pack and check the results.

        Raises:
            Refused: if the agent cannot be made, fails, or its submission would not be accepted.
        """
        actions: dict[str, Array] = {}
        claims: list[Claim] = []
        feedback = about.feedback and source.kind != "law"
        own = {} if source.file is None or content is None else {source.file: content}

        def pack_archive(view: View) -> bytes:
            files = {ACTIONS: encode_arrays(actions)} | own
            manifest = Manifest(
                **asdict(about) | {"feedback": feedback},
                agent=source,
                preview=view.preview,
                action_scale=view.action_scale,
                versions=versions(),
                plants={plant: find_plant(plant).fingerprint for plant in self.plan},
                files={name: files_of.sha256_of(data) for name, data in files.items()},
                claims=tuple(claims),
            )
            text = json.dumps(manifest.tree(), indent=1, allow_nan=False) + "\n"
            return files_of.encode_archive({MANIFEST: text.encode()} | files)

        files_of.decode_submission(pack_archive(View(preview=1, action_scale=1.0)))  # refuse now, not after minutes
        # run on every plant, and log errors and actions
        for plant in self.plan:
            with self.start_agent(source, content, plant, about) as agent:
                view = View(
                    preview=agent.preview,
                    action_scale=agent.action_scale,
                    feedback=feedback,
                    channel=about.channel,
                )
                rollouts = self._run_rollouts(plant, view, agent, about.seed, "running")
            claims += self._claims(plant, rollouts)
            actions |= {_key(plant, k): rollout.actions.astype("<f4") for k, rollout in enumerate(rollouts)}
        return self.verify(pack_archive(view))

    def verify(self, data: bytes) -> Verdict:
        """Check the bytes of a submission: replay its actions, while its agent decides once more.

        Raises:
            Refused: with the first check that it does not pass.
        """
        # contents, and physics of the claims
        manifest, files = files_of.decode_submission(data)
        check_physics(manifest, self.plan)
        source, seed, view = manifest.agent, manifest.seed, make_view(manifest)
        claims: list[Claim] = []
        replays: list[ActionReplay] = []
        for plant, logs in read_logged_actions(files[ACTIONS], self.plan).items():
            replays.append(replay := ActionReplay(logs, plant))
            # agents of each robot alone and of all together, beside the replay of the log
            every = tuple(range(len(logs)))
            with ExitStack() as stack:
                for robots in {*((k,) for k in every), every}:  # each alone, and all together
                    content = files.get(str(source.file))
                    agent = stack.enter_context(self.start_agent(source, content, plant, manifest))
                    if (agent.preview, agent.action_scale) != (view.preview, view.action_scale):
                        asks = f"preview and action scale {(agent.preview, agent.action_scale)}"
                        ran = (view.preview, view.action_scale)
                        raise Refused("agent", f"it asks for {asks}, and {ran} is what it ran with.")
                    replay.asked[robots] = agent
                rollouts = self._run_rollouts(plant, view, replay, seed, "replaying")
            claims += self._claims(plant, rollouts)
            # lengths, and times of decisions
            for logged, rollout in zip(logs, rollouts, strict=True):
                if len(logged) != len(rollout.actions):
                    steps = f"{len(logged)} steps of a motion that has {len(rollout.actions)}"
                    raise Refused("replay", f"{ACTIONS} has {steps}.")
            for times in replay.alone_us.values():
                check_time(times, load_robot(controller_of(plant)).servo.control_dt)
        # errors of the replay against those that the submission claims
        check_claims(manifest.claims, claims)
        return Verdict(
            data=data,
            manifest=manifest,
            claims=tuple(claims),
            inference_us=float(np.median([time for times in replays[0].alone_us.values() for time in times])),
            action_difference=max(replay.worst for replay in replays),
        )

    def start_agent(
        self, source: AgentSource, content: bytes | None, plant: str, about: About, whose: str = ""
    ) -> AgentProcess:
        """Start the process of an agent, made from a source and the content of its file, for the robot of a plant."""
        return AgentProcess(
            source,
            content,
            controller_of(plant),
            loaders=self.loaders,
            seed=about.seed,
            feedback=about.feedback and source.kind != "law",
            channel=about.channel,
            limits=self.limits,
            whose=whose,
        )

    def _run_rollouts(self, plant: str, view: View, agent: Agent, seed: int, title: str) -> list[Rollout]:
        tasks, machine = self.plan[plant], find_plant(plant)
        with self.stage(f"{title}, {plant}", "s") as shown:
            [rollouts] = run_rollouts(
                machine, [view], tasks, agents=[agent], seeds=[seed], n_threads=self.n_threads, progress=shown
            )
        return rollouts

    def _claims(self, plant: str, rollouts: Sequence[Rollout]) -> list[Claim]:
        claims: list[Claim] = []
        for task, rollout in zip(self.plan[plant], rollouts, strict=True):
            if rollout.recording is None:
                raise Refused(
                    "replay",
                    f"the robot stopped on {plant} after {len(rollout.actions)} steps at {task.position}, "
                    f"{task.speed * 1e3:g} mm/s: a motor was too far from its reference.",
                )
            names = ("position", "radius_mm", "speed_mm_s", "rms_mm", "max_mm")
            found = score_circles(task, rollout.recording)
            claims += [Claim(plant=plant, **{name: getattr(cell, name) for name in names}) for cell in found]
        return claims


class ActionReplay:
    """Logged actions (T, N) of each robot as an agent, compared with the decisions of agents on the same observations.

    No torque is added where a log has ended.
    """

    def __init__(self, logs: Sequence[Array], plant: str) -> None:
        self._rows = np.zeros((max(map(len, logs)) + 1, len(logs), logs[0].shape[1]))
        for i, each in enumerate(logs):
            self._rows[: len(each), i] = each
        self._lengths = np.array([len(each) for each in logs])
        self._largest = np.maximum(np.abs(self._rows).max(axis=0), np.finfo(np.float32).tiny)
        self._plant = plant
        self.asked: dict[tuple[int, ...], AgentProcess] = {}
        """Agents by the robots that each of them controls."""
        self.alone_us: dict[int, list[float]] = {i: [] for i in range(len(logs))}
        """Time of each decision for one robot alone [us]."""
        self.worst = 0.0
        """Largest difference from the log, relative to the largest action of each motor."""

    def predict(
        self, observation: Array, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[Array, Any]:
        """Return the logged actions; the state counts decisions. Refused if an agent fails, or decides otherwise."""
        step = 0 if state is None else int(state)
        for robots, agent in self.asked.items():
            rows = list(robots)
            if step < self._lengths[rows].max():
                action, _ = agent.predict(observation[rows], state, episode_start[rows])
                self._compare(step, rows, action)
                if len(rows) == 1:
                    self.alone_us[rows[0]].append(agent.elapsed_us)
        return self._rows[min(step, len(self._rows) - 1)], step + 1

    def _compare(self, step: int, rows: Sequence[int], action: Array) -> None:
        logged = self._rows[step, rows]
        difference = np.abs(action - logged) / self._largest[rows]
        difference[step >= self._lengths[rows]] = 0.0  # their motion has ended
        self.worst = max(self.worst, float(difference.max()))
        if difference.max() > ACTION_TOLERANCE:
            i, motor = map(int, np.unravel_index(difference.argmax(), difference.shape))
            raise Refused(
                "agent",
                f"on {self._plant}, motion {rows[i]}{' alone' if len(rows) == 1 else ''} it does not decide what was "
                f"logged: at step {step}, motor {motor + 1}, {action[i, motor]:.6g}, logged {logged[i, motor]:.6g}.",
            )


def _key(plant: str, task: int) -> str:
    """Return the name of the array with the actions of a motion."""
    return f"{plant.replace(':', '_')}_{task}"


def check_physics(manifest: Manifest, tasks: Mapping[str, Sequence[Task]]) -> None:
    """Check that claims are about the plants here, and about all circles of the plan; Refused if not."""
    if set(manifest.plants) != set(tasks):
        raise Refused("physics", f"it was run on {join_names(manifest.plants)}, must be run on {join_names(tasks)}.")
    for name in tasks:
        here, there = find_plant(name).fingerprint, manifest.plants[name]
        if here != there:
            known = ", ".join(f"{each} {manifest.versions.get(each, 'unknown')[:20]}" for each in ("ffgym", "mujoco"))
            raise Refused(
                "physics",
                f"{name} has fingerprint {here} here, and {there} in the manifest: it was packed with other physics "
                f"({known}). Pack it again with this version.",
            )
    motions = [(name, task) for name, each in tasks.items() for task in each]
    wanted = [(name, task.position, in_mm(r), in_mm(task.speed)) for name, task in motions for r in task.radii]
    if sorted(claim.circle for claim in manifest.claims) != sorted(wanted):
        claimed = len(manifest.claims)
        raise Refused("manifest", f"it claims {claimed} circles that are not the {len(wanted)} which are run.")


def read_logged_actions(data: bytes, tasks: Mapping[str, Sequence[Task]]) -> dict[str, list[Array]]:
    """Read actions by plant, one array (T, N) for each task; Refused if they are no finite numbers in [-1, 1]."""
    try:
        arrays = decode_arrays(data)
    except FFGymError as error:
        raise Refused("files", f"{ACTIONS}: {error}") from error
    wanted = {_key(plant, k): plant for plant, each in tasks.items() for k in range(len(each))}
    if set(arrays) != set(wanted):
        raise Refused("files", f"{ACTIONS} holds {join_names(arrays)}, must hold {join_names(wanted)}.")
    logs: dict[str, list[Array]] = {plant: [] for plant in tasks}
    for key, plant in wanted.items():
        array, n = arrays[key], load_robot(controller_of(plant)).n_joints
        if array.dtype != np.float32 or array.ndim != 2 or array.shape[1] != n or not len(array):
            shape = f"{array.dtype} of shape {array.shape}"
            raise Refused("files", f"{key} in {ACTIONS} is {shape}, must be float32 of shape (T, {n}).")
        if not np.all(np.abs(array) <= 1.0):
            raise Refused("files", f"{key} in {ACTIONS} holds NaN, or actions beyond -1 and 1.")
        logs[plant].append(array.astype(np.float64))
    return logs


def check_claims(claimed: Sequence[Claim], found: Sequence[Claim]) -> None:
    """Check that errors are the claimed ones; Refused if one is not."""
    here = {claim.circle: claim for claim in found}
    for claim in claimed:
        for name in ("rms_mm", "max_mm"):
            said, is_ = getattr(claim, name), getattr(here[claim.circle], name)
            if not abs(said - is_) <= max(SCORE_FLOOR_MM, SCORE_TOLERANCE * is_):  # of NaN too
                plant, position, radius, speed = claim.circle
                raise Refused(
                    "replay",
                    f"it claims {name} = {said:.6g} for r = {radius:g} mm at {speed:g} mm/s, {position}, on {plant}, "
                    f"and {is_:.6g} comes out.",
                )


def check_time(times_us: Sequence[float], control_dt: float) -> None:
    """Check that a decision fits into a control step [s]; the first may load libraries, and is not in the mean."""
    limit = control_dt * 1e6
    for which, time in {"median": np.median(times_us), "mean": np.mean(times_us[1:] or times_us)}.items():
        if time > limit:
            raise Refused(
                "time",
                f"one decision for one robot takes {time:.0f} us, must take at most {limit:.0f} us ({which} of "
                f"{len(times_us)}).",
            )
