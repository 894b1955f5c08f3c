"""Files of a table of path errors: a CSV file of rows, and a TOML file that says of which robot they are.

    title = "path errors of our robot, March"        robot = "irb4600_60_205"        rows = "errors.csv"
    alike = [["p1", "p4"], ["p2", "p3"]]             optional: mirror images, of which a search simulates one
    sign_of = { law = "lugre_dynamic", speed_mm_s = 40, radius_mm = 1 }     optional: does this law help there?

    table,use,motion,position,speed_mm_s,radius_mm,law,statistic,value_mm
    4.1,fitted,,p1,10,1,none,rms,0.14            a circle of the built-in test
    4.1,held_out,corner.toml,,,,none,max,0.31    any motion file, scored as a whole

Learned laws (any of the agents' catalogue) are trained in each model at the first position, at the speed of their row.
"""

import csv
import io
import os
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any, get_args

from ffgym.core.errors import FFGymError, check_choice, check_number, errors_at
from ffgym.core.files import read_text, write_text
from ffgym.core.toml import parse_toml, toml_value
from ffgym.diagnosis.tables.error_table import ErrorTable, MotionKey, SignQuestion, Statistic, TableRow, Use

COLUMNS = ("table", "use", "motion", "position", "speed_mm_s", "radius_mm", "law", "statistic", "value_mm")
"""Columns of the CSV file; those that no row needs may be left out."""

_NEEDED = ("use", "law", "statistic", "value_mm")

_HEAD = ("title", "source", "robot", "rows", "alike", "sign_of")

_LONGEST = 1000.0
"""Largest error that makes sense [mm]; a larger one is a mistake of the unit."""


def load_table(path: str | os.PathLike[str]) -> ErrorTable:
    """Read a table: its TOML file, and the CSV file that this names.

    Raises:
        FFGymError: if a file cannot be read, or an entry is missing, unknown or not valid; the message says where.
    """
    place = Path(path)
    head = parse_toml(read_text(place), str(place))
    with errors_at(str(place)):
        for name in head:
            check_choice("entry", name, _HEAD)
        for name in ("robot", "rows"):
            if not isinstance(head.get(name), str):
                raise FFGymError(f"needs the entry {name}, a text; see docs/diagnosis_tables.md.")
    file = place.parent / head["rows"]
    rows = _parse_rows(read_text(file), str(file))
    return ErrorTable(
        title=str(head.get("title", place.stem)),
        source=str(head.get("source", "")),
        robot=_find_robot(head["robot"], place),
        rows=tuple(rows),
        folder=place.parent,
        **_parse_options(head, str(place)),
    )


def _find_robot(name: str, place: Path) -> str:
    """Return the name of a robot; the path of a description counts from the table's folder."""
    return str(place.parent / name) if name.endswith(".toml") else name


def _parse_options(head: dict[str, Any], where: str) -> dict[str, Any]:
    """Parse what a table may say beside its rows."""
    found: dict[str, Any] = {}
    alike, asked = head.get("alike", []), head.get("sign_of")
    if not isinstance(alike, list) or not all(map(_is_list_of_texts, alike)):
        raise FFGymError(f"{where}: alike = {alike!r} must be a list of lists of positions.")
    found["alike"] = tuple(tuple(group) for group in alike)
    if asked is not None:
        names = sorted(f.name for f in fields(SignQuestion))
        if not isinstance(asked, dict) or sorted(asked) != names:
            raise FFGymError(f"{where}: sign_of = {asked!r} must be a table of {', '.join(names)}.")
        found["sign_of"] = SignQuestion(
            law=str(asked["law"]),
            speed_mm_s=check_number("sign_of.speed_mm_s", asked["speed_mm_s"], unit="mm/s"),
            radius_mm=check_number("sign_of.radius_mm", asked["radius_mm"], unit="mm"),
        )
    return found


def _is_list_of_texts(value: Any) -> bool:
    return isinstance(value, list) and all(isinstance(entry, str) for entry in value)


def write_table(path: str | os.PathLike[str], table: ErrorTable) -> None:
    """Write a table as its TOML file, and a CSV file of the same name beside it; paths count from their folder."""
    place = Path(path)

    def relative(file: str | Path) -> str:
        return Path(os.path.relpath(file, place.parent)).as_posix()

    robot = relative(table.robot) if table.robot.endswith(".toml") else table.robot
    head: dict[str, Any] = {"title": table.title, "source": table.source, "robot": robot}
    head["rows"] = f"{place.stem}.csv"
    if table.alike:
        head["alike"] = table.alike
    if table.sign_of is not None:
        head["sign_of"] = asdict(table.sign_of)
    write_text(place, "".join(f"{name} = {toml_value(value)}\n" for name, value in head.items()))
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for row in table.rows:
        key = row.motion
        circle = [key.position, f"{key.speed_mm_s:g}", f"{row.radius_mm:g}"] if not key.file else ["", "", ""]
        motion = relative(table.motion_file(key)) if key.file else ""
        writer.writerow([row.table, row.use, motion, *circle, row.law, row.statistic, f"{row.value_mm:g}"])
    write_text(place.with_suffix(".csv"), text.getvalue())


def _parse_rows(text: str, where: str) -> list[TableRow]:
    lines = [line for line in csv.reader(io.StringIO(text)) if any(cell.strip() for cell in line)]
    if len(lines) < 2:
        raise FFGymError(f"{where}: has no rows; the first line names the columns: {', '.join(COLUMNS)}.")
    names = [name.strip() for name in lines[0]]
    with errors_at(f"{where}, line 1"):
        for name in names:
            check_choice("column", name, COLUMNS)
        if missing := [name for name in _NEEDED if name not in names]:
            raise FFGymError(f"columns {', '.join(missing)} are missing.")
    rows = []
    for number, line in enumerate(lines[1:], start=2):
        with errors_at(f"{where}, row {number}"):
            if len(line) != len(names):
                raise FFGymError(f"has {len(line)} cells, must have {len(names)}, one for each column.")
            rows.append(_parse_row({name: cell.strip() for name, cell in zip(names, line, strict=True)}))
    return rows


def _parse_row(cells: dict[str, str]) -> TableRow:
    file, position = cells.get("motion", ""), cells.get("position", "")
    if bool(file) == bool(position):
        raise FFGymError(
            f"motion = {file!r} and position = {position!r}: give one of them, a motion file, or a position of the "
            f"work area with speed_mm_s and radius_mm."
        )
    if file and (given := [name for name in ("speed_mm_s", "radius_mm") if cells.get(name)]):
        raise FFGymError(f"{given[0]} = {cells[given[0]]!r} has no effect on a motion file; leave the cell empty.")
    use = check_choice("use", cells["use"], get_args(Use))
    statistic = check_choice("statistic", cells["statistic"], get_args(Statistic))
    return TableRow(
        table=cells.get("table", ""),
        use=use,  # type: ignore[arg-type]  # checked above
        motion=MotionKey(file=file) if file else MotionKey(position=position, speed_mm_s=_number(cells, "speed_mm_s")),
        radius_mm=0.0 if file else _number(cells, "radius_mm"),
        law=cells["law"],
        statistic=statistic,  # type: ignore[arg-type]  # checked above
        value_mm=_number(cells, "value_mm"),
    )


def _number(cells: dict[str, str], name: str) -> float:
    unit = "mm/s" if name == "speed_mm_s" else "mm"
    try:
        value: Any = float(cells.get(name, ""))
    except ValueError:
        value = cells.get(name, "")
    return check_number(name, value, unit=unit, low=0.0, high=_LONGEST, open_low=True)
