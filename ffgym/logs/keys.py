"""Keys of a column map by table, with their meanings from keys.toml, and the check that a table has no others."""

import tomllib
from collections.abc import Mapping
from importlib import resources
from typing import Any

from ffgym.core.errors import FFGymError
from ffgym.recordings.schema import closest

KEYS: Mapping[str, Mapping[str, str]] = tomllib.loads(
    (resources.files("ffgym.logs") / "keys.toml").read_text(encoding="utf-8")
)
"""Table -> key -> what it means; [tables] has the tables themselves. Keys of [log] but `base`, `robot` and `trim` are
fields of the header (docs/recordings.md)."""


def check_table(table: Any, name: str, where: str = "") -> dict[str, Any]:
    """The table [name], all of whose keys are known; messages call it `where` if it is one of several."""
    where = where or f"[{name}]"
    if not isinstance(table, dict):
        raise FFGymError(f"{where} must be a table, got {table!r}.")
    for key in table:
        if key not in KEYS[name]:
            raise FFGymError(f"Unknown key {key!r} in {where}. {closest(key, KEYS[name])}")
    return dict(table)
