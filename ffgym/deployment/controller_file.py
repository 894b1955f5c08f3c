"""File of a controller: its delay and smoothing filter, as they were identified or as its manual says."""

import os
from collections.abc import Mapping
from typing import Any

from ffgym.control import SetpointResponse
from ffgym.core.errors import FFGymError, errors_at
from ffgym.core.files import read_text, write_text
from ffgym.core.toml import parse_toml, toml_table

_TABLE = "setpoints"
_UNITS = {"delay": "s", "lag": "s", "curvature": "s^2"}


def write_controller(
    path: str | os.PathLike[str],
    response: SetpointResponse,
    *,
    source: str,
    intervals: Mapping[str, tuple[float, float]] | None = None,
) -> None:
    """Write delay and filter of a controller as TOML.

    Args:
        path: file, .toml.
        response: delay and filter.
        source: where the numbers come from.
        intervals: 95 % intervals by name, in SI units.

    Raises:
        FFGymError: if the file cannot be written.
    """
    entries: dict[str, Any] = {"source": source}
    for name in _UNITS:
        entries[name] = getattr(response, name)
        entries[f"{name}_interval"] = (intervals or {}).get(name)
    lines = [
        f"# {response.describe()}",
        "# delay [s], lag a_1 [s], curvature a_2 [s^2]: exp(-delay s) / (1 + a_1 s + a_2 s^2)",
    ]
    write_text(path, "\n".join([*lines, *toml_table(_TABLE, entries), ""]))


def read_controller(path: str | os.PathLike[str]) -> SetpointResponse:
    """Read delay and filter of a controller; entries that are left out are 0.

    Raises:
        FFGymError: if the file cannot be read, or is none of a controller.
    """
    with errors_at(str(path)):
        tables = parse_toml(read_text(path), "The file")
        table = tables.get(_TABLE)
        if not isinstance(table, dict):
            raise FFGymError(f"There is no table [{_TABLE}]; ffgym identify controller writes one.")
        known = {*_UNITS, *(f"{name}_interval" for name in _UNITS), "source"}
        if unknown := sorted(set(table) - known):
            raise FFGymError(f"Unknown entries of [{_TABLE}]: {', '.join(unknown)}. Known: {', '.join(sorted(known))}.")
        return SetpointResponse(**{name: table[name] for name in _UNITS if name in table})
