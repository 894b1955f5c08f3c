"""Columns of the page's table: what each holds, its words, and its cell for every row."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import final

from ffgym.leaderboard.comparison.standings import Standing, Standings
from ffgym.leaderboard.presentation.figures import (
    NOTHING,
    Figure,
    change,
    changed,
    count,
    digits,
    duration,
    length,
    share,
    sortable,
)
from ffgym.leaderboard.presentation.published_rows import PublishedRow


@final
@dataclass(frozen=True, kw_only=True)
class Column:
    """One column."""

    key: str
    title: str
    unit: str = ""
    help: str
    """For the list below the table."""
    of: Callable[[Standing], Figure]
    published: Callable[[PublishedRow], Figure] = lambda row: NOTHING
    is_text: bool = False


def columns_of(standings: Standings) -> list[Column]:
    """All columns; one per speed."""
    return [*_WHO, *(_speed(speed) for speed in standings.grid.speeds_mm_s), *_ERRORS, *_EFFORT]


def explanations(columns: Sequence[Column]) -> list[tuple[str, str]]:
    """Title and help of columns; those of speeds once."""
    lines: dict[str, str] = {}
    for column in columns:
        lines["10 mm/s, ..." if column.key.startswith("speed") else column.title] = column.help
    return list(lines.items())


def _rank(rank: int | None) -> Figure:
    return Figure(text="–" if rank is None else str(rank), sort=rank)


def _agent(line: Standing) -> Figure:
    detail = f"on {line.row.base}" if line.row.base else ""
    return Figure(text=line.row.title, detail=detail, sort=line.row.title.lower())


def _against(line: Standing) -> Figure:
    found = line.against_base
    if found is None:
        return NOTHING
    if found.difference is None:
        return Figure(text=found.sentence)
    ratio = found.difference.ratio
    return Figure(text=found.sentence, detail=change(ratio - 1), sort=sortable(ratio))


def _joint(line: Standing) -> Figure:
    worst = max(line.score.motor_mrad, default=float("inf"))
    return Figure(text=digits(worst), sort=sortable(worst))


def _normalised(line: Standing) -> Figure:
    value = line.score.normalised
    return NOTHING if value is None else Figure(text=digits(value), sort=sortable(value))


def _decision(line: Standing) -> Figure:
    value = line.score.inference_us
    return NOTHING if value is None else Figure(text=digits(value), sort=value)


def _stopped(line: Standing) -> str:
    return f"{line.score.stopped:.1%} stopped" if line.score.stopped else ""


def _speed(speed: float) -> Column:
    def of(line: Standing) -> Figure:
        score = next(each for each in line.score.speeds if each.speed_mm_s == speed)
        return changed(score.rms_um, score.reduction)

    def published(row: PublishedRow) -> Figure:
        known = [changed(each.rms_um, each.reduction) for each in row.speeds if each.speed_mm_s == speed]
        return known[0] if known else NOTHING

    return Column(
        key=f"speed{speed:g}",
        title=f"{speed:g} mm/s",
        unit="um",
        help="Mean RMS path error over the circles at this speed, in the plane of the circle, and its change against "
        "the mean with zero action.",
        of=of,
        published=published,
    )


_WHO = (
    Column(
        key="rank",
        title="rank",
        help="Among all tracks. Ties share a rank: the interval of the difference to the first row of that rank "
        "includes zero. Rows without a rank are shown only.",
        of=lambda line: _rank(line.rank),
    ),
    Column(
        key="agent",
        title="agent",
        help="Its name leads to its card.",
        of=_agent,
        published=lambda row: Figure(text=row.title, detail="published, real robot", sort=row.title.lower()),
        is_text=True,
    ),
    Column(
        key="left",
        title="error left",
        unit="%",
        help="What rows are ranked by: geometric mean over seeds, plants and circles of the RMS path error over that "
        "with zero action. Every circle counts the same, at 10 mm/s as at 100 mm/s, where errors are ten times larger.",
        of=lambda line: share(line.score.left, line.score.left_interval, bar=True),
    ),
)
_ERRORS = (
    Column(
        key="iqm",
        title="IQM of RMS",
        unit="um",
        help="Interquartile mean of the RMS path error over seeds, plants and circles: without the lowest and the "
        "highest quarter. Not what rows are ranked by, as circles at high speed outweigh the others in it.",
        of=lambda line: length(line.score.iqm_um, line.score.iqm_interval_um),
    ),
    Column(
        key="iqm3d",
        title="IQM in space",
        unit="um",
        help="The same with the error in space.",
        of=lambda line: length(line.score.iqm_3d_um),
    ),
    Column(
        key="largest",
        title="largest",
        unit="um",
        help="Largest deviation in the plane, of all seeds, plants and circles.",
        of=lambda line: length(line.score.max_um),
        published=lambda row: NOTHING if row.max_um is None else length(row.max_um),
    ),
    Column(
        key="motor",
        title="worst motor",
        unit="mrad",
        help="Mean RMS position error, motor side, of the joint where it is largest; all joints are on the card.",
        of=_joint,
    ),
    Column(
        key="worse",
        title="made worse",
        unit="%",
        help="Share of runs with a larger error than with zero action on the same plant and circle.",
        of=lambda line: Figure(
            text=f"{line.score.worse:.1%}"[:-1], detail=_stopped(line), sort=sortable(line.score.worse)
        ),
    ),
    Column(
        key="score",
        title="score",
        help="Interquartile mean of (zero - e) / (zero - oracle): 0 is zero action, 1 knows the true parameters. "
        "Only where an oracle ran; no command may know the workcell's parameters.",
        of=_normalised,
    ),
)
_EFFORT = (
    Column(
        key="base",
        title="against its base",
        help="For a residual, on held-out circles whatever circles are chosen above: whether the interval of the "
        "difference to the row below it includes zero.",
        of=_against,
        is_text=True,
    ),
    Column(
        key="track",
        title="track",
        help="What it may know: nothing but its trials; the nominal parameters too; trials of the very motion; the "
        "truth.",
        of=lambda line: Figure(text=line.row.track, sort=line.row.track),
        published=lambda row: Figure(text="published", sort="published"),
        is_text=True,
    ),
    Column(key="within", title="rank in track", help="As rank.", of=lambda line: _rank(line.track_rank)),
    Column(
        key="seeds",
        title="seeds",
        help="Trainings, or random torques, with different seeds.",
        of=lambda line: Figure(text=str(len(line.score.seeds)), sort=len(line.score.seeds)),
    ),
    Column(
        key="robot",
        title="robot time",
        help="How long a machine moved while it learned for one plant, mean over seeds and plants.",
        of=lambda line: Figure(text=duration(line.score.robot_seconds), sort=sortable(line.score.robot_seconds)),
    ),
    Column(
        key="steps",
        title="training",
        unit="steps",
        help="Control steps of simulated training per seed, which cost no robot time.",
        of=lambda line: Figure(text=count(line.score.env_steps), sort=sortable(line.score.env_steps)),
    ),
    Column(
        key="decision",
        title="decision",
        unit="us",
        help="Median time of one decision for one robot; none for a law that is computed before the motion.",
        of=_decision,
    ),
)
