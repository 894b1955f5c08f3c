"""Write the tables of docs/robot_description.md: every entry of a description, and what each function needs.

python -m scripts.format_tables
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import tyro

from ffgym.core.errors import FFGymError
from ffgym.core.files import write_text
from ffgym.robot.reading.draft import CAPABILITIES
from ffgym.robot.reading.quantity import OTHER_UNITS, Rule
from ffgym.robot.reading.rules import RULES

GEOMETRY = CAPABILITIES[0].needs
"""What every function needs, which the table says once."""


@dataclass(frozen=True)
class Config:
    """Tables of the description format."""

    page: Path = Path("docs/robot_description.md")
    """Page that holds the tables, each between a comment with its name and an empty comment."""


def entries_table() -> str:
    """Markdown table of all entries."""
    lines = ["| entry | shape | unit | side | required | meaning |", "|---|---|---|---|---|---|"]
    for path, rule in RULES.items():
        required = "no" if rule.optional else "yes"
        lines.append(
            f"| `{path}` | {_shape(rule)} | {_units(rule)} | {rule.side or ''} | {required} | {rule.meaning} |"
        )
    return "\n".join(lines)


def capabilities_table() -> str:
    """Markdown table of what each function needs."""
    whole = {path for path, rule in RULES.items() if not rule.optional}
    lines = ["| function | entries |", "|---|---|"]
    for entry in CAPABILITIES:
        needs = [path for path in entry.needs if path not in GEOMETRY] or list(entry.needs)
        if whole <= set(entry.needs):
            needs = ["all that are required", *(path for path in entry.needs if path not in whole)]
        text = ", ".join(f"`{path}`" if "." in path else path for path in needs)
        lines.append(f"| {entry.title} | {text} |")
    return "\n".join(lines)


def filled(page: str) -> str:
    """Return the page with its tables as they are now."""
    return with_tables(page, {"entries": entries_table(), "functions": capabilities_table()})


def with_tables(page: str, tables: Mapping[str, str]) -> str:
    """Return a page with tables in their places, by the names of these.

    Raises:
        FFGymError: if the page has no place for one.
    """
    for name, table in tables.items():
        parts = re.split(rf"(<!-- {name} -->\n\n).*?(\n\n<!-- -->)", page, flags=re.DOTALL)
        if len(parts) != 4:
            raise FFGymError(f"The page must hold '<!-- {name} -->', a table and '<!-- -->' once.")
        before, start, end, after = parts
        page = before + start + table + end + after
    return page


def _shape(rule: Rule) -> str:
    if not rule.shape:
        return "number"
    return f"({', '.join(map(str, rule.shape))}{',' if len(rule.shape) == 1 else ''})"


def _units(rule: Rule) -> str:
    return " or ".join((rule.unit, *OTHER_UNITS.get(rule.unit, {})))


def main(config: Config) -> Path:
    """Write the tables into the page."""
    write_text(config.page, filled(config.page.read_text(encoding="utf-8")))
    return config.page


if __name__ == "__main__":
    main(tyro.cli(Config))
