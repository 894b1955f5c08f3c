"""Options of the commands that write code and tables for machines without Python."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import tyro

from ffgym.cli.options import (
    Cycles,
    Inputs,
    LawName,
    LawParameters,
    MachineOrRobot,
    MotionFile,
    NewFolder,
    Numbers,
    Procedure,
    Threads,
    Yes,
)


@dataclass(frozen=True)
class ExportCode:
    """Write a feed-forward law for one motion as C99, with a check that compares it with the simulation and times it.

    It is compiled and compared before it is written, and not written if a torque differs by more than 1e-9 of the
    largest one.
    """

    robot: tyro.conf.Positional[MachineOrRobot]
    path: tyro.conf.Positional[MotionFile]
    entry: Procedure = None
    inputs: Inputs = ()
    cycles: Cycles = 1
    out: NewFolder = Path("code")
    feedforward: LawName = "elastic"
    parameters: LawParameters = None
    name: str = "law"
    """Begin of the names of files and C functions: lower-case letters, digits and _."""
    unchecked: bool = False
    """Write files that are not compared with the simulation, and say so; for computers without a C compiler."""
    json: Numbers = None
    threads: Threads = 0
    yes: Yes = False


@dataclass(frozen=True)
class ExportPolicy:
    """Write a residual policy as ONNX, its scaling and memory inside: physical readings in, torque out.

    It is compared with the simulation in closed loop along a motion, and not written if a torque differs by more than
    1e-6 of the policy's largest one.
    """

    policy: tyro.conf.Positional[str]
    """Trained policy of docs/agents, or file of a policy (.npz) that `ffgym train policy` wrote."""
    out: Path = Path("policy.onnx")
    """File to write."""
    robot: str = "irb4600_60_205"
    """Built-in robot, or a path that ends in .toml to a description: the robot that the controller knows."""
    motion: str = "circles"
    """Built-in motion or file along which it is compared."""
    single: bool = False
    """Compute with numbers of 32 bits, for runtimes that have no others."""
    json: Numbers = None


@dataclass(frozen=True)
class ExportTable:
    """Write torque and correction along one motion as tables: CSV, and a binary file with a reader in C."""

    robot: tyro.conf.Positional[str | None] = None
    """Built-in robot, or a path that ends in .toml to a description or a machine file."""
    path: tyro.conf.Positional[str | None] = None
    """Built-in motion, or a file: .toml (motion), .csv (poses or joint positions), .mod (RAPID)."""
    plan: Path | None = None
    """Plan of set-points (.npz), in place of robot, motion and law."""
    entry: Procedure = None
    inputs: Inputs = ()
    cycles: Cycles = 1
    out: NewFolder = Path("table")
    feedforward: LawName = "elastic"
    parameters: LawParameters = None
    json: Numbers = None
    threads: Threads = 0
    yes: Yes = False


@dataclass(frozen=True)
class ExportFmu:
    """Write a robot under its servos, and a program with its feed-forward law, as FMUs for co-simulation.

    FMPy validates them; they are run along the motion, and not written if a number differs from the simulation by more
    than 1e-9 in SI units.
    """

    robot: tyro.conf.Positional[MachineOrRobot]
    path: tyro.conf.Positional[MotionFile]
    entry: Procedure = None
    inputs: Inputs = ()
    cycles: Cycles = 1
    out: NewFolder = Path("fmu")
    feedforward: LawName = "elastic"
    parameters: Path | None = None
    """Parameter file for the law's model of the robot; the plant keeps its own numbers."""
    fmi: tuple[Literal["2.0", "3.0"], ...] = ("2.0", "3.0")
    """Versions of the standard."""
    program: bool = True
    """Program with its law, beside the robot; no-program leaves it out, for laws that have no form in C."""
    json: Numbers = None
    threads: Threads = 0
    yes: Yes = False


@dataclass(frozen=True)
class ExportProgram:
    """Write a plan of set-points as a corrected program for a controller, with a report of what was changed.

    The files are read back and compared with the plan, and not written if the tool would leave it by more than the
    tolerance.
    """

    plan: tyro.conf.Positional[Path]
    """Plan of set-points (.npz)."""
    robot: str | None = None
    """Built-in robot, or a path that ends in .toml to a description or a machine file; none given is the plan's."""
    format: Literal["rapid", "krl", "urscript", "csv"] = "rapid"
    """Language of the controller."""
    out: NewFolder = Path("program")
    tolerance_mm: float = 0.01
    """Largest distance of the tool from the plan."""
    period_ms: float | None = None
    """Time that points of RAPID and KRL are apart at least; none given leaves it to the path."""
    lookahead_time: float = 0.03
    """Smoothing of servoj [s], 0.03 to 0.2 (URScript only)."""
    gain: float = 2000.0
    """Gain of servoj, 100 to 2000 (URScript only)."""
    json: Numbers = None
