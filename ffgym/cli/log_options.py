"""Options of the commands that read robots and logs: robot, log, identify, diagnose, improve."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import tyro

from ffgym.cli.options import TEST_SPEEDS_MM_S, ColumnMap, Numbers, PageFile, Threads, Yes


@dataclass(frozen=True)
class NewRobot:
    """Write a commented table for the arm of an MJCF or URDF file: what is known, and a place for what is not."""

    arm: tyro.conf.Positional[Path]
    """MJCF (.xml) or URDF (.urdf) file."""
    out: Path = Path("my_robot.toml")
    """Description to write, .toml; its name is the robot's name."""
    joints: tuple[str, ...] = ()
    """Joints that move, from the base outwards; none given is all. Others, e.g. a gripper's, are held."""
    tool_frame: str | None = None
    """Frame of the last link (site, body or fixed link) that is tool0; none given takes one with a usual name."""
    looks: bool = True
    """Take shapes and meshes; with no-looks, missing meshes do not matter."""
    force: bool = False
    """Write over a file that is there."""


@dataclass(frozen=True)
class FillRobot:
    """Fill in what a description lacks and what follows from the rest by rules of thumb; say which."""

    robot: tyro.conf.Positional[Path]
    """Description, .toml; it is written again, with all that is in it."""


@dataclass(frozen=True)
class CheckRobot:
    """Print what is there, what is missing and what works; reach, resonances, loads, margins, and doubtful numbers."""

    robot: tyro.conf.Positional[str]
    """Built-in robot, or a path to a description that ends in .toml, complete or not."""
    report: PageFile = None
    json: Numbers = None


@dataclass(frozen=True)
class ListColumns:
    """List the arrays in a file with shapes, types and ranges; write a draft of a column map to fill in."""

    log: tyro.conf.Positional[Path]
    """CSV or other text, NPZ, MAT, HDF5, Parquet, MCAP or rosbag file; a folder of a rosbag or a LeRobot data set."""
    out: Path | None = None
    """Draft to write, .toml."""
    force: bool = False
    """Write over a file that is there."""
    delimiter: str | None = None
    """Separator of cells in a text file; none given takes the one of the first row."""
    decimal: str = "."
    """Decimal sign of a text file: point or comma."""
    encoding: str = "utf-8-sig"
    """Encoding of a text file, e.g. latin-1."""
    names_row: int | None = None
    """Line of a text file with the names of columns, from 1, 0 for none; none given takes the first that is text."""
    units_row: int | None = None
    """Line of a text file with units, which is skipped."""
    json: Path | None = None
    """Also write what the file holds to this file."""


@dataclass(frozen=True)
class ConvertLog:
    """Make recordings of the motions in a file, as a column map says what it holds."""

    log: tyro.conf.Positional[Path]
    """CSV or other text, NPZ, MAT, HDF5, Parquet, MCAP or rosbag file; a folder of a rosbag or a LeRobot data set."""
    columns: str
    """Column map: a built-in name, or a file that ends in .toml; `ffgym log columns` writes a draft."""
    out: Path
    """Recording to write, .npz or .csv; with several motions each has its own file, its name before the suffix."""
    robot: str | None = None
    """Built-in robot, or a description (.toml), for a map that names none."""
    json: Path | None = None
    """Also write what was converted to this file."""


@dataclass(frozen=True)
class CheckLogs:
    """Judge clock, columns, units, torque, tracker and coverage of logs; fails if one is insufficient."""

    logs: tyro.conf.Positional[tuple[str, ...]]
    """Recordings (.npz, .csv) or folders of them; files of other tools with --columns."""
    robot: str | None = None
    """Built-in robot, or a description (.toml); without it, or if it lacks entries, nothing is judged that hangs on
    masses, ranges or limits."""
    columns: ColumnMap = None
    needs: tuple[str, ...] = ()
    """Uses that the logs must serve, e.g. friction tracker temperature; see docs/quality.md."""
    figures: bool = False
    """Also print every figure beside its limit, and what was not judged."""
    report: Path | None = None
    """Page with a picture to write, .html, in one file that can be sent."""
    json: Path | None = None
    """Also write every finding to this file."""


@dataclass(frozen=True)
class Identify:
    """Identify parameters from logs; print them beside the old ones, with intervals, and how well they hold."""

    logs: tyro.conf.Positional[tuple[Path, ...]]
    """Recordings, .npz or .csv, or folders of them; files of other tools with --columns."""
    robot: str
    """Built-in robot, or a path to a description that ends in .toml, as it is known before."""
    out: Path | None = None
    """Parameter file to write, .toml."""
    what: Literal["friction", "rigid_body"] = "friction"
    """friction: LuGre parameters of all joints. rigid_body: masses, rotors, Coulomb and viscous friction, offsets; the
    robot may lack masses."""
    columns: ColumnMap = None
    validate: tuple[Path, ...] = ()
    """Recordings or folders that are not used but tell how well old and new parameters hold. Those among the logs are
    kept out."""
    joints: tuple[str, ...] = ()
    """Joints to identify; none given is all."""
    stribeck_velocity: float | None = None
    """Stribeck velocity to keep on all joints, motor side [rad/s]; none given estimates it."""
    stiffness_spread: float | None = None
    """Relative standard deviation of the joint stiffness, e.g. 0.1, on which the share of friction on the arm rests;
    none given is that of the description's interval, or 0.3."""
    terms: tuple[str, ...] = ()
    """Parts of the torque that a rigid body is fitted with; none given is bodies, rotor_inertia, coulomb, viscous,
    offset. There are springs and viscous_asymmetry too."""
    spread: float | None = None
    """Distance of masses and rotors from the description, a relative standard deviation, e.g. 0.03 for CAD; none given
    is the one that predicts held-out parts of the logs best."""
    cutoff_hz: float | None = None
    """Cut-off of the low-pass filter of angles and torques, which must lie below half the sample rate; none given is
    100 Hz for friction and 5 Hz for a rigid body."""
    resamples: int = 400
    """Resamples behind the intervals."""
    level: float = 0.9
    """Probability of the intervals."""
    seed: int = 0
    """Seed of random starts and resamples."""
    unchecked: bool = False
    """Use logs that the quality gate calls insufficient."""
    json: Numbers = None
    report: PageFile = None


@dataclass(frozen=True)
class Diagnose:
    """Compare logs of a machine with its nominal model: where that is wrong, which cause explains it, how sure."""

    logs: tyro.conf.Positional[tuple[Path, ...]] = ()
    """Recordings (.npz, .csv) or folders of them, one for each motion; files of other tools with --columns. None given
    are the example logs of a machine with two faults."""
    robot: str | None = None
    """Nominal model: a built-in robot or its parameters, a description, or a machine file (.toml), such as the
    extended.toml of an earlier diagnosis."""
    columns: ColumnMap = None
    calibration: float | None = None
    """Uncertainty of the nominal numbers: their relative standard deviation. None given is 0.005, or with --fit what
    the fit says."""
    fit: bool = False
    """Fit masses, rotors and friction to the logs before, for a robot whose numbers are not known; its description may
    lack them."""
    accept: tuple[str, ...] = ()
    """Checks of quality that are overruled, e.g. coarse: a log that they refuse is used all the same, and the page says
    so. Others that are refused are left out."""
    validate: tuple[Path, ...] = ()
    """Recordings or folders that are not diagnosed: both models, read from their files if there is --out, are replayed
    along them, and run their references in closed loop where they have reference.position and the servo is known."""
    out: Path | None = None
    """Folder for report.html, diagnosis.json, extended.toml (the model with the causes), next.toml (what to record to
    tell rivals apart), and with --fit nominal.toml; it is made if there is none. Older models in it go."""
    most_causes: int = 8
    """Causes to look for; fewer take less time, and a diagnosis of the extended model finds further ones. Each wave of
    one that repeats with an angle counts."""
    seed: int = 0
    """Seed of the noise of simulated logs and of resamples."""
    json: Path | None = None
    """Also write diagnosis.json under this name."""
    threads: int = 0
    """Threads of the closed loops, 0 for all cores; results are the same at any number."""
    table: str | None = None
    """Table of measured path errors instead of logs: a file (.toml), or thesis for the 240 numbers of the thesis; see
    docs/diagnosis_tables.md. The folder of --out gets table_diagnosis.json, and a file for each structure, from which a
    run that was stopped goes on."""
    structures: tuple[str, ...] = ()
    """Structures that are fitted to the table, e.g. numbers backlash arm_friction+delay; none given is all of one
    part."""
    pairs: bool = True
    """Also fit pairs of the best three structures."""
    refits: bool = True
    """Fit each structure again without each position of the table; else one Gauss-Newton step predicts its rows, in
    less time."""
    steps: int = 8
    """Most steps of the search of each structure."""
    executor: Literal["local", "ray"] = "local"
    """Place of the fits to a table: this machine, or a Ray cluster."""
    address: str | None = None
    """Address of a running Ray cluster; none begins one on this machine."""
    jobs: int = 0
    """Fits to a table at once; 0 is one per core. Results are the same at any number."""


@dataclass(frozen=True)
class Improve:
    """Record a machine, diagnose and extend its model, in rounds; compare feed-forward from it with that of others."""

    rig: str = "workcell:thesis"
    """The machine: workcell:<name or seed>, a machine file, or a built-in robot or description."""
    robot: str | None = None
    """Nominal model to begin with: a built-in robot, a description, or a machine file; none is what the machine's
    controller knows."""
    out: Path | None = None
    """Folder for recordings, diagnoses, models and the comparison; what is complete in it is not made again."""
    fit: bool = False
    """Fit all numbers of the model to the first recordings before it is diagnosed: for a machine that is far from its
    description in many at once."""
    protocols: tuple[str, ...] = ("diagnosis",)
    """Motions in each round, as for ffgym record; what a diagnosis proposes is added to the next round."""
    rounds: int = 4
    """At most; there are fewer where a diagnosis finds nothing to add."""
    most_causes: int = 3
    """Causes that are looked for in each round, 1 to 8. Time grows with their square, and what is left the next round
    finds beside numbers that were fitted again."""
    positions: tuple[str, ...] = ()
    """Positions of the circles that laws are compared on; none given is all but the first, where protocols draw
    theirs."""
    speeds_mm_s: tuple[float, ...] = TEST_SPEEDS_MM_S
    """Speeds of these circles."""
    radii_mm: tuple[float, ...] = (1.0, 5.0)
    """Radii of these circles; protocols draw circles of 3 mm."""
    seed: int = 0
    """Seed of the sensors' noise, and of what the diagnosis draws."""
    json: Path | None = None
    """File for all numbers; none is improvement.json in the folder."""
    threads: Threads = 0
    yes: Yes = False
