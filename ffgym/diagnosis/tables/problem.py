"""Least-squares problem of one structure and a table: residuals of the fitted rows, and of all places but one.

Lowered is the sum of squares of logarithms of simulated over measured errors, in units of their spreads, and of the
distances of free numbers from their typical values, in units of theirs.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.fit.batches import Descent, Evaluate, Point
from ffgym.diagnosis.tables.error_table import ErrorTable
from ffgym.diagnosis.tables.parts import find_structure
from ffgym.diagnosis.tables.simulated import TableSimulator
from ffgym.diagnosis.tables.structures import ModelStructure
from ffgym.robot import load_robot

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

Keep = Callable[[Point], None]
"""Called with each point of a search."""


def weigh_logs(values: Array, measured: Array, is_rms: BoolArray) -> Array:
    """Compute ln(simulated / measured) in units of its spread, shape (..., R); failed candidates have the worst."""
    logs: Array = np.log(np.where(np.isfinite(values), values, _FAILED) / measured)
    return logs / np.where(is_rms, RMS_SPREAD, MAX_SPREAD)


class TableProblem:
    """Fit of the free numbers of a structure to the fitted rows of a table."""

    def __init__(self, table: ErrorTable, name: str, search_dt: float) -> None:
        """Plan the motions; `search_dt` is the physics step [s]."""
        self.table, self.search_dt = table, search_dt
        self.structure: ModelStructure = find_structure(name)
        self.robot = load_robot(table.robot)
        self.simulator = TableSimulator(table, self.robot)
        self._fitted = np.flatnonzero(table.fitted)
        # rows that a search simulates in the place of the fitted ones
        twins = [table.twin(table.rows[i]) for i in self._fitted]
        keys = [(row.motion, row.radius_mm, row.law, row.statistic) for row in twins]
        unique = list(dict.fromkeys(keys))
        self._rows = [twins[keys.index(key)] for key in unique]
        self._of_fitted = np.array([unique.index(key) for key in keys])

    def evaluate(self, xs: Array) -> list[tuple[Array, Array]]:
        """Errors of the fitted rows [mm], and residuals, of candidates (C, K)."""
        candidates = [self.structure.candidate(self.robot, x) for x in xs]
        values = self.simulator.values(candidates, self._rows, self.search_dt)[:, self._of_fitted]
        misfits = weigh_logs(values, self.table.values[self._fitted], self.table.is_rms[self._fitted])
        residuals = np.concatenate([misfits, xs / self.structure.spread], axis=1)
        return list(zip(values, residuals, strict=True))

    @property
    def descent(self) -> Descent:
        """Search on all fitted rows."""
        return self._descent(self.evaluate)

    def search(self, starts: Array, steps: int, keep: Keep, state: Mapping[str, Any]) -> Point:
        """Search on all fitted rows, from where a state stands, or else from the best of `starts` (S, K)."""
        return self.descent.search(starts, steps, keep, state, _GAIN)

    def search_without(self, place: str, start: Array, steps: int, keep: Keep, state: Mapping[str, Any]) -> Point:
        """Search on all fitted rows but those of a place, from where a state stands, or else from `start` (K,)."""
        kept = self._kept(place)

        def evaluate(xs: Array) -> list[tuple[Array, Array]]:
            return [(values, residuals[kept]) for values, residuals in self.evaluate(xs)]

        return self._descent(evaluate).search(start[None], steps, keep, state, _GAIN)

    def step_without(self, place: str, point: Point, jacobian: Array) -> Array:
        """Compute the free numbers (K,) that one step from an optimum fits to all rows but those of a place."""
        if not len(point.x):
            return point.x
        kept = self._kept(place)
        own, slopes = point.residuals[kept], jacobian[kept]
        reach = self.structure.reach
        return np.clip(point.x - np.linalg.solve(slopes.T @ slopes, slopes.T @ own), -reach, reach)

    def rows_at(self, place: str) -> BoolArray:
        """Tell which of the fitted rows are at a place."""
        return self.table.at(place)[self._fitted]

    def _kept(self, place: str) -> BoolArray:
        """Residuals that do not belong to rows of a place: other rows, and priors."""
        return np.concatenate([~self.rows_at(place), np.ones(len(self.structure.numbers), dtype=np.bool_)])

    def _descent(self, evaluate: Evaluate) -> Descent:
        spread, reach = self.structure.spread, self.structure.reach
        return Descent(
            evaluate=evaluate,
            steps=np.minimum(STEP * spread, LARGEST_STEP),
            spread=spread,
            clip=lambda x: np.clip(x, -reach, reach),
            dampings=_DAMPINGS,
        )
