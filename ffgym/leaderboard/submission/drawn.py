"""Score of a submission on drawn machines and motions, beside rows that it can be compared with.

Whoever stores torques of the public motions gains nothing here: neither machines nor motions exist before the draw.
"""

from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

import numpy as np

from ffgym.control import Agent, ObservationLayout, Policy, sees_errors
from ffgym.core.errors import FFGymError
from ffgym.core.provenance import versions
from ffgym.core.types import Array
from ffgym.envs.machines import is_workcell
from ffgym.leaderboard.comparison.samples import Grid, collect_sample
from ffgym.leaderboard.comparison.scores import Difference, Score, ScoredRow, compare_rows, compute_score
from ffgym.leaderboard.comparison.standings import rank_rows
from ffgym.leaderboard.comparison.statistics import Interval
from ffgym.leaderboard.evaluation.closed_loop import run_rollouts
from ffgym.leaderboard.evaluation.jobs import lost_cells, score_motion
from ffgym.leaderboard.motions import CIRCLE
from ffgym.leaderboard.plants import TestPlant, find_plant
from ffgym.leaderboard.results import CircleResult, Outcome, Row, SentSetpoints
from ffgym.leaderboard.submission.judge import (
    ACTION_TOLERANCE,
    SCORE_TOLERANCE,
    Judge,
    check_physics,
    controller_of,
    make_view,
)
from ffgym.leaderboard.submission.manifest import Manifest, Refused, decode_submission, sha256_of
from ffgym.leaderboard.submission.python_agent import View
from ffgym.leaderboard.submission.rounds import DRAWN, Round
from ffgym.leaderboard.tasks import Task
from ffgym.report.laws import UNCOMPENSATED
from ffgym.robot import RobotDescription

BASE = "elastic"
"""Row that gains are told against: the best law of nominal parameters alone."""
MUCH = 0.9
"""Error in that of the base below which a public score is much better; chosen: machines differ by less."""
HELD = 0.5
"""Share of its public gain over the base, in the logarithm of the error, that a submission must hold on drawn machines
and motions, or it is called memorised; chosen: a half."""


@dataclass(frozen=True, kw_only=True)
class DrawnRow:
    """One row on the drawn machines and motions."""

    row: Row
    """Errors on every machine and motion."""
    rank: int
    """Rank on drawn machines and motions; rows that the interval over machines does not tell apart share one."""
    score: Score
    """Score on drawn machines and motions."""
    public: float
    """Error left on the public circles, in that of zero action: geometric mean."""
    by_kind: Mapping[str, float]
    """Error left on the drawn motions of each kind, likewise."""

    @property
    def name(self) -> str:
        """Name of the row."""
        return self.row.name


@dataclass(frozen=True, kw_only=True)
class DrawnVerdict:
    """Scores of a submission and of other rows on drawn machines and motions."""

    round: Round
    manifest: Manifest
    name: str
    """Name of the submission's row."""
    fingerprints: Mapping[str, str]
    """Fingerprints of the physics, by machine."""
    motions: tuple[Task, ...]
    rows: tuple[DrawnRow, ...]
    """Best first."""
    against_base: Difference
    """Error of the submission in that of BASE, on drawn machines and motions."""
    public_ratio: float
    """The same on the public circles."""
    robot_seconds: float = 0.0
    """Motion of a drawn machine that the agent saw before a scored one [s]: none, as every motion is an episode of its
    own, and no agent can practise here."""

    @property
    def own(self) -> DrawnRow:
        """Row of the submission."""
        return next(row for row in self.rows if row.name == self.name)

    @property
    def is_memorised(self) -> bool:
        """True if less than HELD of the public gain holds, at the favourable end of the interval over machines."""
        drawn = self.against_base
        best = drawn.ratio if drawn.interval is None else drawn.interval.low
        return best > self.public_ratio**HELD and self.public_ratio < MUCH

    @property
    def sentence(self) -> str:
        """Verdict in a line."""
        score = self.own.score
        line = (
            f"accepted, rank {self.own.rank} of {len(self.rows)}: on {_count(self.round.machines, 'machine')} and "
            f"{_count(self.round.motions, 'motion')} that were drawn it leaves {score.left:.3f}"
            f"{_ends(score.left_interval)} of the error"
        )
        if score.stopped:
            line += f"; the robot stopped in {score.stopped:.0%} of the runs, which counts as infinite"
        if self.is_memorised:
            line += (
                f"; memorised: of the error of {BASE} it leaves {self.public_ratio:.3f} on the public circles, and "
                f"{self.against_base.ratio:.3f}{_ends(self.against_base.interval)} on what was drawn"
            )
        return line


def _ends(interval: Interval | None) -> str:
    return "" if interval is None else f" [{interval.low:.3f}, {interval.high:.3f}]"


def _count(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number} {what}s"


def verify_drawn(
    judge: Judge, data: bytes, drawn: Round, beside: Mapping[str, Policy], others: Sequence[bytes] = ()
) -> DrawnVerdict:
    """Run a submission that was accepted, and rows beside it, on the machines and motions of a round.

    Args:
        judge: judge that accepted it; its `plan` has the public circles.
        data: bytes of the submission.
        drawn: the round.
        beside: policies by name, all with one preview and one action scale, among them BASE; zero action is added.
        others: bytes of other submissions to run beside it; they are scored, and their claims are not checked.

    Raises:
        Refused: if an agent fails, or decides otherwise for one robot alone than for all.
        FFGymError: if machines have different controllers, or the robot stops with zero action.
    """
    like = beside[BASE]
    view = View(preview=like.preview, action_scale=like.action_scale, feedback=sees_errors(like), make=ZeroAction)
    beside = {UNCOMPENSATED: view} | dict(beside)
    submitted = _decode([data, *others], list(beside), judge.plan)
    name = next(iter(submitted))
    # every motion on each machine, by all rows
    pairs = _pair(drawn)
    rows: dict[str, Cells] = {}
    for each, one in submitted.items():
        rows |= _run_submitted(judge, pairs, each, one, drawn)
    rows |= _run(judge, pairs, beside, None, drawn.noise, "drawn machines")
    scored, zero, grid = _score([_row(each, cells, submitted.get(each)) for each, cells in rows.items()])
    # what the rows leave on the public circles
    public = _public_errors(judge, submitted, beside, drawn.series)
    left = {each: float(np.exp(np.mean(np.log(errors / public[UNCOMPENSATED])))) for each, errors in public.items()}
    best_first = sorted(scored.values(), key=lambda each: (each.mean, each.row.name))
    ranks = rank_rows(best_first, compare_replayed)
    return DrawnVerdict(
        round=drawn,
        manifest=submitted[name].manifest,
        name=name,
        fingerprints=grid.fingerprints,
        motions=tuple(dict.fromkeys(task for _, task in pairs)),
        rows=tuple(
            DrawnRow(
                row=each.row,
                rank=ranks[each.row.name],
                score=compute_score(each, grid, zero, None),
                public=left[each.row.name],
                by_kind=_errors_left(each.row, scored[UNCOMPENSATED].row, drawn.kinds),
            )
            for each in best_first
        ),
        against_base=compare_rows(scored[name], scored[BASE]),
        public_ratio=left[name] / left[BASE],
    )


@dataclass(frozen=True, kw_only=True)
class Submitted:
    """Contents of a submission."""

    manifest: Manifest
    content: bytes | None
    """Bytes of the agent's file; None if it has none."""
    sha256: str
    """Hash of the submission's file."""
    whose: str
    """First words of a refusal."""


def _decode(
    submissions: Sequence[bytes], taken: Sequence[str], plan: Mapping[str, Sequence[Task]]
) -> dict[str, Submitted]:
    """Decode submissions by the names of their rows, which are told apart where two have one name."""
    found: dict[str, Submitted] = {}
    for k, data in enumerate(submissions):
        try:
            manifest, files = decode_submission(data)
            check_physics(manifest, plan)
        except Refused as refusal:
            raise Refused(refusal.check, refusal.reason, f"submission {k} beside it: " if k else "") from refusal
        name, number = manifest.name, 1
        while name in found or name in taken:
            name, number = f"{manifest.name} ({number})", number + 1
        content = files.get(str(manifest.agent.file))
        whose = f"{name}, beside it: " if k else ""
        found[name] = Submitted(manifest=manifest, content=content, sha256=sha256_of(data), whose=whose)
    return found


def _pair(drawn: Round) -> list[tuple[TestPlant, Task]]:
    """Pair every drawn machine with every drawn motion; FFGymError unless one controller has all machines."""
    plants = [find_plant(plant) for plant in drawn.plants]
    if len(known := {controller_of(plant.name) for plant in plants}) > 1:
        raise FFGymError(f"Machines of {drawn.series!r} have different controllers, {', '.join(sorted(known))}.")
    area = plants[0].rig.robot.work_area
    assert area is not None  # robots of the leaderboard have one
    return [(plant, task) for plant in plants for task in drawn.draw_motions(area)]


def compare_replayed(first: ScoredRow, second: ScoredRow) -> Difference:
    """Compare two rows; errors within the tolerance of a replay do not differ, as actions come back as float32."""
    found = compare_rows(first, second)
    low, high = (found.ratio, found.ratio) if found.interval is None else (found.interval.low, found.interval.high)
    wider = Interval(low * (1 - SCORE_TOLERANCE), high * (1 + SCORE_TOLERANCE))
    return Difference(ratio=found.ratio, interval=wider)


@dataclass(frozen=True)
class ZeroAction:
    """Agent that adds no torque."""

    robot: RobotDescription
    layout: ObservationLayout

    def predict(
        self, observation: Array, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[Array, Any]:
        """Return zeros, shape (B, N)."""
        return np.zeros((len(observation), self.robot.n_joints)), None


class SpotCheck:
    """Agent for all robots, beside one that decides for a single one of them alone; both must decide the same."""

    def __init__(self, every: Agent, alone: Agent, robot: int, whose: str = "") -> None:
        """Watch the robot of this number; `whose` are the first words of a refusal."""
        self._every, self._alone, self._robot, self._whose = every, alone, robot, whose
        self._largest, self._difference = np.array(np.finfo(np.float32).tiny), np.array(0.0)

    def predict(
        self, observation: Array, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[Array, Any]:
        """Return the actions for all robots."""
        action, new = self._every.predict(observation, state, episode_start)
        row = slice(self._robot, self._robot + 1)
        own, _ = self._alone.predict(observation[row], state, episode_start[row])
        self._largest = np.maximum(self._largest, np.abs(action[self._robot]))
        self._difference = np.maximum(self._difference, np.abs(own[0] - action[self._robot]))
        return action, new

    def compare(self) -> None:
        """Check that both decided the same; Refused if they did not."""
        worst = float(np.max(self._difference / self._largest))
        if worst > ACTION_TOLERANCE:
            raise Refused(
                "agent",
                f"for one robot of the drawn ones alone it decides otherwise than for all, by {worst:.2g} of the "
                f"largest action of a motor: it uses what other robots see.",
                self._whose,
            )


Cells = dict[TestPlant, list[CircleResult]]


def _run_submitted(
    judge: Judge, pairs: Sequence[tuple[TestPlant, Task]], name: str, one: Submitted, drawn: Round
) -> dict[str, Cells]:
    """Run the agent of a submission; its decisions for one of the robots are asked for alone, too."""
    manifest = one.manifest
    with ExitStack() as stack:
        every, alone = (
            stack.enter_context(judge.start_agent(manifest.agent, one.content, pairs[0][0].name, manifest, one.whose))
            for _ in range(2)
        )
        check = SpotCheck(every, alone, drawn.seed % len(pairs), one.whose)
        found = _run(judge, pairs, {name: make_view(manifest)}, check, drawn.noise, f"drawn machines, {name}")
        check.compare()
    return found


def _run(
    judge: Judge,
    pairs: Sequence[tuple[TestPlant, Task]],
    policies: Mapping[str, Policy],
    agent: Agent | None,
    seed: int,
    title: str,
) -> dict[str, Cells]:
    """Run policies on pairs of machines and tasks, all side by side; return their circles by machine."""
    machines, tasks = zip(*pairs, strict=True)
    with judge.stage(title, "s") as shown:
        found = run_rollouts(
            machines[0],
            list(policies.values()),
            tasks,
            machines=machines,
            agents=None if agent is None else [agent],
            seeds=[seed] * len(policies),
            n_threads=judge.n_threads,
            progress=shown,
        )
    rows: dict[str, Cells] = {name: {} for name in policies}
    for name, rollouts in zip(policies, found, strict=True):
        for (plant, task), rollout in zip(pairs, rollouts, strict=True):
            made = lost_cells(task) if rollout.recording is None else score_motion(task, rollout.recording)
            rows[name].setdefault(plant, []).extend(made)
    return rows


def _row(name: str, cells: Cells, submitted: Submitted | None) -> Row:
    """Make a row of the leaderboard of what one agent did on the drawn machines; None is no submission."""
    about = None if submitted is None else submitted.manifest
    return Row(
        name=name,
        title=name if about is None else about.title,
        track="" if about is None else about.track,
        feedback=about is not None and about.sees_errors,
        setpoints=SentSetpoints() if about is not None and about.channel == "setpoint" else None,
        about="" if about is None else f"Submitted by {about.author}.",
        page=None,
        base=None,
        seeded=False,
        command=None,
        ranked=True,
        outcomes=tuple(
            Outcome(
                seed=0 if about is None else about.seed,
                plant=plant.name,
                fingerprint=plant.fingerprint,
                versions=", ".join(f"{package} {version}" for package, version in versions().items()),
                artefact=None if submitted is None else submitted.sha256,
                robot_seconds=0.0,
                env_steps=0 if about is None else about.env_steps,
                inference_us=None,
                cells=tuple(found),
            )
            for plant, found in cells.items()
        ),
    )


def _score(rows: Sequence[Row]) -> tuple[dict[str, ScoredRow], Any, Grid]:
    """Score rows on the grid of all machines and motions that they ran on."""
    like = next(row for row in rows if row.name == UNCOMPENSATED)
    grid = Grid(
        plants=tuple(sorted(outcome.plant for outcome in like.outcomes)),
        cells=tuple(sorted(cell.key for cell in like.outcomes[0].cells)),
        fingerprints={outcome.plant: outcome.fingerprint for outcome in like.outcomes},
    )
    zero = collect_sample(like, grid)
    if not np.all(np.isfinite(zero.rms)):
        raise FFGymError("The robot stopped with zero action, so that nothing can be compared with it; draw again.")
    return {row.name: ScoredRow.of(row, collect_sample(row, grid), zero) for row in rows}, zero, grid


def _errors_left(row: Row, zero: Row, kinds: Sequence[str]) -> dict[str, float]:
    """Compute the geometric mean of errors over those of zero action for each kind of motions that was drawn."""
    logs: dict[str, list[float]] = {kind: [] for kind in kinds}
    for own, other in zip(row.outcomes, zero.outcomes, strict=True):
        for cell, reference in zip(own.cells, other.cells, strict=True):
            kind = cell.split.removeprefix(DRAWN).strip() or CIRCLE
            logs[kind].append(float(np.log((cell.rms_mm or np.inf) / (reference.rms_mm or np.inf))))
    return {kind: float(np.exp(np.mean(each))) for kind, each in logs.items() if each}


def list_public(plants: Iterable[str], series: str) -> list[str]:
    """List the public plants that drawn ones are compared with: workcells if those are drawn, else all."""
    every = list(plants)
    return [plant for plant in every if is_workcell(plant) or not is_workcell(series)] or every


def _public_errors(
    judge: Judge, submitted: Mapping[str, Submitted], beside: Mapping[str, Policy], series: str
) -> dict[str, Array]:
    """Collect RMS path errors [mm] by row on the public circles.

    Those of submissions are their claims, which a replay has checked.
    """
    plants = list_public(judge.plan, series)
    claims = {name: {claim.circle: claim.rms_mm for claim in one.manifest.claims} for name, one in submitted.items()}
    errors: dict[str, list[float]] = {name: [] for name in (*beside, *submitted)}
    for plant in plants:
        machine = find_plant(plant)
        rows = _run(judge, [(machine, task) for task in judge.plan[plant]], beside, None, 0, plant)
        for name, cells in rows.items():
            errors[name] += [cell.rms_mm or np.inf for cell in cells[machine]]
        for cell in rows[UNCOMPENSATED][machine]:
            for name, known in claims.items():
                errors[name].append(known[plant, cell.position, cell.radius_mm, cell.speed_mm_s])
    return {name: np.array(values) for name, values in errors.items()}
