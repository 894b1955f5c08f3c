"""Write the tables of docs/motion_files.md: what a motion file may say, its parts and limits, the built-in motions.

python -m scripts.motion_tables
"""

import inspect
import re
from dataclasses import MISSING, Field, dataclass, fields
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

import tyro

from ffgym.core.files import write_text
from ffgym.paths.limits import MotionLimits
from ffgym.paths.motions.load import HEAD, builtin_files
from ffgym.paths.motions.parts import PARTS, Part, entries
from ffgym.paths.motions.parts.part import is_required
from scripts.format_tables import with_tables


@dataclass(frozen=True)
class Config:
    """Tables of the motion files."""

    page: Path = Path("docs/motion_files.md")
    """Page that holds the tables, each between a comment with its name and an empty comment."""


def head_table() -> str:
    """Markdown table of what stands before the parts."""
    rows = [f"| `{name}` | {meaning} |" for name, meaning in HEAD.items()]
    return "\n".join(["| entry | meaning |", "|---|---|", *rows])


def parts_table() -> str:
    """Markdown tables of all parts, each below its kind."""
    return "\n\n".join(_part(kind, part) for kind, part in PARTS.items())


def limits_table() -> str:
    """Markdown table of the limits with their defaults."""
    meanings = re.findall(r'^    (\w+): [^\n]*\n    """(.*?)"""', inspect.getsource(MotionLimits), flags=re.M | re.S)
    rows = [
        f"| `{name}` | {default_text(f)} | {meaning} |"
        for (name, meaning), f in zip(meanings, fields(MotionLimits), strict=True)
    ]
    return "\n".join(["| limit | default | meaning |", "|---|---|---|", *rows])


def built_in_table() -> str:
    """Markdown table of the motions that ship, with the first comment of each."""
    rows = [f"| `{name}` | {_first_comment(file)} |" for name, file in sorted(builtin_files().items())]
    return "\n".join(["| name | motion |", "|---|---|", *rows])


def _first_comment(file: Traversable) -> str:
    """What stands behind the first # or !, by which the languages of the files begin a comment."""
    found = re.search(r"^\s*[#!] (.*)$", file.read_text(encoding="utf-8"), flags=re.M)
    return found[1] if found else ""


def _part(kind: str, part: type[Part]) -> str:
    assert part.__doc__ is not None
    lines = [f"### {kind}", "", part.__doc__, "", "| entry | unit | default | meaning |", "|---|---|---|---|"]
    for f in entries(part):
        default = "required" if is_required(f) else default_text(f)
        lines.append(f"| `{f.name}` | {f.metadata['unit']} | {default} | {f.metadata['meaning']} |")
    return "\n".join(lines)


def default_text(f: Field[Any]) -> str:
    """Default of a field as a file would write it."""
    if f.default is MISSING or f.default is None or f.default == "":
        return ""
    if isinstance(f.default, bool):
        return str(f.default).lower()
    if isinstance(f.default, tuple):
        return f"[{', '.join(f'{x:g}' for x in f.default)}]"
    return f"{f.default:g}" if isinstance(f.default, float) else str(f.default)


def filled(page: str) -> str:
    """Return the page with its tables as they are now."""
    tables = {"head": head_table(), "parts": parts_table(), "limits": limits_table(), "built-in": built_in_table()}
    return with_tables(page, tables)


def main(config: Config) -> Path:
    """Write the tables into the page."""
    write_text(config.page, filled(config.page.read_text(encoding="utf-8")))
    return config.page


if __name__ == "__main__":
    main(tyro.cli(Config))
