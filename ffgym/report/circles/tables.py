"""Tables of the circle test and the sine test, for terminals and pages."""

from collections.abc import Sequence

from ffgym.report.circles.comparison import FACTOR, Entry, SpeedTable, circle_tables, nearness, percent, reduction
from ffgym.report.laws import UNCOMPENSATED, baseline_of, law_styles
from ffgym.report.table import Cell, Column, Table, filled, pair, underlined
from ffgym.studies import CircleStudy, OneAxisStudy


def format_text(study: CircleStudy) -> str:
    """One table per speed: simulated beside published path error, and their ratio without compensation."""
    legend = filled(
        f"Path error of {study.title} [mm]: deviation of the tool from the circle, in the plane of the circle, "
        "as RMS (max); offset at standstill removed; lead-in and lead-out do not count. simulated: ffgym. published: "
        "the real robot, by laser tracker, as printed in the thesis (Tables 4.1, 4.2, 5.1, 5.2). '-': not published."
    )
    return "\n\n".join([legend, *map(_speed_text, circle_tables(study))]) + "\n"


def format_one_axis(study: OneAxisStudy) -> str:
    """Motor error of the sine test, one line per frequency and law."""
    legend = filled(
        f"Sine test of {study.robot.title}, simulated: motor position error, motor side, after the start has settled. "
        "RMS removed: share of the first law's RMS that is gone. The thesis prints no numbers, only "
        "Figures 4.3 and 4.5."
    )
    return f"{legend}\n\n{sine_table(study).text()}\n"


def speed_table(table: SpeedTable, *, with_ratio: bool = True) -> Table:
    """Every circle at one speed, simulated beside published; their ratio without compensation, if there is one."""
    rows, styles = table.rows, law_styles(table.agents)
    columns = [
        Column("r", [*(row.radius_mm for row in rows), "mean"], "g", unit="mm"),
        Column("position", [*(row.position for row in rows), "all"], kind="name"),
    ]
    for agent, style in styles.items():
        entries = [row.entries.get(agent) for row in rows]
        simulated = [*map(_simulated, entries), table.mean_rms(agent)]
        published = [*map(_published, entries), table.mean_published_rms(agent)]
        columns += [
            Column("simulated", simulated, ".3f", group=style.label, colour=style.colour),
            Column("published", published, ".3f", group=style.label, style="published"),
        ]
    near = nearness(table.ratios().values())
    if with_ratio and near is not None:
        ratios = [table.ratios().get((row.radius_mm, row.position)) for row in rows]
        median = Cell(f"median {near.median:.2f}")
        columns.append(Column(f"ratio, {styles[UNCOMPENSATED].label}", [*ratios, median], ".2f", style="edge"))
    return Table(columns=columns, fixed=2, ruled_by=0, strong=[-1])


def sine_table(study: OneAxisStudy) -> Table:
    """Motor error at each frequency with each law."""
    results = study.results
    return Table(
        columns=[
            Column("f", [result.frequency_hz for result in results], "g", unit="Hz"),
            law_column([result.agent for result in results]),
            Column("RMS", [result.motor_rms_rad * 1e3 for result in results], ".3f", unit="mrad"),
            Column("max", [result.motor_max_rad * 1e3 for result in results], ".3f", unit="mrad"),
            Column("RMS removed", [result.reduction for result in results], ".1%"),
        ],
        name="sines",
        fixed=2,
        ruled_by=0,
    )


def summary_table(tables: Sequence[SpeedTable]) -> Table:
    """One line per speed and law: mean RMS and change, simulated and published."""
    lines = [(table, agent, baseline_of(table.agents)) for table in tables for agent in table.agents]
    columns = [
        Column("speed", [table.speed_mm_s for table, _, _ in lines], "g", unit="mm/s"),
        law_column([agent for _, agent, _ in lines]),
    ]
    for group, style, mean in (
        ("simulated", "", SpeedTable.mean_rms),
        ("published", "published", SpeedTable.mean_published_rms),
    ):
        changes = [None if law == base else reduction(mean(t, law), mean(t, base)) for t, law, base in lines]
        words = [None if change is None else percent(change) for change in changes]
        columns += [
            Column("mean RMS", [mean(t, law) for t, law, _ in lines], ".3f", unit="mm", group=group, style=style),
            Column("change", words, group=group, style=style),
        ]
    return Table(columns=columns, name="summary", fixed=2, ruled_by=0)


def law_column(agents: Sequence[str]) -> Column:
    """Laws in their words and colours, one for each row."""
    styles = law_styles(agents)
    return Column("law", [Cell(styles[law].label, colour=styles[law].colour) for law in agents], kind="name")


def _simulated(entry: Entry | None) -> Cell | None:
    return None if entry is None else pair(entry.rms, entry.max, ".3f")


def _published(entry: Entry | None) -> Cell | None:
    return None if entry is None else pair(entry.published_rms, entry.published_max, ".3f", ".2f")


def _speed_text(table: SpeedTable) -> str:
    return f"{underlined(f'{table.speed_mm_s:g} mm/s')}\n{speed_table(table).text()}\n\n{_ratio_text(table)}"


def _ratio_text(table: SpeedTable) -> str:
    """How near simulated and published RMS are without compensation."""
    if UNCOMPENSATED not in table.agents:
        return f"No run without compensation (law {UNCOMPENSATED!r}), so none to compare with the published robot."
    summary = nearness(table.ratios().values())
    if summary is None:
        return f"Nothing to compare with: no numbers were published for these circles at {table.speed_mm_s:g} mm/s."
    return filled(
        f"Ratio simulated / published RMS without compensation: median {summary.median:.2f}; {summary.near} of "
        f"{summary.total} circles within a factor of {FACTOR:g} ({1 / FACTOR:.2f} to {FACTOR:g})"
    )
