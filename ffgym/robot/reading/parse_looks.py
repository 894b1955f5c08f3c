"""The looks in a robot description: colours and primitives."""

from collections.abc import Mapping
from typing import Any

from ffgym.core.errors import FFGymError, check_choice, check_number, check_shape
from ffgym.robot.reading.tables import table_of
from ffgym.robot.shapes import Geom


def parse_looks(look: Any, bodies: tuple[str, ...]) -> tuple[Geom, ...]:
    """Primitives of the table [look] for a robot with these bodies.

    Raises:
        FFGymError: if an entry is unknown or invalid.
    """
    unknown = sorted(set(table_of("look", look)) - {"colours", "geoms"})
    if unknown:
        raise FFGymError(f"[look] has unknown entries {unknown}, may have colours and geoms.")
    colours = {
        name: tuple(check_shape(f"look.colours.{name}", value, (4,)).tolist())
        for name, value in table_of("look.colours", look.get("colours", {})).items()
    }
    geoms = look.get("geoms", [])
    if not isinstance(geoms, list):
        raise FFGymError(f"look.geoms must be a list of tables, got {geoms!r}.")
    return tuple(_geom(i, table_of(f"look.geoms[{i}]", entry), colours, bodies) for i, entry in enumerate(geoms))


def _geom(index: int, entry: dict[str, Any], colours: Mapping[str, Any], bodies: tuple[str, ...]) -> Geom:
    where = f"look.geoms[{index}]"

    def vector(key: str) -> Any:
        return tuple(check_shape(f"{where} {key}", entry[key], (3,)).tolist())

    try:
        body = check_choice(f"{where} body", entry["body"], bodies)
        kind = check_choice(f"{where} type", entry["type"], ("box", "cylinder", "capsule", "sphere"))
        colour = colours[check_choice(f"{where} colour", entry["colour"], list(colours))]
        size = vector("half_size") if kind == "box" else (check_number(f"{where} radius", entry["radius"], unit="m"),)
        long = kind in ("cylinder", "capsule")
        pos, end = (vector("from"), vector("to")) if long else (vector("centre"), None)
    except KeyError as error:
        raise FFGymError(f"{where} ({entry}) lacks {error.args[0]!r}.") from error
    if min(size) <= 0 or pos == end:
        raise FFGymError(f"{where} has size {size} m from {pos} to {end} m; sizes and lengths must be > 0.")
    return Geom(body=body, type=kind, size=size, pos=pos, end=end, colour=colour)
