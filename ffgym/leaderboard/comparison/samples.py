"""Samples: results of a row as arrays over seeds, plants and circles, and the completeness of rows."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeAlias

import numpy as np

from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.types import Array
from ffgym.leaderboard.plants import DRAW, DRAWN_WORKCELL, NOMINAL, THESIS_WORKCELL
from ffgym.leaderboard.results import CircleResult, Outcome, Row
from ffgym.leaderboard.tasks import HELD_OUT, SPLITS, THESIS

DRAWS = "draws"
"""Group of all drawn plants."""
WORKCELLS = "workcells"
"""Group of all workcells that are drawn by a seed."""
GROUPS = (WORKCELLS, THESIS_WORKCELL, NOMINAL, DRAWS)
"""Plants of the leaderboard, the most important first. Every other workcell is a group of its own."""
HEADLINED = GROUPS[:2]
"""Groups whose first one that was run is the headline: machines with equations that no agent has."""
SELECTIONS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {"held_out": HELD_OUT} | {split: (split,) for split in HELD_OUT} | {"thesis": THESIS, "train": SPLITS[:1]}
)
"""Splits of circles by the name of their selection; the most important first."""

CellKey: TypeAlias = tuple[str, str, float, float]
"""Split, position, radius [mm], speed [mm/s]."""


@dataclass(frozen=True, kw_only=True)
class Grid:
    """Plants and circles that rows are compared on."""

    plants: tuple[str, ...]
    cells: tuple[CellKey, ...]
    fingerprints: Mapping[str, str]
    """Fingerprints of the physics that the zero action met, by plant."""
    left_out: tuple[str, ...] = ()
    """Plants of the group where zero action lacks some of the circles."""

    @property
    def speeds_mm_s(self) -> tuple[float, ...]:
        """Speeds of the circles, slowest first."""
        return tuple(sorted({speed for *_, speed in self.cells}))

    def at(self, speed_mm_s: float) -> list[int]:
        """Find the indices of the circles at a speed."""
        return [k for k, (*_, speed) in enumerate(self.cells) if speed == speed_mm_s]


@dataclass(frozen=True, kw_only=True, eq=False)
class Sample:
    """Errors of a row over S seeds, P plants and C circles; infinite where the robot stopped."""

    seeds: tuple[int, ...]
    rms: Array
    """RMS in the plane of the circle [mm], shape (S, P, C)."""
    max: Array
    """Largest deviation in the plane [mm], shape (S, P, C)."""
    rms_3d: Array
    """RMS in space [mm], shape (S, P, C)."""
    motor: Array
    """RMS of each joint, motor side [rad], shape (S, P, C, N); N is 0 if the robot stopped everywhere."""


def group_of(plant: str) -> str:
    """Return the group of a plant in standings: drawn robots are one, drawn workcells another, others their own."""
    if plant.startswith(DRAW):
        return DRAWS
    return WORKCELLS if plant.startswith(DRAWN_WORKCELL) else plant


def groups_of(row: Row) -> list[str]:
    """List the groups that a row ran on: those of GROUPS in their order, then others by name."""
    found = {group_of(outcome.plant) for outcome in row.outcomes}
    return [*(group for group in GROUPS if group in found), *sorted(found - set(GROUPS))]


def outcomes_on(row: Row, grid: Grid) -> list[Outcome]:
    """List the outcomes of a row on the plants of a grid, by seed and plant."""
    return sorted((each for each in row.outcomes if each.plant in grid.plants), key=lambda each: each.key)


def collect_grid(row: Row, group: str, splits: Sequence[str]) -> Grid:
    """Collect the circles of some splits that a row ran on, and the plants where it ran on all of them.

    The grid is empty if the row lacks one of the splits altogether. Order of results in the row does not matter.
    """
    for split in splits:
        check_choice("split", split, SPLITS)
    outcomes = [outcome for outcome in row.outcomes if group_of(outcome.plant) == group]
    every = {cell.key for outcome in outcomes for cell in outcome.cells if cell.split in splits}
    if {split for split, *_ in every} < set(splits):
        return Grid(plants=(), cells=(), fingerprints={})
    part = {each.plant for each in outcomes if not every <= {cell.key for cell in each.cells}}
    whole = {each.plant: each.fingerprint for each in outcomes if each.plant not in part}
    cells = tuple(sorted(every)) if whole else ()
    return Grid(
        plants=tuple(sorted(whole)), cells=cells, fingerprints=MappingProxyType(whole), left_out=tuple(sorted(part))
    )


def explain_lack(row: Row, grid: Grid) -> str | None:
    """Explain what a row lacks to be compared on a grid; return None if it is complete."""
    outcomes = {outcome.key: outcome for outcome in outcomes_on(row, grid)}
    if not outcomes:
        return "not run on these plants"
    for seed in sorted({seed for seed, _ in outcomes}):
        for plant in grid.plants:
            if (seed, plant) not in outcomes:
                return f"seed {seed} was not run on plant {plant}"
            if outcomes[seed, plant].fingerprint != grid.fingerprints[plant]:
                return f"seed {seed} on plant {plant} met other physics than zero action"
            absent = set(grid.cells) - {cell.key for cell in outcomes[seed, plant].cells}
            if absent:
                return f"seed {seed} on plant {plant} lacks {len(absent)} of {len(grid.cells)} circles"
    return None


def collect_sample(row: Row, grid: Grid) -> Sample:
    """Collect the errors of a row on a grid; FFGymError if it is incomplete, or an error is not above 0."""
    why = explain_lack(row, grid)
    if why is not None:
        raise FFGymError(f"Row {row.name!r} cannot be compared: {why}. Run `ffgym leaderboard` for it again.")
    outcomes = outcomes_on(row, grid)
    seeds = tuple(sorted({outcome.seed for outcome in outcomes}))
    # results in the order of seeds, plants and circles
    cells: list[CircleResult] = []
    for outcome in outcomes:
        by_key = {cell.key: cell for cell in outcome.cells}
        cells += [by_key[key] for key in grid.cells]
    shape = (len(seeds), len(grid.plants), len(grid.cells))
    joints = max(len(cell.motor_rms_rad or ()) for cell in cells)

    def errors(values: Iterable[float | None]) -> Array:
        """Shape errors; a robot that stopped has infinite ones."""
        return np.reshape([np.inf if value is None or np.isnan(value) else value for value in values], shape)

    # errors by seed, plant and circle; that of a robot that stopped is infinite
    sample = Sample(
        seeds=seeds,
        rms=errors(cell.rms_mm for cell in cells),
        max=errors(cell.max_mm for cell in cells),
        rms_3d=errors(cell.rms_3d_mm for cell in cells),
        motor=np.reshape([cell.motor_rms_rad or (np.inf,) * joints for cell in cells], (*shape, joints)),
    )
    if not np.all(sample.rms > 0):
        raise FFGymError(f"Row {row.name!r}: RMS path error {sample.rms.min():g} mm must be > 0. Evaluate it again.")
    return sample
