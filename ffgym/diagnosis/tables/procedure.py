"""Diagnosis from a table: fit every structure, then pairs of the best; rank, judge, separate."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.executors import Executor
from ffgym.core.files import filled_folder
from ffgym.core.temporaries import scratch_folder
from ffgym.diagnosis.tables.error_table import ErrorTable
from ffgym.diagnosis.tables.fitting import FitTask, fit_structure
from ffgym.diagnosis.tables.known_laws import KNOWN_LAWS
from ffgym.diagnosis.tables.parts import PARTS, SINGLE, find_structure
from ffgym.diagnosis.tables.problem import SEARCH_DT
from ffgym.diagnosis.tables.ranking import RankedStructure, rank_structures
from ffgym.diagnosis.tables.separating import SESSIONS, SeparatingSession, find_separating_sessions
from ffgym.diagnosis.tables.simulated import Learn
from ffgym.diagnosis.tables.structure_fit import LeftOutBy, StructureFit
from ffgym.diagnosis.tables.structures import extends
from ffgym.diagnosis.tables.verdict import TableVerdict, judge_structures, write_sentence
from ffgym.robot import ModelOptions, load_robot
from ffgym.simulation.plant import Machine

STEPS = 8
"""Default for the most steps of a search: the last of them changed the cost by less than 1 % on the thesis' table."""

BEST = 3
"""Structures whose pairs are fitted; chosen."""

Report = Callable[[str, float], None]
"""Called with what was done, and the share of the work that is done."""


@dataclass(frozen=True, kw_only=True)
class TableDiagnosis:
    """Result of a diagnosis from a table."""

    verdict: TableVerdict
    sentence: str
    """The verdict in one sentence."""
    structure: str
    """Structure with fewest free numbers among those that no other beats for certain."""
    ties: tuple[str, ...]
    """Structures that the best one does not beat for certain, the best first."""
    ranked: tuple[RankedStructure, ...]
    """All structures, the best first."""
    sessions: tuple[SeparatingSession, ...]
    """Sessions in which the best structure and its first rival differ, the most separating first."""
    table: ErrorTable
    seed: int
    steps: int
    """Most steps of each search."""
    fingerprint: str
    """Fingerprint of the physics of the robot as described."""
    origin: dict[str, Any] = field(default_factory=dict)
    """Command and inputs, if a command made it."""


def diagnose_table(
    table: ErrorTable,
    *,
    structures: Sequence[str] = (),
    pairs: bool = True,
    folder: Path | None = None,
    executor: Executor | None = None,
    steps: int = STEPS,
    seed: int = 0,
    left_out_by: LeftOutBy = "refit",
    learn: Learn | None = None,
    report: Report = lambda text, share: None,
    search_dt: float = SEARCH_DT,
    judge_dt: float | None = None,
    sessions: Sequence[str] = SESSIONS,
) -> TableDiagnosis:
    """Fit structures to a table of path errors, and judge which of them explains rows that it was not fitted to.

    Args:
        table: measured path errors.
        structures: names of structures; none given is all of one part.
        pairs: also fit pairs of the best three.
        folder: place of the state files, one for each structure: a diagnosis goes on where it was, also after kill -9.
        executor: this machine's cores by default, or a Ray cluster.
        steps: most steps of each search.
        seed: of the resamples behind intervals and ties.
        left_out_by: fit that predicts the rows of a place that is left out: a search of its own, or one step.
        learn: function that makes laws that learn; needed if a row has one, see `ffgym.agents.table_laws`.
        report: called with what was done, and the share of the work that is done.
        search_dt: physics step of the searches [s].
        judge_dt: physics step of the judgement [s]; None is the robot's own.
        sessions: names of sessions that may separate the best structure from its first rival.

    Raises:
        FFGymError: if a structure is unknown, a row cannot be simulated, or a state file is of something else.
    """
    names = list(dict.fromkeys(find_structure(name).name for name in structures or SINGLE))
    learning = {row.law for row in table.rows} - set(KNOWN_LAWS)
    if learning and learn is None:
        raise FFGymError(f"Laws {sorted(learning)} learn on the machine; give `learn`, or leave their rows out.")
    for row in table.rows:
        if row.use == "fitted" and row.law in learning:
            raise FFGymError(
                f"Fitted row {row.cell} of {table.title!r} has law {row.law!r}, must be {', '.join(KNOWN_LAWS)}; "
                f"laws that learn are trained in models that are fitted already: write 'held_out' into 'use'."
            )
    n_pairs = BEST * (BEST - 1) // 2 if pairs else 0
    with scratch_folder() if folder is None else filled_folder(folder) as place:
        task = partial(
            FitTask,
            table=table,
            folder=place,
            steps=steps,
            left_out_by=left_out_by,
            learn=learn,
            search_dt=search_dt,
            judge_dt=judge_dt,
        )
        fits = _fit([task(name=name) for name in names], executor, report, 0, len(names) + n_pairs)
        if pairs:
            more = [task(name=name, starts=_starts(name, fits)) for name in _pairs(table, fits, seed)]
            fits += _fit(more, executor, report, len(names), len(names) + n_pairs)
    return conclude(table, fits, steps=steps, seed=seed, sessions=sessions)


def conclude(
    table: ErrorTable,
    fits: Sequence[StructureFit],
    *,
    steps: int = STEPS,
    seed: int = 0,
    sessions: Sequence[str] = SESSIONS,
) -> TableDiagnosis:
    """Rank fitted structures, judge them, and find what separates the best from its first rival.

    Args:
        table: what they were fitted to.
        fits: one or more.
        steps: most steps of each search.
        seed: of the resamples behind intervals and ties.
        sessions: names of sessions that may separate the best structure from its first rival.

    Raises:
        FFGymError: if a fitted structure could not be simulated.
    """
    for fit in fits:
        if failed := [row for row, mm in zip(table.rows, fit.predicted_mm, strict=True) if not np.isfinite(mm)]:
            raise FFGymError(
                f"Structure {fit.name!r} as fitted cannot be simulated: {len(failed)} of {len(table.rows)} rows have "
                f"no error, first {failed[0].cell} with law {failed[0].law!r}. Leave out this structure, or these rows."
            )
    ranked = rank_structures(table, fits, seed)
    verdict, best = judge_structures(ranked)
    found = _separate(table, ranked, best, sessions)
    return TableDiagnosis(
        verdict=verdict,
        sentence=write_sentence(verdict, best, ranked),
        structure=best,
        ties=tuple(one.fit.name for one in ranked if one.is_tied),
        ranked=tuple(ranked),
        sessions=tuple(found),
        table=table,
        seed=seed,
        steps=steps,
        fingerprint=Machine.of(load_robot(table.robot)).physics(ModelOptions(looks=False)),
    )


def _fit(
    tasks: Sequence[FitTask], executor: Executor | None, report: Report, before: int, total: int
) -> list[StructureFit]:
    """Fit structures side by side; report each that is done."""
    fits: dict[int, StructureFit] = {}
    for i, fit in (executor or Executor()).run(fit_structure, tasks):
        fits[i] = fit
        report(f"{fit.name}: cost {fit.cost:.1f}", (before + len(fits)) / total)
    return [fits[i] for i in range(len(tasks))]


def _pairs(table: ErrorTable, fits: Sequence[StructureFit], seed: int) -> list[str]:
    """Name pairs of the best structures of one part."""
    ranked = rank_structures(table, fits, seed)
    best = [one.fit.name for one in ranked if one.fit.name in PARTS and one.fit.name != "numbers"][:BEST]
    have = {fit.name for fit in fits}
    order = list(PARTS)
    named = ["+".join(sorted(pair, key=order.index)) for pair in combinations(best, 2)]
    return [name for name in named if name not in have]


def _starts(name: str, fits: Sequence[StructureFit]) -> tuple[tuple[tuple[str, float], ...], ...]:
    """Collect starts of the search of a structure: fits of its parts, with the other part typical or weak.

    Weak is two spreads below typical, where most effects are small.
    """
    numbers = find_structure(name).numbers
    parts = [dict(fit.start) for fit in fits if fit.name in name.split("+")]
    weak = {number.name: -2.0 * number.spread for number in numbers}
    return tuple(tuple(start.items()) for part in parts for start in (part, weak | part))


def _separate(
    table: ErrorTable, ranked: Sequence[RankedStructure], best: str, sessions: Sequence[str]
) -> list[SeparatingSession]:
    """Find sessions that separate the best structure from the first that is no extension of it."""
    first = next(one for one in ranked if one.fit.name == best)
    fitted = [one for one in ranked if one.fit.free_parameters and one is not first]
    others = [one for one in fitted if not extends(one.fit.name, best)]
    if not others or not first.fit.free_parameters:
        return []
    return find_separating_sessions(load_robot(table.robot), first.fit, others[0].fit, sessions)
