"""Options of `ffgym trial`: plan, rehearse and read a randomised experiment on a machine."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import tyro

from ffgym.cli.options import ColumnMap, Numbers, PageFile, Procedure, Threads, Yes


@dataclass(frozen=True)
class PlanTrial:
    """Plan which runs go with and which without the correction, in random order; say how many show a gain."""

    robot: tyro.conf.Positional[str]
    """Built-in robot, a path that ends in .toml to a description or a machine file, or workcell:<name or seed>."""
    motions: tyro.conf.Positional[tuple[str, ...]]
    """Programs, one for each speed and place: built-in motions or files, .toml (motion), .csv (poses or joint
    positions), .mod (RAPID)."""
    entry: Procedure = None
    runs: int = 16
    """Scored runs of each program, half of them with the correction."""
    seed: int = 0
    """Seed of the order. Choose it before the first run, and no other after."""
    out: Path | None = None
    """Folder for plan.json, plan.csv, plan.html to print, and the programs; it must be empty or not exist."""
    warm_up: int = 2
    """Runs before the first pair, without the correction, which are not scored."""
    laps: int = 1
    """Passes of the program in each run; of several the first is not scored."""
    gain_percent: float = 10.0
    """Gain that is to be shown."""
    power_percent: float = 90.0
    """Probability of showing it."""
    spread_percent: float | None = None
    """Scatter of the ratios of pairs; none given is that of --pilot, or an assumed 5."""
    pilot: Path | None = None
    """Numbers of a trial before (`ffgym trial read --json`), whose spread is reckoned with."""
    json: Numbers = None
    yes: Yes = False


@dataclass(frozen=True)
class RehearseTrial:
    """Carry out a plan on a simulated machine that warms up and varies from run to run; write its logs."""

    trial: tyro.conf.Positional[Path]
    """Folder of the plan."""
    machine: str
    """workcell:<name or seed>, a machine file, or a built-in robot or description."""
    out: Path | None = None
    """Folder for the logs; none given is logs in that of the plan. It must be empty or not exist."""
    feedforward: str = "elastic"
    """The correction: a name of docs/agents, model:<machine file>, or a file of a learned law."""
    channel: Literal["torque", "setpoint"] = "torque"
    """Way of the correction to the motors: added torque, or corrected set-points."""
    parameters: Path | None = None
    """Parameter file for the law's model of the robot; the machine keeps its own numbers."""
    variation_percent: float = 2.0
    """Standard deviation of each joint's Coulomb friction from run to run."""
    pause_s: float = 10.0
    """Time between two runs."""
    later_min: float = 0.0
    """Time by which the trial begins later in the day than the machine is set up for."""
    seed: int = 0
    """Seed of what differs from run to run, and of the sensors' noise."""
    json: Numbers = None
    threads: Threads = 0
    yes: Yes = False


@dataclass(frozen=True)
class ReadTrial:
    """Read the logs of a trial; say the gain by program with interval and p-value, and what was left out and why."""

    trial: tyro.conf.Positional[Path]
    """Folder of the plan."""
    logs: tyro.conf.Positional[tuple[Path, ...]]
    """Logs or folders of them: recordings (.npz, .csv), files of other tools with --columns."""
    columns: ColumnMap = None
    without: tuple[int, ...] = ()
    """Numbers of runs to leave out, e.g. one that a collision ended; each with its pair."""
    accept: tuple[str, ...] = ()
    """Checks of quality that are overruled, e.g. coarse."""
    report: PageFile = None
    json: Numbers = None
