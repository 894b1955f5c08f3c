"""Search of the calibration: what it lowers, as a function of the free numbers, and where it stands, in a file.

Lowered are logarithms of simulated over published path errors, as in a diagnosis from tables, and distances from the
prior.
"""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.files import read_text, write_json
from ffgym.core.types import Array
from ffgym.diagnosis.fit.batches import Descent, Point
from ffgym.diagnosis.tables.error_table import TableRow
from ffgym.diagnosis.tables.known_laws import KNOWN_LAWS
from ffgym.diagnosis.tables.problem import LARGEST_STEP, SEARCH_DT, STEP, weigh_logs
from ffgym.diagnosis.tables.published import POSITIONS, STATISTICS, thesis_table
from ffgym.diagnosis.tables.simulated import TableSimulator
from ffgym.paths import RADII
from ffgym.robot import RigidArm, RobotDescription
from ffgym.robot.friction import LuGreParameters
from ffgym.robot.reading.load import with_numbers
from ffgym.simulation.plant import Machine
from ffgym.workcell.reading import build
from scripts.workcell.free import Calibration, Trees, applied, table_at

SPEEDS = (0.010, 0.040)


@dataclass(frozen=True, kw_only=True, eq=False)
class Candidate:
    """Machine of a workcell, and what its controller knows."""

    machine: Machine
    known: LuGreParameters


class Objective:
    """Residuals as a function of the free numbers; candidates are simulated side by side."""

    def __init__(self, calibration: Calibration, nominal: RobotDescription, prior: Trees, n_threads: int) -> None:
        self.calibration, self.nominal, self.prior = calibration, nominal, prior
        assert nominal.sensors is not None  # both nominal robots have a tracker
        noise = table_at(prior["machine"], "sensors.tracker_noise")["value"]
        seen = replace(nominal, sensors=replace(nominal.sensors, tracker_noise=np.float64(noise)))
        table = thesis_table()
        fitted = replace(table, rows=tuple(sorted((row for row in table.rows if row.use == "fitted"), key=_cell)))
        self._simulator = TableSimulator(fitted, seen, n_threads=n_threads)
        shape = (len(STATISTICS), len(KNOWN_LAWS), len(SPEEDS), len(POSITIONS), len(RADII))
        self.published = fitted.values.reshape(shape)
        """Path errors [mm], shape (2, L, V, P, R): RMS and largest, law, speed, position, radius."""

    def candidate(self, x: Array) -> Candidate:
        """The workcell with free numbers `x` (K,), and the friction that its controller knows."""
        trees = applied(self.calibration, self.prior, x)
        cell = build("candidate", trees["machine"], RigidArm(with_numbers(self.nominal, trees["controller"])))
        return Candidate(machine=cell.machine, known=cell.robot.friction)

    def sizes(self, candidates: Sequence[Candidate]) -> Array:
        """Simulated path errors [mm], shape (C, 2, L, V, P, R), as the tracker with its noise would give them."""
        values = self._simulator.values(candidates, self._simulator.table.rows, SEARCH_DT)
        return values.reshape(len(candidates), *self.published.shape)

    def residuals(self, x: Array, sizes: Array) -> Array:
        """Misfit and distance from the prior of free numbers `x` (..., K), (..., M + K)."""
        is_rms = np.arange(len(STATISTICS)) == STATISTICS.index("rms")
        each = np.broadcast_to(is_rms[:, None, None, None, None], self.published.shape)
        misfit = weigh_logs(sizes, self.published, each).reshape(*x.shape[:-1], -1)
        return np.concatenate([misfit, x / self.calibration.spread], axis=-1)

    def evaluate(self, xs: Array) -> list[tuple[Array, Array]]:
        """Path errors, and residuals, of candidates with free numbers `xs` (C, K)."""
        sizes = self.sizes([self.candidate(x) for x in xs])
        return list(zip(sizes, self.residuals(xs, sizes), strict=True))

    @property
    def descent(self) -> Descent:
        """The search."""
        steps = [
            STEP * free.spread if free.added_to is not None else min(LARGEST_STEP, STEP * free.spread)
            for free in self.calibration.free
        ]
        return Descent(
            evaluate=self.evaluate,
            steps=np.array(steps),
            spread=self.calibration.spread,
            clip=self.calibration.clip,
        )


def _cell(row: TableRow) -> tuple[int, int, float, str, float]:
    """Place of a row among the published path errors."""
    key = row.motion
    return (
        STATISTICS.index(row.statistic),
        KNOWN_LAWS.index(row.law),
        key.speed_mm_s,
        key.position,
        row.radius_mm,
    )


def search(objective: Objective, steps: int, state: Path, tell: Callable[[int, Point], None]) -> Point:
    """Lower the objective from where the `state` file stands, or from the prior, and keep it up to date.

    Raises:
        FFGymError: if the state file is of other free numbers.
    """
    names = [free.name for free in objective.calibration.free]
    begun = {}
    if state.exists():
        saved = json.loads(read_text(state))
        if list(saved["x"]) != names:
            raise FFGymError(f"{state} is of other free numbers; give another file to begin anew.")
        begun = {"x": list(saved["x"].values()), "damping": saved["damping"]}

    def keep(point: Point) -> None:
        write_json(state, {"x": dict(zip(names, point.x.tolist(), strict=True)), "damping": point.damping})
        tell(point.steps, point)

    return objective.descent.search(np.zeros((1, len(names))), steps, keep, begun)
