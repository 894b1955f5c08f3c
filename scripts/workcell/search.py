"""Search of the calibration: what it lowers, and damped Gauss-Newton with finite differences.

Lowered are logarithms of simulated over published path errors, and distances from the prior. All columns of a Jacobian
are simulated side by side, in batches.
"""

import json
from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass
from itertools import product
from pathlib import Path

import numpy as np

from ffgym.control import DynamicLuGreExact, FeedForwardLaw, NoCompensation, StaticLuGre
from ffgym.core.errors import FFGymError
from ffgym.core.files import read_text, write_json
from ffgym.core.types import Array
from ffgym.paths import RADII, Reference
from ffgym.published import published_mm
from ffgym.recordings.metrics import path_errors
from ffgym.robot import ModelOptions, RigidArm, RobotDescription
from ffgym.robot.friction import LuGreParameters
from ffgym.robot.reading.load import with_numbers
from ffgym.simulation import Run, simulate
from ffgym.studies import circle_references
from ffgym.workcell import Workcell
from ffgym.workcell.reading import build
from scripts.workcell.free import Calibration, Trees, applied, table_at

SPEEDS = (0.010, 0.040)
LAWS = ("none", "lugre_static", "lugre_dynamic")
STATISTICS = ("rms", "max")

RMS_SPREAD = 0.2
"""Chosen: a simulated RMS error that is off by 20 % costs as much as a free number that is off by its spread."""
MAX_SPREAD = 0.4
"""Chosen: largest errors hang on single events, and weigh a quarter."""
SEEN_MAX = 3.0
"""Largest of thousands of samples of noise, in standard deviations, as far as it adds up with an error in squares."""

SEARCH_DT = 0.001
"""Physics step of the search [s]: a quarter of the time, and errors that differ by 1 % (median)."""

_BATCH = 8
"""Candidates simulated side by side; chosen: their recordings fit into 1 GB."""
_STEP = 0.2
"""Step of finite differences, in spreads; chosen: far above the noise of stick-slip, below where the model bends."""
_LARGEST_STEP = 0.05
"""Largest step of factors, whatever their spread."""
_DAMPINGS = (0.03, 0.1, 0.3, 1.0, 3.0, 10.0)
"""Factors on the damping of the last step that are tried."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Played(FeedForwardLaw):
    """A law whose torques are known already."""

    torques: dict[int, Array]
    """Torques by `id` of the reference [N m], shape (T, N) each."""
    name: str = "played"

    def torque(self, reference: Reference) -> Array:
        """Return the torque of the commissioned feed-forward along a reference."""
        return self.torques[id(reference)]


class Objective:
    """Residuals as a function of the free numbers; candidates are simulated side by side."""

    def __init__(self, calibration: Calibration, nominal: RobotDescription, prior: Trees, n_threads: int) -> None:
        self.calibration, self.nominal, self.prior, self._n_threads = calibration, nominal, prior, n_threads
        self.arm = RigidArm(nominal)
        self._noise = table_at(prior["machine"], "sensors.tracker_noise")["value"]
        self.references = circle_references(self.arm, speeds=SPEEDS)
        self.positions = tuple(dict.fromkeys(position for position, _ in self.references))
        shape = (len(STATISTICS), len(LAWS), len(SPEEDS), len(self.positions), len(RADII))
        cells = product(STATISTICS, LAWS, SPEEDS, self.positions, RADII)
        values = [published_mm(law, statistic, speed, radius, place) for statistic, law, speed, place, radius in cells]
        self.published = np.array(values, dtype=np.float64).reshape(shape)
        """Path errors [mm], shape (2, L, V, P, R): RMS and largest, law, speed, position, radius."""
        self._torques: dict[tuple[str, bytes], dict[int, Array]] = {}

    def candidate(self, x: Array) -> Workcell:
        """The workcell with free numbers `x` (K,), and the friction that its controller knows."""
        trees = applied(self.calibration, self.prior, x)
        return build("candidate", trees["machine"], RigidArm(with_numbers(self.nominal, trees["controller"])))

    def sizes(self, candidates: Sequence[Workcell]) -> Array:
        """Simulated path errors [mm], shape (C, 2, L, V, P, R), as the tracker with its noise would give them."""
        sizes = np.empty((len(candidates), *self.published.shape))
        for v, speed in enumerate(SPEEDS):  # motions of one length run side by side
            cells = list(product(range(len(candidates)), range(len(LAWS)), range(len(self.positions))))
            runs = [
                Run(
                    reference=self.references[self.positions[p], speed],
                    law=self._law(candidates[c].robot.friction, LAWS[k]),
                )
                for c, k, p in cells
            ]
            recordings = simulate(
                runs,
                arm=self.arm,
                machine=[candidates[c].machine for c, _, _ in cells],
                options=ModelOptions(looks=False, physics_dt=SEARCH_DT),
                record_dt=self.nominal.servo.control_dt,
                n_threads=self._n_threads,
            )
            for (c, k, p), recording in zip(cells, recordings, strict=True):
                errors, noise = path_errors(recording), self._noise
                sizes[c, 0, k, v, p] = 1e3 * np.hypot([error.rms for error in errors], noise)
                sizes[c, 1, k, v, p] = 1e3 * np.hypot([error.max for error in errors], SEEN_MAX * noise)
        return sizes

    def _law(self, known: LuGreParameters, name: str) -> FeedForwardLaw:
        """The law with the friction that the controller knows; most candidates share theirs, so torques are kept."""
        if name == "none":
            return NoCompensation()
        key = (name, np.concatenate([part for part in astuple(known) if part is not None]).tobytes())
        if key not in self._torques:
            law = StaticLuGre(known) if name == "lugre_static" else DynamicLuGreExact(known)
            self._torques[key] = {id(r): law.torque(r) for r in self.references.values()}
        return Played(name=name, torques=self._torques[key])

    def forget(self) -> None:
        """Drop torques of candidates that are done with."""
        self._torques.clear()

    def misfit(self, sizes: Array) -> Array:
        """Logarithms of simulated over published in units of their spreads, (..., M), of sizes (..., 2, L, V, P, R)."""
        logs = np.log(sizes / self.published)
        weighted = np.concatenate([logs[..., :1, :, :, :, :] / RMS_SPREAD, logs[..., 1:, :, :, :, :] / MAX_SPREAD], -5)
        return weighted.reshape(*sizes.shape[:-5], -1)

    def residuals(self, x: Array, sizes: Array) -> Array:
        """Misfit and distance from the prior of free numbers `x` (..., K), (..., M + K)."""
        return np.concatenate([self.misfit(sizes), x / self.calibration.spread], axis=-1)


@dataclass(frozen=True, kw_only=True, eq=False)
class Point:
    """Free numbers, what they give, and what it costs."""

    x: Array
    sizes: Array
    """[mm], shape (2, L, V, P, R)."""
    residuals: Array
    damping: float

    @property
    def cost(self) -> float:
        """Sum of squared residuals."""
        return float(self.residuals @ self.residuals)


def search(objective: Objective, steps: int, state: Path, tell: Callable[[int, Point], None]) -> Point:
    """Lower the objective from where the `state` file stands, or from the prior, and keep it up to date.

    Raises:
        FFGymError: if the state file is of other free numbers.
    """
    names = [free.name for free in objective.calibration.free]
    x, damping = np.zeros(len(names)), 1.0
    if state.exists():
        saved = json.loads(read_text(state))
        if list(saved["x"]) != names:
            raise FFGymError(f"{state} is of other free numbers; give another file to begin anew.")
        x, damping = np.array(list(saved["x"].values())), saved["damping"]
    point = _points(objective, x[None], np.array([damping]))[0]
    tell(0, point)
    for step in range(steps):
        better = _better(objective, point)
        objective.forget()
        if better is None:
            break
        point = better
        write_json(state, {"x": dict(zip(names, point.x.tolist(), strict=True)), "damping": point.damping})
        tell(step + 1, point)
    return point


def _points(objective: Objective, xs: Array, damping: Array) -> list[Point]:
    points = []
    for start in range(0, len(xs), _BATCH):
        some = xs[start : start + _BATCH]
        sizes = objective.sizes([objective.candidate(x) for x in some])
        points += [
            Point(x=x, sizes=size, residuals=objective.residuals(x, size), damping=float(d))
            for x, size, d in zip(some, sizes, damping[start : start + _BATCH], strict=True)
        ]
    return points


def _better(objective: Objective, point: Point) -> Point | None:
    """The best of several steps; None if none is better."""
    free, spread = objective.calibration.free, objective.calibration.spread
    steps = np.array(
        [_STEP * f.spread if f.added_to is not None else min(_LARGEST_STEP, _STEP * f.spread) for f in free]
    )
    shifted = _points(objective, point.x + np.diag(steps), np.full(len(steps), point.damping))
    jacobian = np.stack([(p.residuals - point.residuals) / h for p, h in zip(shifted, steps, strict=True)], axis=1)
    normal, slope = jacobian.T @ jacobian, jacobian.T @ point.residuals
    dampings = point.damping * np.array(_DAMPINGS)
    moves = [np.linalg.solve(normal + d * np.diag(spread**-2), slope) for d in dampings]
    tries = [objective.calibration.clip(point.x - move) for move in moves]
    best = min(_points(objective, np.array(tries), dampings), key=lambda p: p.cost)
    return best if best.cost < point.cost else None
