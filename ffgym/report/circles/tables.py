"""Tables of the circle test and the sine test, for terminals and pages."""

from collections.abc import Sequence

from ffgym.report.circles.comparison import FACTOR, SpeedTable, circle_tables, nearness, percent, reduction
from ffgym.report.laws import UNCOMPENSATED, baseline_of, law_column, law_styles
from ffgym.report.table import Cell, Column, Table, filled, pair, underlined
from ffgym.studies import CircleStudy, OneAxisStudy


def format_text(study: CircleStudy) -> str:
    """One table per speed: simulated beside published path error, and their ratio without compensation."""
    legend = filled(
        f"Path error of {study.title} [mm]: deviation of the tool from the circle, in the plane of the circle, "
        "as RMS (max); offset at standstill removed; lead-in and lead-out do not count. simulated: ffgym. published: "
        "the real robot, by laser tracker, as printed in the thesis (Tables 4.1, 4.2, 5.1, 5.2). '-': not published."
    )
    parts = [legend]
    for table in circle_tables(study):
        speed, near = f"{table.speed_mm_s:g} mm/s", nearness(table.ratios().values())
        if UNCOMPENSATED not in table.agents:
            words = f"No run without compensation (law {UNCOMPENSATED!r}), so none to compare with the published robot."
        elif near is None:
            words = f"Nothing to compare with: no numbers were published for these circles at {speed}."
        else:
            words = filled(
                f"Ratio simulated / published RMS without compensation: median {near.median:.2f}; {near.near} of "
                f"{near.total} circles within a factor of {FACTOR:g} ({1 / FACTOR:.2f} to {FACTOR:g})"
            )
        parts += [f"{underlined(speed)}\n{speed_table(table).text()}", words]
    return "\n\n".join(parts) + "\n"


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
        simulated = [entry and pair(entry.rms, entry.max, ".3f") for entry in entries]
        published = [entry and pair(entry.published_rms, entry.published_max, ".3f", ".2f") for entry in entries]
        means = table.mean_rms(agent), table.mean_published_rms(agent)
        columns += [
            Column("simulated", [*simulated, means[0]], ".3f", group=style.label, colour=style.colour),
            Column("published", [*published, means[1]], ".3f", group=style.label, style="published"),
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
            law_column("law", [result.agent for result in results]),
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
        law_column("law", [agent for _, agent, _ in lines]),
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
