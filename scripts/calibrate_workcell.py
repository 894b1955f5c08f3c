"""Fit the workcell `thesis`, and the older friction that its controller knows, to the published path errors.

    python -m scripts.calibrate_workcell                 # half an hour on 2 cores; can be stopped, goes on where it was
    python -m scripts.calibrate_workcell --workcell thesis_arm --state arm.json     # with friction behind the springs
    python -m scripts.calibrate_workcell --steps 0       # writes the files of the state as it is
    python -m scripts.calibrate_workcell --table         # simulated beside all 240 published numbers; minutes
    python -m scripts.calibrate_workcell --table --fitted           # beside those that were fitted; trains no network

Objective: a maximum-a-posteriori estimate. The sum over 72 cells (10 and 40 mm/s x 3 radii x 4 positions x no, static
and dynamic LuGre compensation) of the squared logarithm of simulated over published RMS path error in units of
RMS_SPREAD, the same for the largest error in units of MAX_SPREAD, and the squared distance of each free number from its
prior in units of its spread (`scripts.workcell.free`). The published results of B-spline networks play no part: they
are the check that `--table` prints.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import tyro

from ffgym.core.errors import check_choice
from ffgym.core.files import write_json
from ffgym.diagnosis.fit.batches import Point
from ffgym.diagnosis.tables.known_laws import KNOWN_LAWS
from ffgym.robot import load_robot
from ffgym.workcell import workcell
from scripts.workcell.free import CALIBRATIONS, prior_trees, write_result
from scripts.workcell.search import SPEEDS, Objective, search
from scripts.workcell.table import measure_cells, summary, table


@dataclass(frozen=True)
class Config:
    """Calibration of the workcell."""

    workcell: str = "thesis"
    """Workcell to calibrate."""
    steps: int = 10
    """Largest number of Gauss-Newton steps."""
    state: Path = Path("workcell_state.json")
    """File that keeps the free numbers between steps; a search goes on from an existing file."""
    table: bool = False
    """Print simulated beside published numbers of the workcell that ships, and calibrate nothing."""
    fitted: bool = False
    """Leave laws out of the table that the calibration did not see, which are trained at first."""
    json: Path | None = None
    """Write the table's cells to this file."""
    threads: int = 0
    """Threads of the engine, 0 for all cores."""


def main(config: Config) -> dict[str, float]:
    """Calibrate, or print the table; returns what was reached."""
    if config.table:
        cells = measure_cells(workcell(config.workcell), config.threads, print, trained=not config.fitted)
        print(table(cells))
        reached = summary(cells)
        for name, value in reached.items():
            print(f"median of |ln(simulated / published)|, {name}: {value:.3f}")
        if config.json is not None:
            write_json(config.json, {"summary": reached, "cells": [vars(cell) for cell in cells]})
        return reached
    calibration = CALIBRATIONS[check_choice("workcell", config.workcell, list(CALIBRATIONS))]
    nominal = load_robot(calibration.nominal)
    objective = Objective(calibration, nominal, prior_trees(calibration, nominal), config.threads)

    def tell(step: int, point: Point) -> None:
        off = np.abs(np.log(point.outcome / objective.published))
        by_law = np.median(off[0].reshape(len(KNOWN_LAWS) * len(SPEEDS), -1), axis=1).round(2)
        prior = float(((point.x / calibration.spread) ** 2).sum())
        print(f"step {step}: cost {point.cost:.1f}, prior {prior:.1f}, median of rms {np.median(off[0]):.3f} {by_law}")

    found = search(objective, config.steps, config.state, tell)
    for free, x in zip(calibration.free, found.x, strict=True):
        print(f"  {free.name:40s} {x:7.3f}  ({x / free.spread:5.2f} spreads)")
    write_result(calibration, objective.prior, found.x)
    return {"cost": found.cost, "median": float(np.median(np.abs(np.log(found.outcome[0] / objective.published[0]))))}


if __name__ == "__main__":
    main(tyro.cli(Config))
