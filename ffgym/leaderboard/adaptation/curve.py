"""Curve of adaptation: the error left over seconds of robot time, with its interval over machines."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.leaderboard.adaptation.results import AdaptationRun
from ffgym.leaderboard.comparison.statistics import Interval, draw_resamples, interval, resample_means

BASELINE = "none"
"""Adapter whose error is the whole."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CurvePoint:
    """Error left of one adapter at one budget, as a share of the error without compensation."""

    adapter: str
    budget_s: float
    """[s]."""
    machines: tuple[str, ...]
    left: float
    """Geometric mean over motions, seeds and machines."""
    spread: Interval | None
    """Interval over machines, and over seeds where there are several; None for one of both."""
    by_machine: Array
    """Geometric mean over motions and seeds of each machine."""
    worst: float
    """Largest error left on any motion of any machine and seed."""


def curve(runs: Sequence[AdaptationRun], adapter: str, machines: Sequence[str]) -> list[CurvePoint]:
    """Compute the curve of an adapter on machines, by budget; budgets that lack a machine have those that are there.

    Machines are in the order of their names, so that intervals, which are resampled, do not depend on that of the call.

    Raises:
        FFGymError: if a machine has no error without compensation.
    """
    whole = {run.machine: _errors(run) for run in runs if run.adapter == BASELINE}
    own = [run for run in runs if run.adapter == adapter and run.machine in machines]
    points = []
    for laps in sorted({run.laps for run in own}):
        found = {(run.machine, run.seed): run for run in own if run.laps == laps}
        names = tuple(name for name in sorted(machines) if any(machine == name for machine, _ in found))
        seeds = sorted({seed for _, seed in found})
        for name in names:
            if name not in whole:
                raise FFGymError(f"Machine {name!r} has no result without compensation: run the adapter {BASELINE!r}.")
        complete = [seed for seed in seeds if all((name, seed) in found for name in names)]
        logs = np.array([[np.log(_errors(found[name, s]) / whole[name]) for name in names] for s in complete])
        by = draw_resamples(adapter, len(complete), len(names))
        spread = interval(resample_means(logs, by), by.levels)
        points.append(
            CurvePoint(
                adapter=adapter,
                budget_s=next(run.budget_s for run in found.values()),
                machines=names,
                left=float(np.exp(logs.mean())),
                spread=None if spread is None else Interval(float(np.exp(spread.low)), float(np.exp(spread.high))),
                by_machine=np.exp(logs.mean(axis=(0, 2))),
                worst=float(np.exp(logs.max())),
            )
        )
    return points


def _errors(run: AdaptationRun) -> Array:
    """Errors on the scored motions [um]; one that was not run to its end is infinite."""
    return np.array([np.inf if each is None else each for each in run.rms_um])
