"""All that is known of one agent, as its card on the page shows it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from ffgym.leaderboard.comparison.standings import Standing, Standings
from ffgym.leaderboard.plants import DRAW
from ffgym.leaderboard.presentation.figures import change, count, digits, duration, share
from ffgym.leaderboard.presentation.pictures import LearningCurve, Picture, ToolPaths, learning_curve, tool_pictures
from ffgym.leaderboard.presentation.words import group_title
from ffgym.leaderboard.results import Row
from ffgym.report.laws import UNCOMPENSATED


@final
@dataclass(frozen=True, kw_only=True)
class OnPlants:
    """What an agent scores on one group of plants, on held-out circles."""

    group: str
    rank: str
    left: str
    speeds: tuple[tuple[float, str], ...]
    """Speed [mm/s], and error with its interval and change."""
    motor: str
    """Of every joint [mrad]."""
    sentence: str
    """Against its base; empty if it is no residual."""


@final
@dataclass(frozen=True, kw_only=True)
class Card:
    """One agent."""

    row: Row
    summary: str
    """Its rank and what it leaves, on one line."""
    effort: str
    plants: tuple[OnPlants, ...]
    files: tuple[tuple[int, str, str, str], ...]
    """Seed, plant, fingerprint of the physics, sha256 of the artefact or words, of plants that were not drawn."""
    n_drawn: int
    """Drawn plants beside those."""
    curve: LearningCurve | None
    """None if it was not trained with steps."""
    pictures: tuple[Picture, ...]
    versions: tuple[str, ...]
    """That its results came from."""


def cards_of(rows: Sequence[Row], held_out: Sequence[Standings], paths: ToolPaths) -> list[Card]:
    """A card per row; those of the first standings in their order, then the others by name.

    Args:
        rows: of the leaderboard.
        held_out: standings on held-out circles, one per group of plants.
        paths: pictures of the tool by name and speed.
    """
    first = [line.row.name for line in held_out[0].lines] if held_out else []
    places = {name: place for place, name in enumerate(first)}
    ordered = sorted(rows, key=lambda row: (places.get(row.name, len(places)), row.name))
    return [_card(row, held_out, paths) for row in ordered]


def _card(row: Row, held_out: Sequence[Standings], paths: ToolPaths) -> Card:
    found = [(each.group, line) for each in held_out if (line := each.line(row.name)) is not None]
    return Card(
        row=row,
        summary=_summary(*found[0]) if found else "no complete result on held-out circles",
        effort=_effort(found[0][1]) if found else "unknown",
        plants=tuple(_on(group, line) for group, line in found),
        files=_files(row),
        n_drawn=len({outcome.plant for outcome in row.outcomes if outcome.plant.startswith(DRAW)}),
        curve=learning_curve(row.learning_curve),
        pictures=tuple(tool_pictures(paths.get(row.name, {}), paths.get(UNCOMPENSATED, {}))),
        versions=tuple(dict.fromkeys(outcome.versions for outcome in row.outcomes)),
    )


def _summary(group: str, line: Standing) -> str:
    place = "not ranked" if line.rank is None else f"rank {line.rank}"
    return f"{place}, leaves {digits(line.score.left * 100)} % on held-out circles, {group_title(group)}"


def _effort(line: Standing) -> str:
    seeds = len(line.score.seeds)
    return (
        f"{count(line.score.env_steps)} environment steps and {duration(line.score.robot_seconds)} of robot time per "
        f"seed; {seeds} seed{'s' if seeds > 1 else ''}"
    )


def _on(group: str, line: Standing) -> OnPlants:
    left = share(line.score.left, line.score.left_interval)
    against = line.against_base
    return OnPlants(
        group=group_title(group),
        rank="–" if line.rank is None else str(line.rank),
        left=f"{left.text} {left.detail}".strip(),
        speeds=tuple((each.speed_mm_s, _error(each.rms_um, each.reduction)) for each in line.score.speeds),
        motor=" ".join(digits(value) for value in line.score.motor_mrad) or "stopped",
        sentence="" if against is None else against.sentence,
    )


def _error(rms_um: float, reduction: float) -> str:
    return f"{digits(rms_um)} ({change(-reduction)})" if change(-reduction) else digits(rms_um)


def _files(row: Row) -> tuple[tuple[int, str, str, str], ...]:
    known = [outcome for outcome in row.outcomes if not outcome.plant.startswith(DRAW)]
    return tuple(
        (each.seed, each.plant, each.fingerprint, each.artefact or "made from the robot's description")
        for each in sorted(known, key=lambda each: (each.plant, each.seed))
    )
