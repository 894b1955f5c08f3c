"""Fit of one structure to a table, in stages that can be resumed: search, judgement of all rows, places left out.

1. Search: damped Gauss-Newton from the description, or from fits of its parts, at SEARCH_DT, on the fitted rows.
2. Judgement: all rows at the robot's own physics step, learned laws among them.
3. Each place left out: one Gauss-Newton step from the optimum without its rows, and what that leaves in them.

Lowered is the sum of squares of logarithms of simulated over measured errors, in units of their spreads, and of the
distances of free numbers from their typical values, in units of theirs.
"""

import hashlib
import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.files import read_text, write_json
from ffgym.core.provenance import versions
from ffgym.core.typed_json import from_json, to_json
from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.fit.batches import Descent, Point
from ffgym.diagnosis.tables.error_table import ErrorTable
from ffgym.diagnosis.tables.parts import find_structure
from ffgym.diagnosis.tables.simulated import Learn, TableSimulator
from ffgym.diagnosis.tables.structures import ModelStructure
from ffgym.robot import ModelOptions, load_robot

RMS_SPREAD = 0.2
"""Chosen: a simulated RMS error that is off by 20 % costs as much as a free number that is off by its spread."""
MAX_SPREAD = 0.4
"""Chosen: largest errors hang on single events, and weigh a quarter."""

SEARCH_DT = 0.001
"""Physics step of the search [s]: a quarter of the time, and errors that differ by 1 % (median)."""

STEP, LARGEST_STEP = 0.2, 0.05
"""Step of finite differences, in spreads, and its largest value; chosen: far above the noise of stick-slip, below where
the model bends."""
_DAMPINGS = (0.03, 0.3, 3.0)
"""Factors on the damping of the last step that are tried."""
_GAIN = 0.005
"""Relative gain of a step below which another is not worth its simulations."""
_FAILED = 1e3
"""Error of a candidate that cannot be simulated [mm]: worse than any other, and no reason to stop the search."""


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
        structure = find_structure(self.name)
        parts = (
            repr(self.table),
            repr([(n.name, n.typical, n.spread, n.scale, n.reach) for n in structure.numbers]),
            repr((self.steps, self.search_dt, self.judge_dt, self.starts)),
            repr(versions()),
        )
        return hashlib.sha256("|".join(parts).encode()).hexdigest()[:16]


@dataclass(frozen=True, kw_only=True)
class FittedFreeNumber:
    """Free number after the fit."""

    name: str
    value: float
    unit: str
    low: float
    """Lower end of the interval of 90 %, by linear error propagation about the optimum."""
    high: float
    typical: float
    """Value before the fit."""
    spreads: float
    """Distance from the typical value, in standard deviations of the prior."""
    source: str
    """Origin of the prior."""


@dataclass(frozen=True, kw_only=True)
class StructureFit:
    """Structure with its fitted numbers, and what it says of every row."""

    name: str
    title: str
    free_parameters: int
    cost: float
    """Sum of squares at the optimum, priors among them."""
    prior_cost: float
    """Part of it that the distances from typical values have."""
    steps: int
    """Steps of the search."""
    numbers: tuple[FittedFreeNumber, ...]
    x: tuple[float, ...]
    """Free numbers as they were fitted."""
    predicted_mm: tuple[float, ...]
    """Error of each row of the table at the optimum."""
    left_out_mm: tuple[float, ...]
    """Error of each fitted row, predicted without the rows of its place, at the step of the search; nan for others."""
    fingerprint: str
    """Fingerprint of the physics of the fitted machine."""

    @property
    def start(self) -> tuple[tuple[str, float], ...]:
        """Free numbers x by name, for a search of a structure that extends this one."""
        return tuple((number.name, x) for number, x in zip(self.numbers, self.x, strict=True))


Tell = Callable[[str], None]


def fit_structure(task: FitTask, tell: Tell = lambda text: None) -> StructureFit:
    """Fit a structure, or go on where its state file stands; a finished one is read.

    Raises:
        FFGymError: if the state file is of another table, structure or version.
    """
    state = _read_state(task)
    if "result" in state:
        return parse_fit(state["result"], str(task.file))
    problem = _Problem(task)
    point = problem.search(state, tell)
    tell(f"{task.name}: all rows")
    fit = problem.judge(point)
    write_json(task.file, {"key": task.key, "result": to_json(fit)})
    return fit


def _read_state(task: FitTask) -> dict[str, Any]:
    if not task.file.exists():
        return {}
    try:
        state: dict[str, Any] = json.loads(read_text(task.file))
    except json.JSONDecodeError as error:
        raise FFGymError(f"{task.file}: is no valid JSON: {error}. Remove it to begin anew.") from error
    if state.get("key") != task.key:
        raise FFGymError(
            f"{task.file}: is of another table, structure, number of steps or version of a program. Name another "
            f"folder, or remove it to begin anew."
        )
    return state


def parse_fit(value: Any, where: str) -> StructureFit:
    """Parse a fit that `to_json` wrote."""
    fit: StructureFit = from_json(StructureFit, value, where)
    return fit


def weigh_logs(values: Array, measured: Array, is_rms: BoolArray) -> Array:
    """Compute ln(simulated / measured) in units of its spread, shape (..., R); failed candidates have the worst."""
    logs: Array = np.log(np.where(np.isfinite(values), values, _FAILED) / measured)
    return logs / np.where(is_rms, RMS_SPREAD, MAX_SPREAD)


class _Problem:
    """Search and judgement of one structure."""

    def __init__(self, task: FitTask) -> None:
        self.task, self.table = task, task.table
        self.structure: ModelStructure = find_structure(task.name)
        self.robot = load_robot(self.table.robot)
        self.simulator = TableSimulator(self.table, self.robot)
        self._fitted = np.flatnonzero(self.table.fitted)
        # rows that a search simulates in the place of the fitted ones
        twins = [self.table.twin(self.table.rows[i]) for i in self._fitted]
        keys = [(row.motion, row.radius_mm, row.law, row.statistic) for row in twins]
        self._unique = list(dict.fromkeys(keys))
        self._rows = [twins[keys.index(key)] for key in self._unique]
        self._of_fitted = np.array([self._unique.index(key) for key in keys])

    def evaluate(self, xs: Array) -> list[tuple[Array, Array]]:
        """Errors of the fitted rows [mm], and residuals, of candidates (C, K)."""
        candidates = [self.structure.candidate(self.robot, x) for x in xs]
        values = self.simulator.values(candidates, self._rows, self.task.search_dt)[:, self._of_fitted]
        misfits = weigh_logs(values, self.table.values[self._fitted], self.table.is_rms[self._fitted])
        residuals = np.concatenate([misfits, xs / self.structure.spread], axis=1)
        return list(zip(values, residuals, strict=True))

    @property
    def descent(self) -> Descent:
        """The search."""
        spread, reach = self.structure.spread, self.structure.reach
        return Descent(
            evaluate=self.evaluate,
            steps=np.minimum(STEP * spread, LARGEST_STEP),
            spread=spread,
            clip=lambda x: np.clip(x, -reach, reach),
            dampings=_DAMPINGS,
        )

    def search(self, state: dict[str, Any], tell: Tell) -> Point:
        """Search from where the state stands."""
        names = [number.name for number in self.structure.numbers]
        starts = [[dict(start).get(name, 0.0) for name in names] for start in ((), *self.task.starts)]

        def keep(point: Point) -> None:
            write_json(self.task.file, {"key": self.task.key, "search": point.state})
            tell(f"{self.task.name}: step {point.steps}, cost {point.cost:.1f}")

        begun = state.get("search", {})
        return self.descent.search(np.array(starts, dtype=np.float64), self.task.steps, keep, begun, _GAIN)

    def judge(self, point: Point) -> StructureFit:
        """Simulate all rows, and leave each place out."""
        jacobian = self.descent.jacobian(point)
        candidate = self.structure.candidate(self.robot, point.x)
        judge_dt = self.task.judge_dt or self.robot.physics_dt
        predicted = self.simulator.values([candidate], self.table.rows, judge_dt, self.task.learn)[0]
        return StructureFit(
            name=self.task.name,
            title=self.structure.title,
            free_parameters=len(point.x),
            cost=point.cost,
            prior_cost=float(np.sum((point.x / self.structure.spread) ** 2)),
            steps=point.steps,
            numbers=self._numbers(point, jacobian),
            x=tuple(point.x.tolist()),
            predicted_mm=tuple(predicted.tolist()),
            left_out_mm=tuple(self._leave_places_out(point, jacobian).tolist()),
            fingerprint=candidate.machine.physics(ModelOptions(looks=False, physics_dt=judge_dt)),
        )

    def _numbers(self, point: Point, jacobian: Array) -> tuple[FittedFreeNumber, ...]:
        """Values of the free numbers, with intervals by linear error propagation; priors are rows of the Jacobian."""
        if not len(point.x):
            return ()
        sigma = np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian)))
        return tuple(
            FittedFreeNumber(
                name=number.name,
                value=number.value(float(x)),
                unit=number.unit,
                low=number.value(float(x - 1.645 * s)),
                high=number.value(float(x + 1.645 * s)),
                typical=number.typical,
                spreads=float(x / number.spread),
                source=number.source,
            )
            for number, x, s in zip(self.structure.numbers, point.x, sigma, strict=True)
        )

    def _leave_places_out(self, point: Point, jacobian: Array) -> Array:
        """Predict the fitted rows of each place by numbers that one step from the optimum fits to all others."""
        found = np.full(len(self.table.rows), np.nan)
        places = self.table.places
        if len(places) < 2:
            return found
        outs: list[BoolArray] = [self.table.at(place) for place in places]
        xs = []
        for out in outs:
            kept = np.concatenate([~out[self._fitted], np.ones(len(point.x), dtype=np.bool_)])
            own, slopes = point.residuals[kept], jacobian[kept]
            step = np.linalg.solve(slopes.T @ slopes, slopes.T @ own) if len(point.x) else np.zeros(0)
            reach = self.structure.reach
            xs.append(np.clip(point.x - step, -reach, reach) if len(point.x) else point.x)
        for out, (values, _) in zip(outs, self.evaluate(np.array(xs)), strict=True):
            found[out] = values[out[self._fitted]]
        return found
