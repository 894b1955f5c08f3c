"""Jobs: runs of agents on plants that any process can do, scored by circles and collected as outcomes."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np

from ffgym.core.provenance import versions
from ffgym.envs.machines import is_workcell
from ffgym.leaderboard.entrants import ReadyAgent, Registry, find_entrant
from ffgym.leaderboard.evaluation.closed_loop import inference_time, run_rollouts
from ffgym.leaderboard.evaluation.margins import measure_margins
from ffgym.leaderboard.motions import CIRCLE, TILTED
from ffgym.leaderboard.plants import DRAW, DRAWN_WORKCELL, TestPlant, drives_plant, find_plant
from ffgym.leaderboard.results import CircleResult, Margins, Outcome, Trail
from ffgym.leaderboard.tasks import Task, make_references, noise_seed
from ffgym.recordings import Recording
from ffgym.recordings.metrics import contour_errors, deviation_along, motor_error_rms
from ffgym.simulation import Run
from ffgym.studies import circle_scores, in_mm

PICTURED = ("p2", 0.003)
"""Position and radius [m] of the circles that pictures show: held out, of the thesis' middle size; chosen."""
_POINTS = 120
"""Points of a picture's circle: every 3 degrees."""

TOGETHER = 8
"""Agents of one job on one workcell, about. More side by side cost less each, as the effects of a workcell are computed
for all at once; chosen so that a dozen agents keep two cores busy."""
TOGETHER_ELSEWHERE = 4
"""The same on other plants, which come last: short jobs, so that all cores end together. Chosen: four jobs of a dozen
agents take less than 1 % more time than two."""

Wanted = tuple[str, int, str]
"""Name of an agent, its seed, name of a plant."""


@dataclass(frozen=True)
class Job:
    """Some agents, each with a seed, on one plant."""

    registry: Registry
    """Source of the entrants, see `find_entrants`."""
    plant: str
    agents: tuple[tuple[str, int], ...]
    """Names and seeds."""
    splits: tuple[str, ...]
    threads: int = 1
    """Threads of the engine."""


def jobs_for(registry: Registry, wanted: Sequence[Wanted], splits: Sequence[str]) -> list[Job]:
    """Divide agents, seeds and plants into jobs, by plant, the longest work first."""
    jobs = []
    order = sorted(wanted, key=lambda each: (not is_workcell(each[2]), each[2]))
    for plant, group in groupby(order, key=lambda each: each[2]):
        agents = [(name, seed) for name, seed, _ in group]
        n_jobs = -(-len(agents) // (TOGETHER if is_workcell(plant) else TOGETHER_ELSEWHERE))
        parts: list[list[tuple[str, int]]] = [[] for _ in range(n_jobs)]
        for _, row in groupby(agents, key=lambda agent: agent[0]):  # seeds of a row stay together
            min(parts, key=len).extend(row)
        jobs += [Job(registry, plant, tuple(part), tuple(splits)) for part in parts if part]
    return jobs


@dataclass(frozen=True, kw_only=True, eq=False)
class SeededAgent:
    """An agent that is ready to run, with its seed."""

    name: str
    seed: int
    ready: ReadyAgent


def run_job(job: Job) -> list[tuple[str, Outcome]]:
    """Run one job in this process."""
    plant = find_plant(job.plant)
    tasks = plant.tasks(job.splits)
    seeded = []
    for name, group in groupby(job.agents, key=lambda agent: agent[0]):
        seeds = [seed for _, seed in group]
        made = find_entrant(job.registry, name).ready(plant, seeds, tuple(tasks))
        found = zip(seeds, made, strict=True)
        seeded += [SeededAgent(name=name, seed=seed, ready=ready) for seed, ready in found if ready is not None]
    return run_agents(plant, seeded, tasks, job.threads)


@dataclass(frozen=True)
class MarginsJob:
    """One seed of an agent with feedback, whose stability margins are measured."""

    registry: Registry
    name: str
    seed: int


def run_margins_job(job: MarginsJob) -> Margins | None:
    """Measure the margins of an agent on the machine with drives in this process; None if it does not run there."""
    plant, entrant = drives_plant(), find_entrant(job.registry, job.name)
    [ready] = entrant.ready(plant, [job.seed], ())
    if ready is None or ready.policy is None:
        return None
    base = None
    if entrant.base is not None:
        [below] = find_entrant(job.registry, entrant.base).ready(plant, [0], ())
        base = None if below is None else below.timed
    found = measure_margins(plant, ready.policy, base, n_threads=1)
    dt = plant.rig.arm.robot.servo.control_dt
    return Margins(
        seed=job.seed,
        fingerprint=plant.fingerprint,
        artefact=ready.artefact,
        gain=found.gain,
        delay_ms=None if found.delay is None else found.delay * dt * 1e3,
    )


def run_agents(
    plant: TestPlant, seeded: Sequence[SeededAgent], tasks: Sequence[Task], threads: int = 0
) -> list[tuple[str, Outcome]]:
    """Run agents on a plant; return names and outcomes, laws first."""
    laws = [(agent, agent.ready.law) for agent in seeded if agent.ready.law is not None]
    policies = [(agent, agent.ready.policy) for agent in seeded if agent.ready.policy is not None]
    recordings: list[Sequence[Recording | None]] = []
    # laws on the rig, all side by side in one batch
    if laws:
        references = make_references(plant.rig.arm, tasks)
        runs = [
            Run(reference=reference, law=law, channel=agent.ready.channel)
            for agent, law in laws
            for reference in references
        ]
        noise = [np.random.default_rng(noise_seed(task, agent.seed)) for agent, _ in laws for task in tasks]
        recorded = plant.rig.run(runs, seed=noise, n_threads=threads)
        recordings += [recorded[i : i + len(tasks)] for i in range(0, len(recorded), len(tasks))]
    # policies in the environment, seeds of one row side by side
    for _, group in groupby(policies, key=lambda entry: entry[0].name):
        row = list(group)
        seeds = [agent.seed for agent, _ in row]
        found = run_rollouts(plant, [policy for _, policy in row], tasks, seeds=seeds, n_threads=threads)
        recordings += [[rollout.recording for rollout in rollouts] for rollouts in found]
    ran = [agent for agent, _ in (*laws, *policies)]
    return [(one.name, _outcome(plant, one, tasks, own)) for one, own in zip(ran, recordings, strict=True)]


def _outcome(
    plant: TestPlant, agent: SeededAgent, tasks: Sequence[Task], recordings: Sequence[Recording | None]
) -> Outcome:
    """Score the recordings of an agent on its tasks."""
    ready, acts = agent.ready, agent.ready.policy or agent.ready.timed
    pairs = list(zip(tasks, recordings, strict=True))
    cells = [
        cell
        for task, recording in pairs
        for cell in (score_circles(task, recording) if recording else lost_cells(task))
    ]
    pictured = agent.seed == 0 and not plant.name.startswith((DRAW, DRAWN_WORKCELL))
    trails = [trail for task, recording in pairs if pictured and recording for trail in compute_trails(task, recording)]
    return Outcome(
        seed=agent.seed,
        plant=plant.name,
        fingerprint=plant.fingerprint,
        versions=", ".join(f"{name} {version}" for name, version in versions().items()),
        artefact=ready.artefact,
        robot_seconds=ready.robot_seconds,
        env_steps=ready.env_steps,
        inference_us=None if acts is None else inference_time(plant, acts),
        cells=tuple(cells),
        trails=tuple(trails),
    )


def compute_trails(task: Task, recording: Recording) -> list[Trail]:
    """Compute the trail of the circle that pictures show, if the task has it."""
    position, radius = PICTURED
    if task.position != position or radius not in task.radii:
        return []
    phase = recording.phases_of("circle")[task.radii.index(radius)]
    deviation = deviation_along(recording, phase, _POINTS) * 1e6
    return [
        Trail(
            position=position,
            radius_mm=in_mm(radius),
            speed_mm_s=in_mm(task.speed),
            deviation_um=tuple(float(f"{x:.4g}") for x in deviation),
        )
    ]


def score_circles(task: Task, recording: Recording) -> list[CircleResult]:
    """Score the circles of a task that ran to its end."""
    return [
        CircleResult(
            split=task.split,
            position=task.position,
            speed_mm_s=in_mm(task.speed),
            **vars(score) | {"motor_rms_rad": tuple(score.motor_rms_rad)},
        )
        for score in circle_scores(recording, task.radii)
    ]


def score_motion(task: Task, recording: Recording) -> list[CircleResult]:
    """Score a task that ran to its end: its circles, or the whole of another motion by its contour error."""
    if task.kind in (CIRCLE, TILTED):
        return score_circles(task, recording)
    whole = contour_errors(recording)[0]
    rms, most = whole.rms * 1e3, whole.max * 1e3
    [lost] = lost_cells(task)
    motors = tuple(float(x) for x in motor_error_rms(recording))
    return [replace(lost, rms_mm=rms, max_mm=most, rms_3d_mm=rms, max_3d_mm=most, motor_rms_rad=motors)]


def lost_cells(task: Task) -> list[CircleResult]:
    """Make results without figures for a task in which the robot stopped, which counts as the worst."""
    speed = in_mm(task.speed)
    return [
        CircleResult(split=task.split, position=task.position, radius_mm=in_mm(radius), speed_mm_s=speed)
        for radius in task.radii
    ]
