"""Options of the commands that write code and tables for machines without Python."""

from dataclasses import dataclass
from pathlib import Path

import tyro

from ffgym.cli.options import Numbers, Procedure, Threads


@dataclass(frozen=True)
class ExportCode:
    """Write a feed-forward law for one motion as C99, with a check that compares it with the simulation and times it.

    It is compiled and compared before it is written, and not written if a torque differs by more than 1e-9 of the
    largest one.
    """

    robot: tyro.conf.Positional[str]
    """Built-in robot, or a path that ends in .toml to a description or a machine file."""
    path: tyro.conf.Positional[str]
    """Built-in motion, or a file: .toml (motion), .csv (poses or joint positions), .mod (RAPID)."""
    entry: Procedure = None
    out: Path = Path("code")
    """Folder to write; it must be empty or not exist."""
    feedforward: str = "elastic"
    """Name of docs/agents, or file of a learned law. One that learns is trained first, on its standard motions."""
    parameters: Path | None = None
    """Parameter file for the law's model of the robot."""
    name: str = "law"
    """Begin of the names of files and C functions: lower-case letters, digits and _."""
    unchecked: bool = False
    """Write files that are not compared with the simulation, and say so; for computers without a C compiler."""
    json: Numbers = None
    threads: Threads = 0
