"""Standings: scores, ranks and ties of all rows on one group of plants and one selection of circles."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from ffgym.core.errors import FFGymError, check_choice
from ffgym.leaderboard.comparison.samples import (
    DRAWS,
    SELECTIONS,
    WORKCELLS,
    Grid,
    collect_grid,
    collect_sample,
    explain_lack,
    group_of,
)
from ffgym.leaderboard.comparison.scores import Difference, Score, ScoredRow, compare_rows, compute_score
from ffgym.leaderboard.results import Row
from ffgym.leaderboard.tasks import HELD_OUT
from ffgym.report.laws import ORACLE, UNCOMPENSATED

SERVO_GAINS = ("servo_gains", "servo_gains_drives", "servo_gains_stable")
"""Rows of a linear feedback of three numbers, tuned on robots with ideal drives, on machines with real ones, and on
these under a stability requirement: a learned feedback that does not beat the best of them has gained what a servo
would, whether the loops are stable or not; of that, margins tell."""
_WORDS = {-1: "better than {}", 1: "worse than {}", 0: "not better: the interval includes zero"}


@dataclass(frozen=True, kw_only=True)
class AgainstBase:
    """A residual beside its base or servo gains, on circles held out from learning."""

    base: str
    """Row that it is compared with."""
    difference: Difference | None
    """Difference of the errors; None if one of both did not run."""
    sentence: str
    """'better than its base', 'worse than servo gains', 'not better: the interval includes zero', or why unknown."""

    @property
    def is_better(self) -> bool:
        """True if the interval shows that it is better."""
        return self.sentence.startswith("better")


@dataclass(frozen=True, kw_only=True)
class Standing:
    """One row in the standings."""

    row: Row
    score: Score
    rank: int | None
    """Rank among all rows; None if it is shown only."""
    track_rank: int | None
    """Rank among rows of the same track, knowledge and channel."""
    against_base: AgainstBase | None
    """Comparison with its base; None if it is no residual."""
    against_gains: AgainstBase | None
    """Comparison of a learned residual with servo gains; None if it is none, or they were not run."""
    unproven: str | None
    """Reason why chance was not measured, as 'one seed'; None if it was, or there is none."""


@dataclass(frozen=True, kw_only=True)
class Standings:
    """All rows on one group of plants and one selection of circles: ranked ones best first, then those shown only."""

    group: str
    selection: str
    grid: Grid
    lines: tuple[Standing, ...]
    missing: Mapping[str, str]
    """Reason why a row is left out, by its name."""

    @property
    def ranked(self) -> tuple[Standing, ...]:
        """Ranked rows, best first."""
        return tuple(line for line in self.lines if line.rank is not None)

    def line(self, name: str) -> Standing | None:
        """Find the line of a row by its name; return None if it is left out."""
        return next((line for line in self.lines if line.row.name == name), None)


def standings(rows: Sequence[Row], group: str, selection: str) -> Standings:
    """Compare rows; neither their order nor that of their results matters.

    A row that lacks a plant or a circle of the zero action's row is left out with the reason: a mean over fewer circles
    is another number.

    Args:
        rows: rows with different names, among them 'none', the zero action.
        group: group of plants, see `group_of`.
        selection: selection of circles, in SELECTIONS.

    Raises:
        FFGymError: if two rows have one name, the zero action was not run here or stopped, or a name is unknown.
    """
    splits = SELECTIONS[check_choice("selection of circles", selection, list(SELECTIONS))]
    by_name = {row.name: row for row in rows}
    if len(by_name) != len(rows):
        raise FFGymError("Two rows of the leaderboard have one name; names must differ. Remove one of their files.")
    if UNCOMPENSATED not in by_name:
        raise FFGymError(f"Standings need the zero action's row {UNCOMPENSATED!r}; run `ffgym leaderboard` for it.")
    # scores of complete rows, and reasons of the others
    grid, scored = _score_rows(by_name, group, splits)
    missing = {name: why for name, row in sorted(by_name.items()) if (why := explain_lack(row, grid))}
    zero = scored[UNCOMPENSATED].sample
    oracle = scored[ORACLE].sample if ORACLE in scored else None
    residuals = {name: row.base for name, row in by_name.items() if row.base is not None}
    against = _compare(by_name, group, residuals, "its base")
    gains = [scored[name] for name in SERVO_GAINS if name in scored]
    best = min(gains, key=lambda each: each.mean).row.name if gains else None
    learned = {name: best for name in residuals if name not in SERVO_GAINS} if best is not None else {}
    against_gains = _compare(by_name, group, learned, "servo gains")
    # ranks among all, and among those of one track, knowledge and channel
    best_first = sorted(scored.values(), key=lambda each: (each.mean, each.row.name))
    ranked = [each for each in best_first if _is_ranked(each.row)]
    ranks, within = rank_rows(ranked, compare_rows), {}
    for like in dict.fromkeys(map(_kind_of, ranked)):
        within.update(rank_rows([each for each in ranked if _kind_of(each) == like], compare_rows))
    lines = tuple(
        Standing(
            row=each.row,
            score=compute_score(each, grid, zero, oracle),
            rank=ranks.get(each.row.name),
            track_rank=within.get(each.row.name),
            against_base=against.get(each.row.name),
            against_gains=against_gains.get(each.row.name),
            unproven=_unproven(each, grid),
        )
        for each in (*ranked, *(each for each in best_first if not _is_ranked(each.row)))
    )
    return Standings(group=group, selection=selection, grid=grid, lines=lines, missing=missing)


def rank_rows(best_first: Sequence[ScoredRow], compare: Callable[[ScoredRow, ScoredRow], Difference]) -> dict[str, int]:
    """Rank rows by name: 1, 1, 3, 4, 4, ...

    The first row of a rank leads it. A row shares the rank of the leader before it if the interval of their difference
    includes zero; otherwise it leads the next rank, whose number is its place. Members of a rank are not equal; each is
    only not distinguished from its leader, and two neighbours on either side of a border may be as near to each other.
    """
    ranks: dict[str, int] = {}
    leader: ScoredRow | None = None
    for place, each in enumerate(best_first, start=1):
        if leader is not None and compare(leader, each).sign == 0:
            ranks[each.row.name] = ranks[leader.row.name]
        else:
            leader, ranks[each.row.name] = each, place
    return ranks


def _score_rows(by_name: Mapping[str, Row], group: str, splits: Sequence[str]) -> tuple[Grid, dict[str, ScoredRow]]:
    """Score all rows that are complete on the grid of the zero action's row."""
    grid = collect_grid(by_name[UNCOMPENSATED], group, splits)
    if not grid.cells:
        raise FFGymError(f"The zero action {UNCOMPENSATED!r} was not run on {group} with {', '.join(splits)}.")
    zero = collect_sample(by_name[UNCOMPENSATED], grid)
    if not (zero.rms < float("inf")).all():
        raise FFGymError(f"The robot stopped with zero action on {group}, so that nothing can be compared with it.")
    complete = [row for row in by_name.values() if explain_lack(row, grid) is None]
    return grid, {row.name: ScoredRow.of(row, collect_sample(row, grid), zero) for row in complete}


def _kind_of(scored: ScoredRow) -> tuple[bool, str, str]:
    """Return track, knowledge and channel of a row, within which like is compared with like."""
    return scored.row.feedback, scored.row.track, scored.row.channel


def _is_ranked(row: Row) -> bool:
    return row.ranked and row.name not in (UNCOMPENSATED, ORACLE)


def _unproven(scored: ScoredRow, grid: Grid) -> str | None:
    """Name the factor that did not vary, so that the effect of another seed or robot is unknown; None if both did."""
    if scored.row.seeded and len(scored.sample.seeds) == 1:
        return "one seed"
    one = {DRAWS: "one drawn robot", WORKCELLS: "one drawn workcell"}
    return one.get(group_of(grid.plants[0])) if len(grid.plants) == 1 else None


def _compare(
    by_name: Mapping[str, Row], group: str, residuals: Mapping[str, str], rival: str
) -> dict[str, AgainstBase]:
    """Compare rows with others, by their names, on all held-out circles that the zero action was run on.

    `rival` is what sentences call the others.
    """
    run = [split for split in HELD_OUT if collect_grid(by_name[UNCOMPENSATED], group, [split]).cells]
    scored: dict[str, ScoredRow] = {}
    if residuals and run:
        needed = {UNCOMPENSATED, *residuals, *residuals.values()}
        grid, scored = _score_rows({name: row for name, row in by_name.items() if name in needed}, group, run)
    found = {}
    for name, base in residuals.items():
        lost = [each for each in (name, base) if each not in scored]
        difference = None if lost else compare_rows(scored[name], scored[base])
        # sentence, from lack of data to the sign of the difference
        if not run:
            words = "unknown: zero action has no held-out circles here"
        elif difference is None:
            words = f"unknown: {lost[0]} has not run on all held-out circles here"
        elif (why := _unproven(scored[name], grid)) is not None:
            words = f"unknown: {why}"
        elif difference.interval is None and difference.sign == 0:
            words = f"not better: the same as {rival}"
        else:
            words = _WORDS[difference.sign].format(rival)
        found[name] = AgainstBase(base=base, difference=difference, sentence=words)
    return found
