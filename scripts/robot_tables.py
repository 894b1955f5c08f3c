"""Write docs/robots/*.md: every number of the built-in robots with unit, side, origin and source.

python -m scripts.robot_tables
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import tyro

from ffgym.core.files import write_text
from ffgym.core.types import Array
from ffgym.robot import RobotDescription, builtin_robots, load_robot
from ffgym.robot.reading.quantity import Quantity


@dataclass(frozen=True)
class Config:
    """Tables of robot parameters."""

    folder: Path = Path("docs/robots")
    """Where to write one page per robot."""


def page(robot: RobotDescription) -> str:
    """Markdown page of a robot."""
    lines = [
        f"# {robot.title} (`{robot.name}`)",
        "",
        "Written by `python -m scripts.robot_tables` from the description in `ffgym/robot/data`; SI units, rad.",
        "",
        "- *sourced*: published; *derived*: computed from published numbers; *chosen*: an engineering choice;",
        "- *fitted*: see [calibration](../calibration.md); prior is what it replaced.",
        "",
        "| entry | value | unit | side | origin | source |",
        "|---|---|---|---|---|---|",
    ]
    lines += [_row(path, quantity) for path, quantity in robot.quantities.items()]
    return "\n".join(lines) + "\n"


def _row(path: str, quantity: Quantity) -> str:
    value = _numbers(quantity.value)
    if quantity.prior is not None:
        value += f"<br>prior: {_numbers(quantity.prior)}"
    origin = ", ".join(quantity.origin)
    source = quantity.source.replace("|", "\\|")
    return f"| `{path}` | {value} | {quantity.unit} | {quantity.side or ''} | {origin} | {source} |"


def _numbers(value: Array) -> str:
    """Numbers to 6 digits; the rows of a matrix are separated by semicolons."""
    if value.ndim == 2:
        return "; ".join(_numbers(row) for row in value)
    return ", ".join(f"{x:.6g}" for x in np.atleast_1d(value))


def main(config: Config) -> list[Path]:
    """Write all pages."""
    paths = [config.folder / f"{name}.md" for name in builtin_robots()]
    for path in paths:
        write_text(path, page(load_robot(path.stem)))
    return paths


if __name__ == "__main__":
    main(tyro.cli(Config))
