"""What the calibration lowers: logarithms of simulated over published path errors, and distances from the prior."""

from collections.abc import Sequence
from dataclasses import astuple, dataclass
from itertools import product

import numpy as np

from ffgym.control import DynamicLuGreExact, FeedForwardLaw, NoCompensation, StaticLuGre
from ffgym.core.types import Array
from ffgym.paths import RADII, Reference
from ffgym.published import published_mm
from ffgym.recordings import Recording
from ffgym.recordings.metrics import path_errors
from ffgym.robot import ModelOptions, RigidArm, RobotDescription
from ffgym.robot.friction import LuGreParameters
from ffgym.robot.reading.load import with_numbers
from ffgym.simulation import Run, simulate
from ffgym.studies import circle_references
from ffgym.workcell import Workcell
from ffgym.workcell.reading import build
from scripts.workcell.free import SPREAD, Trees, applied, table_at

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


@dataclass(frozen=True, kw_only=True, eq=False)
class Played(FeedForwardLaw):
    """A law whose torques are known already."""

    torques: dict[int, Array]
    """By `id` of the reference [N m], shape (T, N) each."""
    name: str = "played"

    def torque(self, reference: Reference) -> Array:
        """See base class."""
        return self.torques[id(reference)]


class Objective:
    """Residuals as a function of the free numbers; candidates are simulated side by side."""

    def __init__(self, nominal: RobotDescription, prior: Trees, n_threads: int) -> None:
        self.nominal, self.prior, self._n_threads = nominal, prior, n_threads
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
        trees = applied(self.prior, x)
        return build("candidate", trees["machine"], RigidArm(with_numbers(self.nominal, trees["controller"])))

    def sizes(self, candidates: Sequence[Workcell]) -> Array:
        """Simulated path errors [mm], shape (C, 2, L, V, P, R), as the tracker with its noise would give them."""
        sizes = np.empty((len(candidates), *self.published.shape))
        for v, speed in enumerate(SPEEDS):  # motions of one length run side by side
            cells = list(product(range(len(candidates)), range(len(LAWS)), range(len(self.positions))))
            runs = [self._run(candidates[c].robot.friction, LAWS[k], self.positions[p], speed) for c, k, p in cells]
            recordings = simulate(
                runs,
                arm=self.arm,
                machine=[candidates[c].machine for c, _, _ in cells],
                options=ModelOptions(looks=False, physics_dt=SEARCH_DT),
                record_dt=self.nominal.servo.control_dt,
                n_threads=self._n_threads,
            )
            for (c, k, p), recording in zip(cells, recordings, strict=True):
                sizes[c, :, k, v, p] = _measured(recording, self._noise)
        return sizes

    def _run(self, known: LuGreParameters, law: str, position: str, speed: float) -> Run:
        return Run(reference=self.references[position, speed], law=self._law(known, law))

    def _law(self, known: LuGreParameters, name: str) -> FeedForwardLaw:
        """The law with the friction that the controller knows; most candidates share theirs, so torques are kept."""
        if name == "none":
            return NoCompensation()
        key = (name, np.concatenate(astuple(known)).tobytes())
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
        return np.concatenate([self.misfit(sizes), x / SPREAD], axis=-1)


def _measured(recording: Recording, noise: float) -> Array:
    """RMS and largest path errors [mm] with the tracker's noise [m] added in squares, shape (2, R)."""
    errors = path_errors(recording)
    rms = np.hypot([error.rms for error in errors], noise)
    largest = np.hypot([error.max for error in errors], SEEN_MAX * noise)
    return np.stack([rms, largest]) * 1e3
