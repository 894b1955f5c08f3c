"""Options of the commands that talk to controllers in real time: stream, emulate."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from ffgym.cli.options import (
    ColumnMap,
    Cycles,
    Inputs,
    LawName,
    LawParameters,
    MachineOrRobot,
    Numbers,
    Procedure,
    Threads,
    Yes,
)

ProtocolName = Literal["egm", "rsi", "rsi_12ms", "rtde", "rtde_torque", "ros2", "ros2_effort"]
"""Protocols, as ffgym.deployment has them."""


@dataclass(frozen=True)
class Stream:
    """Send a plan of set-points to a robot controller, within a safety envelope; write what was sent and measured."""

    plan: tyro.conf.Positional[Path]
    """Plan of set-points, .npz."""
    protocol: ProtocolName = "egm"
    """egm: ABB Externally Guided Motion; rsi and rsi_12ms: KUKA Robot Sensor Interface, cycle of 4 or 12 ms; rtde and
    rtde_torque: Universal Robots, positions by servoj or torques by direct_torque; ros2 and ros2_effort: ROS 2 joint
    trajectory controller, positions alone or with effort."""
    address: str | None = None
    """Address of this computer that the controller sends to, host:port; absent is every address, usual port. For
    rtde that of the robot; for ros2 the topic of the controller."""
    robot: str | None = None
    """Built-in robot or path to a description, for gear ratios and limits; absent is the robot that the plan names."""
    out: Path | None = None
    """Recording to write, .npz or .csv."""
    json: Numbers = None
    largest_mrad: float = 2.0
    """Largest correction of a joint; mm on linear axes."""
    largest_rate_mrad_s: float = 500.0
    """Fastest change of a correction; mm/s on linear axes."""
    largest_acceleration_rad_s2: float = 100.0
    """Fastest change of that rate; m/s^2 on linear axes."""
    patience_ms: float | None = None
    """Silence of the controller after which the correction begins to leave; absent is 10, with rsi_12ms 16."""
    ramp_ms: float | None = None
    """Time in which it leaves then; with the patience 20 ms at most. Absent is 10, or what the patience leaves."""
    fade_ms: float = 200.0
    """Time in which it leaves at the end of the plan, or after Ctrl-C."""
    start_tolerance_mrad: float = 2.0
    """Largest distance of the measured pose from the first pose of the plan; mm on linear axes."""
    wait_s: float = 30.0
    """Time to wait for the controller."""


@dataclass(frozen=True)
class PlanSetpoints:
    """Plan the set-points of a motion, corrected so that the servos give the torque of a feed-forward law.

    Without a motion it is the one that shows delay and filter of a controller: all joints move a little, up to 15 Hz.
    """

    robot: tyro.conf.Positional[str]
    """Built-in robot, or a path that ends in .toml to a description or a machine file: servo and gears of the
    controller."""
    path: tyro.conf.Positional[str | None] = None
    """Built-in motion, or a file: .toml (motion), .csv (poses or joint positions), .mod (RAPID)."""
    entry: Procedure = None
    inputs: Inputs = ()
    cycles: Cycles = 1
    out: Path = Path("plan.npz")
    """Plan to write, .npz."""
    feedforward: LawName = "elastic"
    parameters: LawParameters = None
    controller: Path | None = None
    """Delay and filter of the controller, .toml, and gains of its servo if it has them, as ffgym identify controller
    writes them; absent is no delay, and gains of the description."""
    gains: Literal["controller", "description"] = "controller"
    """Gains of the servo: those of the file of the controller where it has any, or of the description in any case."""
    sends: Literal["positions", "corrections"] = "positions"
    """positions: whole set-points, which all arrive late (EGM, RTDE, ROS 2); corrections: what is added to a program
    that the controller runs by itself, sent early by its delay (RSI)."""
    controller_feedforward: Literal["setpoints", "program", "none"] = "setpoints"
    """What the controller computes its rigid feed-forward from: set-points with their corrections, its own program
    alone, or nothing."""
    largest_mrad: float | None = None
    """Largest correction of a joint, to which the plan is cut; mm on linear axes; absent is no limit."""
    largest_speed_rad_s: float = 0.15
    """Largest joint speed of the motion that shows delay and filter, link side; m/s on linear axes."""
    seconds: float = 4.0
    """Length of that motion."""
    seed: int = 0
    """Seed of that motion."""
    json: Numbers = None
    threads: Threads = 0
    yes: Yes = False


@dataclass(frozen=True)
class IdentifyController:
    """Identify delay and smoothing filter of a controller from set-points that were sent and measured motor angles.

    Where the torque of the motors was recorded, too, the gains of the servo are found.
    """

    logs: tyro.conf.Positional[tuple[Path, ...]]
    """Recordings, .npz or .csv, as ffgym stream writes them; files of other tools with --columns."""
    robot: str
    """Built-in robot, or a path to a description that ends in .toml."""
    columns: ColumnMap = None
    controller_feedforward: Literal["setpoints", "none"] = "setpoints"
    """What the torque has beside that of the servo: rigid feed-forward that the controller computes from set-points, or
    nothing; for gains."""
    out: Path | None = None
    """File of the controller to write, .toml."""
    json: Numbers = None
    threads: Threads = 0


@dataclass(frozen=True)
class Emulate:
    """Emulate a robot controller with a simulated robot behind it, until a stream has come and gone."""

    protocol: tyro.conf.Positional[ProtocolName]
    """egm: ABB Externally Guided Motion; rsi and rsi_12ms: KUKA Robot Sensor Interface, cycle of 4 or 12 ms; rtde and
    rtde_torque: Universal Robots, positions by servoj or torques by direct_torque; ros2 and ros2_effort: ROS 2 joint
    trajectory controller, positions alone or with effort."""
    robot: MachineOrRobot = "irb4600_60_205"
    plan: Path | None = None
    """Plan of set-points at whose first pose the robot stands, and whose program a controller runs that gets
    corrections alone (rsi); absent is the robot's home, or 0 if it has none."""
    log: Path | None = None
    """Stream the plan to the emulator at once, without network and clock, and write the log of the stream, .npz or
    .csv; absent waits for ffgym stream."""
    torque: bool = False
    """Write the torque of the motors into the log, too, as a logger of the drives measures it."""
    address: str | None = None
    """Address of the stream, host:port; absent is this computer, usual port. For rtde that of the emulator; for
    ros2 the topic."""
    delay_ms: float = 9.3
    """Time from a set-point to the servo; at least a cycle."""
    cutoff_hz: float | None = None
    """Cut-off or natural frequency of the controller's filter; absent is no filter."""
    damping: float | None = None
    """Damping ratio of a filter of second order; absent is one of first order."""
    feedforward: Literal["setpoints", "program", "none"] = "setpoints"
    """What the controller computes its rigid feed-forward from: all of the set-points, its own program alone (rsi), or
    nothing."""
    missing: Literal["hold", "extrapolate"] = "hold"
    """What the controller does in a cycle without a set-point."""
    viscous_scale: float = 0.0
    """Share of viscous friction that direct_torque compensates (rtde_torque)."""
    coulomb_scale: float = 0.0
    """Share of Coulomb friction that direct_torque compensates (rtde_torque)."""
    drop: float = 0.0
    """Share of packets that are lost, each way."""
    corrupt: float = 0.0
    """Share of packets with wrong bytes."""
    duplicate: float = 0.0
    """Share of packets that arrive twice."""
    late: float = 0.0
    """Share of packets that arrive up to 20 ms later, and are overtaken."""
    latency_ms: float = 0.0
    """Delay of every packet."""
    jitter_ms: float = 0.0
    """Further delay, evenly between 0 and this."""
    seed: int = 0
    """Seed of the faults."""
    longest_s: float = 600.0
    """Time after which the emulator ends in any case."""
    out: Annotated[Path | None, tyro.conf.arg(help="Recording of the true states to write, .npz or .csv.")] = None
    json: Numbers = None
