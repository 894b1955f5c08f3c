"""The results as plain text for a terminal, at most 120 columns wide."""

from collections.abc import Sequence
from textwrap import wrap

from ffgym.report.circles.comparison import FACTOR, Entry, SpeedTable, circle_tables, nearness
from ffgym.report.laws import UNCOMPENSATED, law_styles
from ffgym.studies import CircleStudy, OneAxisStudy

WIDTH = 120
"""Columns of a terminal that every line fits in."""
Column = tuple[str, list[str]]
"""Heading and cells."""


def format_text(study: CircleStudy) -> str:
    """One table per speed: simulated beside published path error, then their ratio without compensation."""
    legend = filled(
        f"Path error of {study.title} [mm]: deviation of the tool from the circle, in the plane of the circle, "
        "as RMS (max); offset at standstill removed; lead-in and lead-out do not count. simulated: ffgym. published: "
        "the real robot, by laser tracker, as printed in the thesis (Tables 4.1, 4.2, 5.1, 5.2). '-': not published."
    )
    return "\n\n".join([legend, *(_speed_text(table) for table in circle_tables(study))]) + "\n"


def format_one_axis(study: OneAxisStudy) -> str:
    """Motor error of the sine test, one line per frequency and law."""
    styles = law_styles(result.agent for result in study.results)
    columns: list[Column] = [
        ("f [Hz]", [f"{result.frequency_hz:g}" for result in study.results]),
        ("law", [shortened(styles[result.agent].label) for result in study.results]),
        ("RMS [mrad]", [f"{result.motor_rms_rad * 1e3:.3f}" for result in study.results]),
        ("max [mrad]", [f"{result.motor_max_rad * 1e3:.3f}" for result in study.results]),
        ("RMS removed", [f"{result.reduction:.1%}" for result in study.results]),
    ]
    legend = filled(
        f"Sine test of {study.robot.title}, simulated: motor position error, motor side, after the start has settled. "
        "RMS removed: share of the first law's RMS that is gone. The thesis prints no numbers, only "
        "Figures 4.3 and 4.5."
    )
    return legend + "\n\n" + aligned(columns[:2], [[column] for column in columns[2:]]) + "\n"


def _speed_text(table: SpeedTable) -> str:
    title = f"{table.speed_mm_s:g} mm/s"
    fixed: list[Column] = [
        ("r [mm]", [f"{row.radius_mm:g}" for row in table.rows] + ["mean"]),
        ("position", [shortened(row.position) for row in table.rows] + ["all"]),
    ]
    styles = law_styles(table.agents)
    blocks = [_law_block(table, agent, styles[agent].label) for agent in table.agents]
    parts = [title, "-" * len(title), aligned(fixed, blocks, [styles[agent].label for agent in table.agents])]
    return "\n".join([*parts, "", _ratio_text(table)])


def _law_block(table: SpeedTable, agent: str, label: str) -> list[Column]:
    entries = [row.entries.get(agent) for row in table.rows]
    mean, published_mean = table.mean_rms(agent), table.mean_published_rms(agent)
    return [
        ("simulated", [_simulated(entry) for entry in entries] + ["-" if mean is None else f"{mean:.3f}"]),
        (
            "published",
            [_published(entry) for entry in entries] + ["-" if published_mean is None else f"{published_mean:.3f}"],
        ),
    ]


def _simulated(entry: Entry | None) -> str:
    return "-" if entry is None else f"{entry.rms:.3f} ({entry.max:.3f})"


def _published(entry: Entry | None) -> str:
    if entry is None or entry.published_rms is None:
        return "-"
    return f"{entry.published_rms:.3f} ({'-' if entry.published_max is None else f'{entry.published_max:.2f}'})"


def _ratio_text(table: SpeedTable) -> str:
    """Ratio simulated over published RMS without compensation, circle by circle and in short."""
    if UNCOMPENSATED not in table.agents:
        return f"No run without compensation (law {UNCOMPENSATED!r}), so none to compare with the published robot."
    ratios = table.ratios()
    summary = nearness(ratios.values())
    if summary is None:
        return f"Nothing to compare with: no numbers were published for these circles at {table.speed_mm_s:g} mm/s."
    fixed: list[Column] = [("r [mm]", [f"{radius:g}" for radius in table.radii])]
    blocks = [
        [(shortened(position), [_ratio(ratios.get((r, position))) for r in table.radii])]
        for position in table.positions
    ]
    return "\n".join(
        [
            "Ratio simulated / published RMS without compensation:",
            aligned(fixed, blocks),
            f"median {summary.median:.2f}; {summary.near} of {summary.total} circles within a factor of {FACTOR:g} "
            f"({1 / FACTOR:.2f} to {FACTOR:g})",
        ]
    )


def _ratio(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"


def aligned(fixed: Sequence[Column], blocks: Sequence[Sequence[Column]], titles: Sequence[str] = ()) -> str:
    """Columns side by side; blocks that do not fit go below, each time with the fixed columns on their left."""
    left = _joined(fixed)
    room = WIDTH - len(left[0])
    tables: list[list[str]] = []
    used = WIDTH
    for i, block in enumerate(blocks):
        lines = _joined(block)
        lines = ([shortened(titles[i])] if titles else []) + lines
        width = max(len(line) for line in lines)
        if used + 3 + width > room:
            tables.append([" " * len(left[0])] * bool(titles) + left)
            used = 0
        used += 3 + width
        tables[-1] = [f"{row} | {line:<{width}}" for row, line in zip(tables[-1], lines, strict=True)]
    return "\n\n".join("\n".join(line.rstrip() for line in table) for table in tables)


def _joined(columns: Sequence[Column]) -> list[str]:
    widths = [max(len(text) for text in (heading, *cells)) for heading, cells in columns]
    rows = zip(*([heading, *cells] for heading, cells in columns), strict=True)
    return ["  ".join(f"{text:<{width}}" for text, width in zip(row, widths, strict=True)) for row in rows]


def shortened(name: str) -> str:
    """Names come from files and may be long; a line has room for 30 characters."""
    return name if len(name) <= 30 else name[:29] + "…"


def filled(text: str) -> str:
    """Text in lines that fit a terminal."""
    return "\n".join(wrap(text, WIDTH))
