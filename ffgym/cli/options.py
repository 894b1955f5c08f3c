"""Options that several commands have; a command's own stand in `motion_options`, `log_options`, `learning_options`.

These modules import nothing that computes, so that `--help` is quick; defaults that the library has too are compared
with it by a test.
"""

from pathlib import Path
from typing import Annotated

import tyro

from ffgym.paths import SPEEDS

Numbers = Annotated[Path | None, tyro.conf.arg(help="Also write every number to this file.")]
"""Option `--json`."""

PageFile = Annotated[
    Path | None, tyro.conf.arg(help="Page with pictures to write, .html, in one file that can be sent.")
]
"""Option `--report`."""

Threads = Annotated[
    int, tyro.conf.arg(help="Threads of the simulation, 0 for all cores; results are the same at any number.")
]
"""Option `--threads`."""

ColumnMap = Annotated[
    str | None,
    tyro.conf.arg(help="Column map for files of other tools: a built-in name, or a file that ends in .toml."),
]
"""Option `--columns`."""

RowPeriod = Annotated[float, tyro.conf.arg(help="Time between the rows of a recording.")]
"""Option `--record-dt-ms`."""

Procedure = Annotated[
    str | None, tyro.conf.arg(help="Procedure of a RAPID program to run; none is main, or the only one.")
]
"""Option `--entry`."""

Inputs = Annotated[
    tuple[str, ...],
    tyro.conf.arg(help="Values of inputs of a RAPID program, NAME=VALUE each; others are 0 until it waits for them."),
]
"""Option `--inputs`."""

Cycles = Annotated[int, tyro.conf.arg(help="Passes through a loop of a RAPID program that never ends.")]
"""Option `--cycles`."""

MachineOrRobot = Annotated[
    str,
    tyro.conf.arg(help="Built-in robot, or a path that ends in .toml to a description or a machine file."),
]
"""Robot of a command that takes machines, too."""

MotionFile = Annotated[
    str,
    tyro.conf.arg(help="Built-in motion, or a file: .toml (motion), .csv (poses or joint positions), .mod (RAPID)."),
]
"""Motion of a command."""

LawName = Annotated[
    str,
    tyro.conf.arg(
        help="Name of docs/agents, or file of a learned law. One that learns is trained first, on its standard motions."
    ),
]
"""Option `--feedforward`."""

LawParameters = Annotated[Path | None, tyro.conf.arg(help="Parameter file for the law's model of the robot.")]
"""Option `--parameters`."""

NewFolder = Annotated[Path, tyro.conf.arg(help="Folder to write; it must be empty or not exist.")]
"""Option `--out` of a command that writes a folder."""

Yes = Annotated[bool, tyro.conf.arg(help="Begin without a question, however long it takes.")]
"""Option `--yes`."""

Elastic = Annotated[bool, tyro.conf.arg(help="Elastic joints; no-flexible makes them rigid.")]
"""Option `--flexible`."""

Friction = Annotated[bool, tyro.conf.arg(help="Friction; no-friction leaves it out.")]
"""Option `--friction`."""

Gravity = Annotated[bool, tyro.conf.arg(help="Gravity; no-gravity leaves it out.")]
"""Option `--gravity`."""

Springs = Annotated[
    bool, tyro.conf.arg(help="Springs between links, e.g. a counterbalance; no-springs leaves them out.")
]
"""Option `--springs`."""

RECORD_DT_MS = 1.0
"""Time between the rows of a recording [ms], as the library has it."""

TEST_SPEEDS_MM_S = tuple(speed * 1e3 for speed in SPEEDS)
"""Speeds of the circles of the thesis [mm/s]."""
