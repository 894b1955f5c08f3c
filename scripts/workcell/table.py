"""Simulated beside published path errors: the 240 numbers of Tables 4.1, 4.2, 5.1 and 5.2 of the thesis."""

from collections.abc import Callable, Mapping, Sequence
from itertools import product

import numpy as np

from ffgym.agents.bspline import ExtendedBSN, StaticBSN
from ffgym.agents.lffc import thesis_training
from ffgym.agents.trials import RigTrial, training_motions
from ffgym.paths import RADII
from ffgym.published import METHODS, published_mm
from ffgym.studies import StudyCell, circle_study, thesis_laws
from ffgym.workcell import Workcell
from scripts.tables.page import markdown

SPEEDS = (0.010, 0.040)
FITTED = METHODS[:3]
"""Laws whose published errors the calibration saw; B-spline networks are the check."""

Say = Callable[[str], None]


def measure_cells(cell: Workcell, n_threads: int, say: Say, *, trained: bool = True) -> list[StudyCell]:
    """Circles with all laws of the thesis on a workcell, or with those that are not trained, as its tracker measures.

    Networks are trained on the workcell as in thesis 5.4: at p1, at the speed at which they are judged.
    """
    say("circles with no, static LuGre and dynamic LuGre compensation")
    cells = circle_study(cell, laws=thesis_laws(cell.robot), speeds=SPEEDS, n_threads=n_threads).cells
    trial, n = RigTrial(rig=cell, n_threads=n_threads), cell.robot.n_joints
    for speed in SPEEDS if trained else ():
        say(f"training both networks at p1, {speed * 1e3:g} mm/s")
        motions = training_motions(cell.arm, speeds=[speed])
        laws = [thesis_training(n).learn(kind.zero(n), motions, trial).best for kind in (StaticBSN, ExtendedBSN)]
        cells += circle_study(cell, laws=laws, speeds=[speed], n_threads=n_threads).cells
    return cells


def ratio(cell: StudyCell, statistic: str) -> float:
    """Simulated over published path error [1]."""
    simulated = cell.rms_mm if statistic == "rms" else cell.max_mm
    published = published_mm(cell.agent, statistic, cell.speed_mm_s * 1e-3, cell.radius_mm * 1e-3, cell.position)
    assert published is not None
    return simulated / published


def table(cells: Sequence[StudyCell]) -> str:
    """Markdown table of simulated / published [mm], one line per law, speed, statistic and radius."""
    positions = list(dict.fromkeys(cell.position for cell in cells))
    rows = []
    laws = [law for law in METHODS if any(cell.agent == law for cell in cells)]
    for law, speed, statistic, radius in product(laws, SPEEDS, ("rms", "max"), RADII):
        pairs = []
        for position in positions:
            key = (law, round(speed * 1e3, 6), round(radius * 1e3, 6), position)
            cell = next(each for each in cells if (each.agent, each.speed_mm_s, each.radius_mm, each.position) == key)
            simulated = cell.rms_mm if statistic == "rms" else cell.max_mm
            pairs.append(f"{simulated:.3f} / {simulated / ratio(cell, statistic):.3g}")
        rows.append((law, f"{speed * 1e3:g}", statistic, f"{radius * 1e3:g}", *pairs))
    return markdown(("law", "mm/s", "", "r [mm]", *positions), rows)


def summary(cells: Sequence[StudyCell]) -> dict[str, float]:
    """Median of |ln(simulated / published)| of the RMS errors that were fitted and of those kept out, and of maxima."""
    groups: Mapping[str, list[float]] = {
        f"{statistic}, {name}": [ratio(cell, statistic) for cell in cells if (cell.agent in FITTED) == fitted]
        for statistic in ("rms", "max")
        for name, fitted in (("fitted", True), ("kept out", False))
    }
    return {name: float(np.median(np.abs(np.log(values)))) for name, values in groups.items() if values}
