"""Circle tests of every size and direction, for tests that ask the same of all of them."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from hypothesis import strategies as st

from ffgym.paths import CartesianPath, circle_test
from ffgym.recordings import Phase

STEP = 1e-3
"""Sample time in units of radius / speed: fine enough for finite differences."""


@dataclass(frozen=True)
class Motion:
    """A circle test and the numbers it was made from."""

    path: CartesianPath
    centre: np.ndarray
    radii: tuple[float, ...]
    speed: float
    normal: np.ndarray
    """Unit normal."""
    start_angle: float
    dwell: float

    @property
    def dt(self) -> float:
        return float(self.path.t[1])

    def circles(self) -> list[tuple[Phase, float]]:
        """Each circle's phase and radius."""
        phases = [phase for phase in self.path.phases if phase.kind == "circle"]
        return list(zip(phases, self.radii, strict=True))

    def inside(self, phase: Phase) -> np.ndarray:
        """Rows well inside a phase."""
        margin = 1e-9 * self.path.t[-1]
        return (self.path.t > phase.start + margin) & (self.path.t < phase.end - margin)


def motion(**changes: Any) -> Motion:
    """Circle test with plain numbers."""
    values = {"centre": (1.3, -0.2, 0.6), "radii": (0.003,), "speed": 0.04, "normal": (0, 0, 1), "start_angle": -1.0}
    values |= changes
    shortest = min(values["radii"]) / values["speed"]
    dwell = 0.1 * shortest
    path = circle_test(dwell=dwell, dt=STEP * shortest, **values)
    normal = np.asarray(values["normal"], dtype=float)
    return Motion(
        path=path,
        centre=np.asarray(values["centre"], dtype=float),
        radii=tuple(values["radii"]),
        speed=values["speed"],
        normal=normal / np.linalg.norm(normal),
        start_angle=values["start_angle"],
        dwell=dwell,
    )


def vectors(low: float, high: float) -> st.SearchStrategy[tuple[float, float, float]]:
    coordinate = st.floats(low, high)
    return st.tuples(coordinate, coordinate, coordinate)


def magnitudes(low: float, high: float) -> st.SearchStrategy[float]:
    """Positive numbers, every power of ten as likely as the next."""
    return st.floats(np.log(low), np.log(high)).map(lambda x: float(np.exp(x)))


@st.composite
def motions(draw: Any, n_radii: int = 2) -> Motion:
    """Circle tests over four powers of ten of size and speed, in any plane."""
    smallest = draw(magnitudes(1e-4, 1.0))
    factors = draw(st.lists(st.floats(1.0, 3.0), min_size=1, max_size=n_radii))
    return motion(
        centre=draw(vectors(-10.0, 10.0)),
        radii=tuple(smallest * np.array([1.0, *factors[1:]])),
        speed=draw(magnitudes(1e-3, 10.0)),
        normal=draw(vectors(-5.0, 5.0).filter(lambda v: np.linalg.norm(v) > 1e-3)),
        start_angle=draw(st.floats(-10.0, 10.0)),
    )
