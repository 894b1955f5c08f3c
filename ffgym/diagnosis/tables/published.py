"""The table of the thesis: 144 rows to fit to (Tables 4.1 and 4.2) and 96 that are held out (5.1 and 5.2)."""

from ffgym.diagnosis.tables.error_table import ErrorTable, MotionKey, SignQuestion, Statistic, TableRow, Use
from ffgym.paths import RADII
from ffgym.published import METHODS, published_mm

POSITIONS = ("p1", "p2", "p3", "p4")
STATISTICS: tuple[Statistic, ...] = ("rms", "max")
FITTED: Use = "fitted"
HELD_OUT: Use = "held_out"
_TABLES = {("lugre", 10.0): "4.1", ("lugre", 40.0): "4.2", ("bsn", 10.0): "5.1", ("bsn", 40.0): "5.2"}


def thesis_table() -> ErrorTable:
    """Return the 240 published path errors as a table."""
    rows = []
    for law in METHODS:
        learns = law.startswith("bsn")
        family, use = ("bsn" if learns else "lugre"), (HELD_OUT if learns else FITTED)
        for speed in (10.0, 40.0):
            rows += _rows(law, speed, _TABLES[family, speed], use)
    return ErrorTable(
        title="path errors of the robot of the thesis",
        source="Chalmers/ABB master's thesis, Tables 4.1, 4.2, 5.1, 5.2 (ffgym.published)",
        robot="irb4600_60_205",
        rows=tuple(rows),
        alike=(("p1", "p4"), ("p2", "p3")),
        sign_of=SignQuestion(law="lugre_dynamic", speed_mm_s=40.0, radius_mm=1.0),
    )


def _rows(law: str, speed: float, table: str, use: Use) -> list[TableRow]:
    found = []
    for statistic in STATISTICS:
        for position in POSITIONS:
            for radius in RADII:
                value = published_mm(law, statistic, speed * 1e-3, radius, position)
                assert value is not None  # the thesis has all of them at these speeds
                found.append(
                    TableRow(
                        table=table,
                        use=use,
                        motion=MotionKey(position=position, speed_mm_s=speed),
                        radius_mm=round(radius * 1e3, 6),
                        law=law,
                        statistic=statistic,
                        value_mm=value,
                    )
                )
    return found
