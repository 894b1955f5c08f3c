"""Write the tables of docs/column_maps.md: every key of a column map, and the units that numbers may come in.

python -m scripts.column_map_tables
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import tyro

from ffgym.core.files import write_text
from ffgym.logs.column_map.column import COLUMN_KEYS
from ffgym.logs.column_map.column_map import LOG_KEYS, MOTION_KEYS, TABLES
from ffgym.logs.column_map.rewire import REWIRE_KEYS
from ffgym.logs.column_map.units import COUNTS, KELVIN, UNITS
from ffgym.logs.text_layout import LAYOUT_KEYS
from scripts.format_tables import with_tables


@dataclass(frozen=True)
class Config:
    """Tables of the column maps."""

    page: Path = Path("docs/column_maps.md")
    """Page that holds the tables, each between a comment with its name and an empty comment."""


def keys_table(keys: Mapping[str, str]) -> str:
    """Markdown table of keys and what they mean."""
    return "\n".join(["| key | meaning |", "|---|---|", *(f"| `{key}` | {meaning} |" for key, meaning in keys.items())])


def units_table() -> str:
    """Markdown table of units."""
    lines = ["| kept in | may come in |", "|---|---|"]
    for si, others in UNITS.items():
        also = [unit for unit, angle in COUNTS.items() if angle == si] + ([KELVIN] if si == "degC" else [])
        lines.append(f"| `{si}` | {', '.join(f'`{unit}`' for unit in (si, *others, *also))} |")
    return "\n".join(lines)


def filled(page: str) -> str:
    """Return the page with its tables as they are now."""
    tables = {
        "tables": TABLES,
        "log": LOG_KEYS,
        "columns": COLUMN_KEYS,
        "motions": MOTION_KEYS,
        "rewire": REWIRE_KEYS,
        "file": LAYOUT_KEYS,
    }
    return with_tables(page, {name: keys_table(keys) for name, keys in tables.items()} | {"units": units_table()})


def main(config: Config) -> Path:
    """Write the tables into the page."""
    write_text(config.page, filled(config.page.read_text(encoding="utf-8")))
    return config.page


if __name__ == "__main__":
    main(tyro.cli(Config))
