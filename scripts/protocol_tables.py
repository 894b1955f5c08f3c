"""Write the tables of docs/protocols.md: what each protocol serves, how long it takes, and its settings.

python -m scripts.protocol_tables
"""

from dataclasses import dataclass
from pathlib import Path

import tyro

from ffgym.core.errors import FFGymError
from ffgym.core.files import write_text
from ffgym.paths.motions.parts.part import is_required
from ffgym.robot import RigidArm, load_robot
from ffgym.simulation.protocols import PROTOCOLS, Protocol
from ffgym.simulation.protocols.motion_file import MotionFile
from ffgym.simulation.protocols.protocol import settings
from ffgym.simulation.protocols.stage import Stage
from scripts.format_tables import with_tables
from scripts.motion_tables import default_text

ROBOTS = {"irb4600_60_205": "six-axis robot", "one_axis": "one axis"}
"""Robots that durations are told for, and what the heading calls them."""


@dataclass(frozen=True)
class Config:
    """Tables of the protocols."""

    page: Path = Path("docs/protocols.md")
    """Page that holds the tables, each between a comment with its name and an empty comment."""


def purposes_table() -> str:
    """Markdown table of all protocols with their purposes and durations."""
    arms = [RigidArm(load_robot(robot)) for robot in ROBOTS]
    lines = [f"| protocol | serves | {' | '.join(ROBOTS.values())} |", "|---|---|---|---|"]
    for name, protocol in PROTOCOLS.items():
        sizes = " | ".join(_size(protocol, arm) for arm in arms)
        lines.append(f"| [`{name}`](#{name}) | {protocol.purpose} | {sizes} |")
    return "\n".join(lines)


def settings_tables() -> str:
    """Markdown tables of the settings of each protocol, and of a motion in a file of steps."""
    protocols: list[type[Protocol]] = [*PROTOCOLS.values(), MotionFile]
    return "\n\n".join(_settings(protocol) for protocol in protocols)


def filled(page: str) -> str:
    """Return the page with its tables as they are now."""
    return with_tables(page, {"purposes": purposes_table(), "settings": settings_tables()})


def _size(protocol: type[Protocol], arm: RigidArm) -> str:
    try:
        motions = protocol().motions(Stage(arm=arm))
    except FFGymError:
        return ""
    return f"{len(motions)}: {sum(motion.reference.duration for motion in motions):.0f} s"


def _settings(protocol: type[Protocol]) -> str:
    assert protocol.__doc__ is not None
    summary = protocol.__doc__.split("\n    Reference:")[0]
    lines = [f"### {protocol.name}", "", " ".join(summary.split()), ""]
    lines += ["| setting | unit | default | meaning |", "|---|---|---|---|"]
    for f in settings(protocol):
        default = "required" if is_required(f) else default_text(f)
        lines.append(f"| `{f.name}` | {f.metadata['unit']} | {default} | {f.metadata['meaning']} |")
    return "\n".join(lines)


def main(config: Config) -> Path:
    """Write the tables into the page."""
    write_text(config.page, filled(config.page.read_text(encoding="utf-8")))
    return config.page


if __name__ == "__main__":
    main(tyro.cli(Config))
