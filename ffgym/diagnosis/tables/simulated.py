"""Path errors of candidates, which are simulated side by side on the motions of a table with the laws of its rows."""

from collections.abc import Callable, Sequence
from itertools import product
from typing import Protocol

import numpy as np

from ffgym.control import FeedForwardLaw
from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.diagnosis.tables.error_table import ErrorTable, MotionKey, TableRow
from ffgym.diagnosis.tables.known_laws import KNOWN_LAWS, LawCache
from ffgym.paths import Reference, cartesian_reference, circle_test, load_motion
from ffgym.recordings import Recording
from ffgym.recordings.metrics import contour_errors, path_errors
from ffgym.robot import ModelOptions, RigidArm, RobotDescription
from ffgym.robot.friction import LuGreParameters
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Machine

SEEN_MAX = 3.0
"""Largest of thousands of samples of noise, in standard deviations, as far as it adds up with an error in squares."""

Learn = Callable[[str, Machine, RigidArm, Sequence[Reference]], FeedForwardLaw]
"""Function that makes a law by its name: it learns on a machine along references, which are of the controller's arm."""

_BATCH = 8
"""Candidates simulated side by side; chosen: their recordings fit into 1 GB."""


class TableModel(Protocol):
    """Model that is simulated."""

    @property
    def machine(self) -> Machine:
        """The machine."""

    @property
    def known(self) -> LuGreParameters:
        """Friction that the laws of its controller are computed from."""


class TableSimulator:
    """Simulated path errors of the rows of a table.

    Raises:
        FFGymError: if the robot has no tool, or cannot make a motion of the table.
    """

    def __init__(self, table: ErrorTable, robot: RobotDescription, *, n_threads: int = 1) -> None:
        """Plan the motions of a table for a robot, whose rigid-body feed-forward all candidates have."""
        if robot.tool is None:
            raise FFGymError(
                f"Robot {robot.name!r} of the table {table.title!r} has no tool, so it has no path error; describe one "
                f"in the description of the robot."
            )
        self.table, self.robot, self._n_threads = table, robot, n_threads
        self.arm = RigidArm(robot)
        self.references = {key: self._plan(key) for key in table.motions}
        self._laws = LawCache([*self.references.values()])
        self._noise = 0.0 if robot.sensors is None else float(robot.sensors.tracker_noise) * 1e3

    def _plan(self, key: MotionKey) -> Reference:
        """Plan a motion; circles of all radii that the table has at that place and speed run in one motion."""
        if key.file:
            return load_motion(self.arm, str(self.table.motion_file(key))).reference
        radii = sorted({row.radius_mm * 1e-3 for row in self.table.rows if row.motion == key})
        area = self.robot.work_area
        if area is None:
            raise FFGymError(
                f"Robot {self.robot.name!r} has no work area, so position {key.position!r} is nowhere; name motion "
                f"files in the column 'motion'."
            )
        path_of_tool = circle_test(
            self.robot.position(key.position),
            key.speed_mm_s * 1e-3,
            radii=radii,
            normal=area.normal,
            dt=self.robot.servo.control_dt,
            name=key.title,
        )
        return cartesian_reference(self.arm, path_of_tool)

    def values(
        self,
        candidates: Sequence[TableModel],
        rows: Sequence[TableRow],
        physics_dt: float,
        learn: Learn | None = None,
    ) -> Array:
        """Simulate rows for candidates; errors as the tracker with its noise would give them [mm], shape (C, R).

        A candidate that cannot be simulated, as its servo is unstable, has errors that are not a number.

        Raises:
            FFGymError: if a row has a law that learns, and there is no `learn`.
        """
        found = np.full((len(candidates), len(rows)), np.nan)
        for start in range(0, len(candidates), _BATCH):
            some = candidates[start : start + _BATCH]
            found[start : start + _BATCH] = self._batch(some, rows, physics_dt, learn)
            self._laws.forget()
        return found

    def _batch(
        self, candidates: Sequence[TableModel], rows: Sequence[TableRow], physics_dt: float, learn: Learn | None
    ) -> Array:
        try:
            return self._simulate(candidates, rows, physics_dt, learn)
        except FFGymError:
            if len(candidates) == 1:
                return np.full((1, len(rows)), np.nan)
        return np.concatenate([self._batch([one], rows, physics_dt, learn) for one in candidates])

    def _simulate(
        self, candidates: Sequence[TableModel], rows: Sequence[TableRow], physics_dt: float, learn: Learn | None
    ) -> Array:
        found = np.full((len(candidates), len(rows)), np.nan)
        learned: dict[tuple[int, str, float], FeedForwardLaw] = {}
        pairs = list(dict.fromkeys((row.motion, row.law) for row in rows))
        machines = [candidate.machine for candidate in candidates]
        # motions of one length run side by side
        for length in sorted({len(self.references[key].t) for key, _ in pairs}):
            together = [(key, law) for key, law in pairs if len(self.references[key].t) == length]
            cells = list(product(range(len(candidates)), together))
            runs = []
            for c, (key, law) in cells:
                # one law for all motions of a speed
                which = (c, law, 0.0 if law in KNOWN_LAWS else key.speed_mm_s)
                if which not in learned:
                    learned[which] = self._law(law, key, candidates[c], learn)
                runs.append(Run(reference=self.references[key], law=learned[which]))
            recordings = simulate(
                runs,
                arm=self.arm,
                machine=[machines[c] for c, _ in cells],
                options=ModelOptions(looks=False, physics_dt=physics_dt),
                record_dt=self.robot.servo.control_dt,
                n_threads=self._n_threads,
            )
            for (c, pair), recording in zip(cells, recordings, strict=True):
                own = [r for r, row in enumerate(rows) if (row.motion, row.law) == pair]
                found[c, own] = self._errors(recording, [rows[r] for r in own])
        return found

    def _law(self, name: str, key: MotionKey, candidate: TableModel, learn: Learn | None) -> FeedForwardLaw:
        if name in KNOWN_LAWS:
            return self._laws.law(name, candidate.known)
        if learn is None:
            raise FFGymError(f"Law {name!r} learns on the machine; only {', '.join(KNOWN_LAWS)} need no learning.")
        # as in the thesis, at the first position, at the speed that is judged
        first = next(k for k in self.references if k.speed_mm_s == key.speed_mm_s)
        return learn(name, candidate.machine, self.arm, [self.references[first]])

    def _errors(self, recording: Recording, rows: Sequence[TableRow]) -> list[float]:
        """Compute the errors of rows of one recording [mm], with the noise of the tracker."""
        if rows[0].motion.file:
            whole = contour_errors(recording)[0]
            sizes = {(0.0, "rms"): whole.rms, (0.0, "max"): whole.max}
        else:
            sizes = {}
            for error in path_errors(recording):
                radius = round(error.radius * 1e3, 3)
                sizes |= {(radius, "rms"): error.rms, (radius, "max"): error.max}
        noise = {"rms": self._noise, "max": SEEN_MAX * self._noise}
        return [
            float(np.hypot(1e3 * sizes[round(row.radius_mm, 3), row.statistic], noise[row.statistic])) for row in rows
        ]
