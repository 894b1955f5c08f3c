"""Sentences on standings, computed from them, and the published numbers of the thesis beside them."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import fsum, isfinite

from ffgym.envs.machines import is_workcell
from ffgym.leaderboard.comparison.samples import DRAWS, WORKCELLS, CellKey
from ffgym.leaderboard.comparison.standings import SERVO_GAINS, AgainstBase, Standing, Standings
from ffgym.leaderboard.plants import NOMINAL, find_plant
from ffgym.leaderboard.results import FEED_FORWARD, WITH_FEEDBACK
from ffgym.leaderboard.tasks import THESIS
from ffgym.paths import RADII, SPEEDS
from ffgym.published import METHODS, published_mm
from ffgym.report.circles.comparison import percent
from ffgym.report.laws import UNCOMPENSATED, law_styles
from ffgym.simulation import LaserTracker
from ffgym.studies import in_mm

_POSITIONS = ("p1", "p2", "p3", "p4")
"""Corners of the work area (thesis, 2.2.5)."""


@dataclass(frozen=True, kw_only=True)
class PublishedSpeed:
    """Mean of published RMS path errors at one speed."""

    speed_mm_s: float
    rms_um: float
    reduction: float
    """Reduction as a share of the mean without compensation on the same circles."""
    circles: int


@dataclass(frozen=True, kw_only=True)
class PublishedRow:
    """One method of the thesis on the real robot."""

    method: str
    title: str
    speeds: tuple[PublishedSpeed, ...]
    max_um: float | None
    """Largest published deviation; None if none was published."""


def list_published_rows(cells: Sequence[CellKey]) -> list[PublishedRow]:
    """List the methods of the thesis on the circles that it measured; empty if it measured none of them."""
    styles = law_styles(METHODS)
    rows = [
        PublishedRow(
            method=method,
            title=styles[method].label,
            speeds=_speeds(method, cells),
            max_um=max(
                (x * 1e3 for cell in cells if (x := _read_published(method, "max", cell)) is not None), default=None
            ),
        )
        for method in METHODS
    ]
    return [row for row in rows if row.speeds]


def best_reductions() -> dict[float, tuple[str, float]]:
    """Find the best published method and its reduction of the mean over all circles, by TCP speed [mm/s]."""
    cells = [(THESIS[0], p, in_mm(r), in_mm(v)) for v in SPEEDS for r in RADII for p in _POSITIONS]
    best: dict[float, tuple[str, float]] = {}
    for row in list_published_rows(cells):
        for each in row.speeds:
            if each.speed_mm_s not in best or each.reduction > best[each.speed_mm_s][1]:
                best[each.speed_mm_s] = (row.title, each.reduction)
    return best


def _speeds(method: str, cells: Sequence[CellKey]) -> tuple[PublishedSpeed, ...]:
    """Compute means of a method by speed, over the circles that were measured with and without it."""
    found = []
    for speed in sorted({speed for *_, speed in cells}):
        own = [cell for cell in cells if cell[3] == speed]
        pairs = [(_read_published(method, "rms", cell), _read_published(UNCOMPENSATED, "rms", cell)) for cell in own]
        known = [(value, zero) for value, zero in pairs if value is not None and zero is not None]
        if known:
            total, zero = fsum(value for value, _ in known), fsum(zero for _, zero in known)
            mean, n = total / len(known) * 1e3, len(known)
            found.append(PublishedSpeed(speed_mm_s=speed, rms_um=mean, reduction=1 - total / zero, circles=n))
    return tuple(found)


def _read_published(method: str, statistic: str, cell: CellKey) -> float | None:
    """Read the published error [mm] on a circle."""
    _, position, radius, speed = cell
    return published_mm(method, statistic, speed / 1e3, radius / 1e3, position)


SELECTION_TITLES: Mapping[str, str] = {
    "held_out": "held out: positions, radii, speeds",
    "positions": "held-out positions",
    "radii": "held-out radii",
    "speeds": "held-out speeds",
    "train": "where agents may learn",
    "thesis": "circles of the thesis",
}
"""Titles of the selections of circles."""
PRACTISED = "per task"
"""Track of agents that practise the very motion that is scored."""


def group_title(group: str) -> str:
    """Return the title of a group of plants."""
    kind, _, name = group.partition(":")
    titles = {NOMINAL: "nominal robot", DRAWS: "drawn robots", WORKCELLS: "drawn workcells"}
    return titles.get(group, f"{kind} “{name}”")


@dataclass(frozen=True, kw_only=True)
class Headline:
    """Best agent on the held-out positions of workcells, with its gain at each speed, beside the best of the thesis."""

    sentences: tuple[str, ...]
    speeds: tuple[float, ...] = ()
    """TCP speeds [mm/s]."""
    lines: tuple[tuple[str, str, tuple[str, ...]], ...] = ()
    """Agent, its knowledge, and the change of the mean RMS path error against no compensation at each speed."""


def headline(positions: Standings | None) -> Headline:
    """Write the headline from standings on held-out positions of workcells; None if they were not run."""
    if positions is None:
        return Headline(sentences=("The workcell's held-out positions have not been run yet.",))
    speeds = positions.grid.speeds_mm_s
    cells = "the workcell" if len(positions.grid.plants) == 1 else f"{len(positions.grid.plants)} drawn workcells"
    place = cells.removeprefix("the ")
    before = [line for line in positions.ranked if line.row.track != PRACTISED]
    after = [line for line in positions.ranked if line.row.track == PRACTISED]
    sentences, lines = [], []
    # best agents without practice, of all and of each track; with practice; then the thesis
    if before:
        best = before[0]
        ties = [line.row.title for line in before[1:] if line.rank == best.rank]
        shared = f", which shares its rank with {_join_words(ties)}," if ties else ""
        changes = [f"{each} at {speed:g} mm/s" for each, speed in zip(_changes(best), speeds, strict=True)]
        sentences.append(
            f"On {cells}, at positions without training, {best.row.title}{shared} leaves the least error of "
            f"all agents that have not practised the very motion: {_join_words(changes)} than without compensation."
        )
        for control in (FEED_FORWARD, WITH_FEEDBACK):
            first = next((line for line in before if line.row.control == control), None)
            if first is not None:
                lines.append((first.row.title, f"{control}, {place}, held-out positions", _changes(first)))
    if after:
        where = f"{after[0].row.control}, {place}, practised on the very motion"
        lines.append((after[0].row.title, where, _changes(after[0])))
    published = {speed: f"{percent(gone)} ({method})" for speed, (method, gone) in best_reductions().items()}
    lines.append(
        (
            "best method of the thesis at each speed",
            "real robot, another machine, all four positions, published",
            tuple(published.get(speed, "published as figures only") for speed in speeds),
        )
    )
    return Headline(sentences=tuple(sentences), speeds=speeds, lines=tuple(lines))


def residual_sentence(standings: Standings) -> str | None:
    """Count the learned residuals that are better than their bases and than servo gains, in a sentence or two.

    None without residuals.
    """
    learned = [line for line in standings.lines if line.row.name not in SERVO_GAINS]
    pairs = [(line, line.against_base) for line in learned if line.against_base is not None]
    if not pairs:
        return None
    better = _list_better(pairs)
    names = f": {_join_words(better)}" if better else ""
    unknown = [line.row.title for line, against in pairs if against.sentence.startswith("unknown")]
    rest = f" Unknown of {_join_words(unknown)}." if unknown else ""
    return (
        f"Of {len(pairs)} agent{'' if len(pairs) == 1 else 's'} that learned on top of another one, {len(better)} "
        f"{'is better than its' if len(better) == 1 else 'are better than their'} base on held-out circles, "
        f"{group_title(standings.group)}{names}.{rest}{_gains_sentence(learned)}"
    )


def margins_sentence(standings: Standings) -> str | None:
    """Count agents with feedback whose loop is stable on a robot with drives; None if no margins were measured."""
    measured = [line.row for line in standings.lines if line.row.margins]
    if not measured:
        return None
    stable = [row.title for row in measured if all(each.gain >= 1 for each in row.margins)]
    names = f": {_join_words(stable)}" if stable else ""
    rest = " The others chatter there: their gain margin is below 1." if len(stable) < len(measured) else ""
    return (
        f"Of {len(measured)} agent{'' if len(measured) == 1 else 's'} with feedback, {len(stable)} "
        f"{'is' if len(stable) == 1 else 'are'} stable on a robot with drives with all seeds{names}.{rest}"
    )


def _gains_sentence(learned: Sequence[Standing]) -> str:
    """Count the learned residuals that beat servo gains, in a sentence with a space before it; empty without them."""
    pairs = [(line, line.against_gains) for line in learned if line.against_gains is not None]
    if not pairs:
        return ""
    better = _list_better(pairs)
    names = f": {_join_words(better)}" if better else ""
    does = ("is", "counts") if len(better) == 1 else ("are", "count")
    return (
        f" {len(better)} of {len(pairs)} {does[0]} better than servo gains, a linear feedback of three numbers, and so "
        f"{does[1]} as learning{names}."
    )


def _list_better(pairs: Sequence[tuple[Standing, AgainstBase]]) -> list[str]:
    """List rows that are better than what they are compared with, with their gain."""
    better = []
    for line, against in pairs:
        if against.difference is not None and against.is_better:
            spread = against.difference.interval
            ends = "" if spread is None else f", between {_change(spread.high)} and {_change(spread.low)}"
            better.append(f"{line.row.title} ({_change(against.difference.ratio)} error{ends})")
    return better


def circles_note(standings: Standings, published: Sequence[PublishedRow] = ()) -> str:
    """Describe circles and plants, and name the rows that are left out with the reason."""
    grid = standings.grid
    title = group_title(standings.group)
    plants = f"{len(grid.plants)} {title}" if len(grid.plants) > 1 else title
    _, positions, radii, speeds = (sorted(set(part)) for part in zip(*grid.cells, strict=True))
    parts = [
        f"{len(grid.cells)} circles at {_numbers(speeds)} mm/s, radii {_numbers(radii)} mm, positions "
        f"{', '.join(positions)}; {plants}."
    ]
    if is_workcell(grid.plants[0]):
        (tracker,) = (each for each in find_plant(grid.plants[0]).sensors if isinstance(each, LaserTracker))
        parts.append(
            f"The errors are what a laser tracker with {tracker.noise * 1e6:g} um of noise in each coordinate "
            "measures: none is below that noise."
        )
    # plants and rows with reservations, published rows, and rows that are left out
    if grid.left_out:
        parts.append(f"Without {_join_words(grid.left_out)}, where zero action lacks some of these circles.")
    unproven = [f"{line.row.name} ({line.unproven})" for line in standings.lines if line.unproven and line.rank]
    if unproven:
        parts.append(
            f"Not known of chance, so that the place is not proven: {', '.join(unproven)}. Run --seeds 5 or --draws 20."
        )
    if published:
        counts = ", ".join(f"{each.circles} circles at {each.speed_mm_s:g} mm/s" for each in published[0].speeds)
        parts.append(
            f"Published rows: measured on the real robot of the thesis, another machine, never ranked; means over "
            f"those of the circles above that it measured ({counts})."
        )
    if standings.missing:
        parts.append(f"Not here: {'; '.join(f'{name}: {why}' for name, why in standings.missing.items())}.")
    return " ".join(parts)


def _changes(line: Standing) -> tuple[str, ...]:
    """Format the change of the mean error at each speed against no compensation."""
    return tuple(_change(1 - each.reduction) for each in line.score.speeds)


def _change(ratio: float) -> str:
    return percent(1 - ratio) if isfinite(ratio) else "unknown (the robot stopped)"


def _join_words(words: Sequence[str]) -> str:
    """Join words as in a sentence, by semicolons where one of them has a comma of its own."""
    if len(words) == 1:
        return words[0]
    if any(", " in each for each in words):
        return f"{'; '.join(words[:-1])}; and {words[-1]}"
    return f"{', '.join(words[:-1])} and {words[-1]}"


def _numbers(values: Iterable[float]) -> str:
    return ", ".join(f"{value:g}" for value in values)
