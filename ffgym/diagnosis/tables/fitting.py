"""Fit of one structure to a table, in stages that can be resumed: search, places left out, judgement of all rows.

1. Search: damped Gauss-Newton from the description, or from fits of its parts, at SEARCH_DT, on the fitted rows.
2. Each place left out: a search of its own from the optimum without its rows, or one step of it, and what that leaves
   in them.
3. Judgement: all rows at the robot's own physics step, learned laws among them.
"""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.files import read_text, write_json
from ffgym.core.provenance import versions
from ffgym.core.typed_json import parse_json, to_json
from ffgym.core.types import Array
from ffgym.diagnosis.fit.batches import Point
from ffgym.diagnosis.tables.error_table import ErrorTable
from ffgym.diagnosis.tables.parts import find_structure
from ffgym.diagnosis.tables.problem import SEARCH_DT, Keep, TableProblem
from ffgym.diagnosis.tables.simulated import Learn
from ffgym.diagnosis.tables.structure_fit import LeftOutBy, StructureFit, describe_numbers, parse_fit
from ffgym.robot import ModelOptions, load_robot
from ffgym.simulation.plant import Machine


@dataclass(frozen=True, kw_only=True)
class FitTask:
    """Work on one structure, which any process can do."""

    table: ErrorTable
    name: str
    """Name of the structure."""
    folder: Path
    """Folder of the state files."""
    steps: int
    """Most steps of the search."""
    starts: tuple[tuple[tuple[str, float], ...], ...] = ()
    """Free numbers x by name to begin at, beside 0; the search begins at the start of the lowest cost, and numbers that
    a start does not name begin at 0."""
    left_out_by: LeftOutBy = "refit"
    """Fit of all rows but those of a place, which predicts these."""
    learn: Learn | None = None
    search_dt: float = SEARCH_DT
    judge_dt: float | None = None
    """Physics step of the judgement [s]; None is the robot's own."""

    @property
    def file(self) -> Path:
        """State file of this structure."""
        return self.folder / f"{self.name}.json"

    @property
    def key(self) -> str:
        """Digest of everything that the result depends on."""
        structure, machine = find_structure(self.name), Machine.of(load_robot(self.table.robot))
        parts = (
            repr(self.table),
            machine.physics(ModelOptions(looks=False)),
            *self.table.motion_texts,
            repr([(n.name, n.typical, n.spread, n.scale, n.reach) for n in structure.numbers]),
            repr((self.steps, self.search_dt, self.judge_dt, self.starts, self.left_out_by)),
            repr(versions()),
        )
        return hashlib.sha256("|".join(parts).encode()).hexdigest()[:16]


Tell = Callable[[str], None]


def fit_structure(task: FitTask, tell: Tell = lambda text: None) -> StructureFit:
    """Fit a structure, or go on where its state file stands; a finished one is read.

    Raises:
        FFGymError: if the state file is of another table, robot, motion, structure or version.
    """
    state = _read_state(task)
    if "result" in state:
        return parse_fit(state["result"], str(task.file))
    work = _Work(task, state, tell)
    point = work.search()
    jacobian = work.problem.descent.jacobian(point)
    left_out = work.leave_places_out(point, jacobian)
    tell(f"{task.name}: all rows")
    fit = work.judge(point, jacobian, left_out)
    write_json(task.file, {"key": task.key, "result": to_json(fit)})
    return fit


def _read_state(task: FitTask) -> dict[str, Any]:
    if not task.file.exists():
        return {}
    state: Any = parse_json(read_text(task.file), str(task.file), "Remove it to begin anew.")
    if not isinstance(state, dict) or state.get("key") != task.key:
        raise FFGymError(
            f"{task.file}: is of another table, robot, motion, structure, number of steps or version of a program. "
            f"Name another folder, or remove it to begin anew."
        )
    return state


class _Work:
    """Stages of a fit, which keep their state in the file of their task."""

    def __init__(self, task: FitTask, state: dict[str, Any], tell: Tell) -> None:
        self.task, self.table, self._state, self._tell = task, task.table, state, tell
        self.problem = TableProblem(task.table, task.name, task.search_dt)

    def _keeper(self, stage: str, title: str) -> Keep:
        """Return a function that keeps and tells each point of a search."""

        def keep(point: Point) -> None:
            self._state[stage] = point.state
            write_json(self.task.file, self._state | {"key": self.task.key})
            self._tell(f"{title}: step {point.steps}, cost {point.cost:.1f}")

        return keep

    def search(self) -> Point:
        """Search from where the state stands."""
        names = [number.name for number in self.problem.structure.numbers]
        starts = [[dict(start).get(name, 0.0) for name in names] for start in ((), *self.task.starts)]
        keep = self._keeper("search", self.task.name)
        begun = self._state.get("search", {})
        return self.problem.search(np.array(starts, dtype=np.float64), self.task.steps, keep, begun)

    def leave_places_out(self, point: Point, jacobian: Array) -> Array:
        """Predict the fitted rows of each place by numbers that are fitted to all others [mm], nan elsewhere, (R,)."""
        found = np.full(len(self.table.rows), np.nan)
        places = self.table.places
        if len(places) < 2:
            return found
        if self.task.left_out_by == "refit":
            values = [self._refit(place, point.x) for place in places]
        else:
            xs = np.array([self.problem.step_without(place, point, jacobian) for place in places])
            values = [each for each, _ in self.problem.evaluate(xs)]
        for place, each in zip(places, values, strict=True):
            found[self.table.at(place)] = each[self.problem.rows_at(place)]
        return found

    def _refit(self, place: str, start: Array) -> Array:
        """Fit without a place, from the optimum with it; errors of all fitted rows [mm]."""
        stage = f"without {place}"
        keep = self._keeper(stage, f"{self.task.name} {stage}")
        begun = self._state.get(stage, {})
        values: Array = self.problem.search_without(place, start, self.task.steps, keep, begun).outcome
        return values

    def judge(self, point: Point, jacobian: Array, left_out: Array) -> StructureFit:
        """Simulate all rows, and describe the fit."""
        structure, robot = self.problem.structure, self.problem.robot
        candidate = structure.candidate(robot, point.x)
        judge_dt = self.task.judge_dt or robot.physics_dt
        predicted = self.problem.simulator.values([candidate], self.table.rows, judge_dt, self.task.learn)[0]
        return StructureFit(
            name=self.task.name,
            title=structure.title,
            free_parameters=len(point.x),
            cost=point.cost,
            prior_cost=float(np.sum((point.x / structure.spread) ** 2)),
            steps=point.steps,
            numbers=describe_numbers(structure, point.x, jacobian),
            x=tuple(point.x.tolist()),
            predicted_mm=tuple(predicted.tolist()),
            left_out_mm=tuple(left_out.tolist()),
            left_out_by=self.task.left_out_by,
            fingerprint=candidate.machine.physics(ModelOptions(looks=False, physics_dt=judge_dt)),
        )
