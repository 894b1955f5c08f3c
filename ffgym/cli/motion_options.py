"""Options of the commands that run motions: demo, simulate, play, export, record."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from ffgym.cli.options import (
    RECORD_DT_MS,
    TEST_SPEEDS_MM_S,
    Cycles,
    Elastic,
    Friction,
    Gravity,
    Inputs,
    LawName,
    MachineOrRobot,
    NewFolder,
    Numbers,
    PageFile,
    Procedure,
    RowPeriod,
    Springs,
    Threads,
    Yes,
)


@dataclass(frozen=True)
class Demo:
    """Run the 36 circles with feed-forward agents, and diagnose the example logs; print the tables; write the pages."""

    agents: tuple[str, ...] = ("none", "lugre_static", "lugre_dynamic")
    """Names of docs/agents, model:<machine file>, files of laws or policies, trained rows of the leaderboard (first
    seed), families of the curve of adaptation (after one lap), or submissions (.zip). Laws that learn are trained
    first, on their standard motions."""
    parameters: Path | None = None
    """Parameter file for the agents' model of the robot; the simulated machine keeps its own numbers."""
    robot: str = "irb4600_60_205"
    """Built-in robot, a path to a description that ends in .toml, or workcell:<name or seed>."""
    report: Path = Path("report.html")
    """Report page to write; that of the diagnosis is beside it, its name ends in _diagnosis.html."""
    json: Numbers = None
    positions: tuple[str, ...] = ()
    """Positions of the work area; none given is all."""
    speeds_mm_s: tuple[float, ...] = TEST_SPEEDS_MM_S
    """TCP speeds."""
    threads: Threads = 0
    diagnosis: bool = True
    """End with a diagnosis of the example logs: those of a machine that has two faults."""
    yes: Yes = False


@dataclass(frozen=True)
class Simulate:
    """Run a motion on a simulated robot with feed-forward laws; print errors and how much of the limits is used."""

    robot: tyro.conf.Positional[str]
    """Built-in robot, a path that ends in .toml to a description or a machine file, or workcell:<name or seed>."""
    path: tyro.conf.Positional[str]
    """Built-in motion, or a file: .toml (motion), .csv (poses or joint positions), .mod or .pgf (RAPID)."""
    entry: Procedure = None
    inputs: Inputs = ()
    cycles: Cycles = 1
    feedforward: tuple[str, ...] = ("none", "lugre_dynamic")
    """Names of docs/agents, model:<machine file>, files of laws or policies, trained rows of the leaderboard (first
    seed), families of the curve of adaptation (after one lap), or submissions (.zip). Laws that learn are trained
    first, on their standard motions."""
    parameters: Path | None = None
    """Parameter file for the laws' model of the robot; the simulated machine keeps its own numbers."""
    sensors: bool = False
    """Record what resolvers and laser tracker measure, instead of the exact state; a workcell is always measured."""
    seed: int = 0
    """Seed of the sensors' noise."""
    record_dt_ms: RowPeriod = RECORD_DT_MS
    flexible: Elastic = True
    friction: Friction = True
    gravity: Gravity = True
    springs: Springs = True
    out: Path | None = None
    """Recording to write, .csv or .npz; with several laws each has its own file, and its name before the suffix."""
    report: PageFile = None
    json: Numbers = None
    threads: Threads = 0
    yes: Yes = False


@dataclass(frozen=True)
class Play:
    """Film an episode with an agent, or with two side by side; errors are magnified, the picture says how much."""

    agents: tyro.conf.Positional[tuple[str, ...]] = ()
    """One agent or two: names of docs/agents, of trained rows of the leaderboard (first seed) or of families of the
    curve of adaptation (after one lap), model:<machine file>, files of laws or policies (.npz), submissions (.zip);
    none given is that of --law."""
    out: Path = Path("episode.mp4")
    """Video to write, .mp4 or .gif; or .png, one picture at the time of the largest error."""
    at: float | None = None
    """Time of the picture in the episode [s] (.png only); none given is that of the largest error."""
    window: bool = False
    """Show the episode in a window, and write no video."""
    env: str = "ffgym/CirclePath-v0"
    """Id of the environment."""
    robot: str | None = None
    """Built-in robot, a path that ends in .toml to a description or a machine file, or workcell:<name or seed>; none
    given is the environment's own."""
    law: Literal["none", "lugre_static", "lugre_dynamic"] = "none"
    """Feed-forward law where no agent is named, with the friction parameters that the robot's controller knows."""
    path: str | None = None
    """Motion to follow, a name or a file as for `ffgym simulate` (ffgym/FollowPath-v0 only); none given is circles."""
    position: str | None = None
    """Position in the work area (circles only); none given is p1, in ffgym/Adapt-v0 what the seed draws."""
    speed_mm_s: float | None = None
    """TCP speed (circles only); none given is 40 mm/s, in ffgym/Adapt-v0 what the seed draws."""
    radii_mm: tuple[float, ...] = ()
    """Circle radii (circles only); none given is all of the test."""
    frequency_hz: float | None = None
    """Frequency of the sine (one axis only); none given is 1 Hz."""
    magnify: float | None = None
    """Factor on the drawn error; none given is one that suits the motion."""
    playback: float = 0.5
    """Speed of the video: 1 is real time, 0.1 ten times slower."""
    fps: float = 25.0
    """Pictures per second of the video."""
    width: int = 960
    """Width of the picture [pixel]."""
    height: int = 540
    """Height of the picture [pixel]."""
    seed: int = 0
    """Seed of everything that the environment draws."""
    json: Path | None = None
    """Also write return, length, errors and origin to this file."""
    yes: Yes = False


@dataclass(frozen=True)
class Export:
    """Write a folder with the robot's model as MJCF; with a motion, also its set-points, reference and recording."""

    robot: tyro.conf.Positional[MachineOrRobot]
    path: tyro.conf.Positional[str | None] = None
    """Built-in motion, or a file: .toml (motion), .csv (poses or joint positions), .mod or .pgf (RAPID); none is the
    model."""
    entry: Procedure = None
    inputs: Inputs = ()
    cycles: Cycles = 1
    out: NewFolder = Path("export")
    feedforward: LawName = "none"
    parameters: Path | None = None
    """Parameter file for the law's model of the robot; the exported machine keeps its own numbers."""
    sides: Literal["both", "motor", "link"] = "both"
    """Side of the gearbox of the quantities in reference.csv."""
    angles: Literal["rad", "deg", "turn"] = "rad"
    """Unit of angles in reference.csv."""
    binary: bool = False
    """Also write model.mjb, which loads faster, in this version of MuJoCo only."""
    record_dt_ms: RowPeriod = RECORD_DT_MS
    flexible: Elastic = True
    friction: Friction = True
    gravity: Gravity = True
    springs: Springs = True
    json: Path | None = None
    """Also write where the files come from to this file."""
    threads: Threads = 0
    yes: Yes = False


@dataclass(frozen=True)
class Record:
    """Run measurement protocols on a machine; write one recording for each motion, and an index of them."""

    robot: tyro.conf.Positional[str | None] = None
    """Built-in robot, a path that ends in .toml to a description or a machine file, or workcell:<name or seed>."""
    protocols: tyro.conf.Positional[tuple[str, ...]] = ()
    """Names of protocols, motion files (.toml, .csv, .mod), or .toml files that list steps (docs/protocols.md)."""
    listing: Annotated[bool, tyro.conf.arg(name="list")] = False
    """Show the protocols, how long they take and what they serve, and record nothing."""
    out: Path | None = None
    """Folder for the recordings; it is made if there is none. What is complete in it is not made again."""
    joints: tuple[str, ...] = ()
    """Joints that the protocols move; none given is all."""
    feedforward: LawName = "none"
    parameters: Path | None = None
    """Parameter file for the law's model of the robot; the machine keeps its own numbers."""
    seed: int = 0
    """Seed of the sensors' noise."""
    exact: bool = False
    """Record the exact state of a simulated robot, with what no machine knows, instead of what sensors measure."""
    torque_noise_percent: float = 0.0
    """White noise of the measured torque, in percent of each drive's peak torque."""
    later_min: float = 0.0
    """Time by which the session begins later in the day than the machine is set up for; a machine that warms up is
    warmer then."""
    record_dt_ms: RowPeriod = RECORD_DT_MS
    format: Literal["npz", "csv"] = "npz"
    """Format of the recordings."""
    force: bool = False
    """Make recordings again that are complete, and write over those of another session."""
    json: Path | None = None
    """Also write what was recorded to this file."""
    threads: Threads = 0
    yes: Yes = False
