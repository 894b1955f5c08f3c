"""What goes to controllers and comes back: plans, tables of laws, trials, controller files, programs, messages."""

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ffgym.control import SetpointResponse
from ffgym.core.types import Array
from ffgym.deployment import SetpointPlan, read_plan, write_plan
from ffgym.deployment.code.table import LawTable, read_table, write_table
from ffgym.deployment.controller_file import read_controller, read_servo, write_controller
from ffgym.deployment.streams.egm import EgmWire
from ffgym.deployment.streams.protocols import axes_of
from ffgym.deployment.streams.ros2 import Ros2Wire
from ffgym.deployment.streams.rsi import RsiWire
from ffgym.deployment.streams.rtde import RtdeWire
from ffgym.deployment.streams.wire import Feedback, JointAxes, PacketError, StreamCommand, Wire
from ffgym.deployment.trial import TrialProgram, plan_trial
from ffgym.deployment.trial.plan_files import read_trial_plan, write_trial_plan
from ffgym.recordings import Header, Phase, Recording
from ffgym.robot import RobotDescription, load_robot
from scripts.fuzz.reader import Make, Reader
from scripts.fuzz.readers.samples import Q


@cache
def _robot() -> RobotDescription:
    return load_robot("two_link")


def _plan(folder: Path) -> Path:
    correction = 1e-4 * (Q - Q[0])
    plan = SetpointPlan(
        name="line",
        robot="two_link",
        law="elastic",
        joints=_robot().joints,
        units=("rad", "rad"),
        dt=0.004,
        program=Q,
        correction=correction,
        torque=1e3 * correction,
        meta={"version": "1"},
    )
    write_plan(plan, folder / "plan.npz")
    return folder / "plan.npz"


def _law_table(suffix: str) -> Make:
    def make(folder: Path) -> Path:
        table = LawTable(joints=("j1", "j2"), dt=0.004, values={"torque [N m]": Q, "position [rad]": 2 * Q})
        write_table(table, folder / "law")
        (kept,) = [file for file in (folder / "law").iterdir() if file.suffix == suffix]
        for file in (folder / "law").iterdir():
            if file != kept:
                file.unlink()
        return kept

    return make


def _trial(folder: Path) -> Path:
    """A plan of one short program, in the folder that an operator gets."""
    t: Array = 0.004 * np.arange(200, dtype=np.float64)
    share = np.clip((t - 0.2) / 0.4, 0.0, 1.0)
    joints = 0.02 * np.stack([np.sin(np.pi * share) ** 2, np.sin(np.pi * share) ** 2], axis=1)
    columns: dict[str, Array] = {"timestamp": t}
    for j, joint in enumerate(("j1", "j2")):
        columns |= {f"reference.position.{joint}": joints[:, j]}
        columns |= {f"reference.velocity.{joint}": np.gradient(joints[:, j], 0.004)}
        columns |= {f"reference.acceleration.{joint}": np.gradient(np.gradient(joints[:, j], 0.004), 0.004)}
    columns |= {f"tcp_reference.position.{axis}": joints[:, 0] for axis in "xyz"}
    phases = (
        Phase(label="rest", kind="standstill", start=0.0, end=0.2),
        Phase(label="way", kind="motion", start=0.2, end=0.6),
    )
    header = Header(robot="two", joints=("j1", "j2"), gear_ratio=(1.0, 1.0), segment="line", phases=phases)
    program = TrialProgram(recording=Recording(columns, header))
    write_trial_plan(plan_trial("two", [program], pairs=2, seed=1), folder / "trial", "", {})
    return folder / "trial"


def _controller(folder: Path) -> Path:
    write_controller(
        folder / "controller.toml",
        SetpointResponse(delay=0.008, lag=0.01),
        source="identified",
        intervals={"delay": (0.007, 0.009)},
        servo=_robot().servo,
        joints=_robot().joints,
    )
    return folder / "controller.toml"


def _read_controller(path: Path) -> None:
    read_controller(path)
    read_servo(path, _robot())


def _packets(make_wire: Callable[[JointAxes], Wire]) -> tuple[Make, Make]:
    """Make a packet of a controller, and one to it, each with the name of its side."""
    wire, q = make_wire(_axes()), np.linspace(0.1, 0.6, 6)

    def feedback(folder: Path) -> Path:
        message = Feedback(sequence=7, time=0.5, position=q, token=7)
        (folder / "feedback.bin").write_bytes(wire.encode_feedback(message, q))
        return folder / "feedback.bin"

    def command(folder: Path) -> Path:
        message = StreamCommand(sequence=7, time=0.5, position=q, correction=0.01 * q, velocity=q, effort=q, token=7)
        (folder / "command.bin").write_bytes(wire.encode_command(message))
        return folder / "command.bin"

    return feedback, command


@cache
def _axes() -> JointAxes:
    return axes_of(load_robot("irb4600_60_205"))


def _packet_reader(name: str, make_wire: Callable[[JointAxes], Wire], covers: tuple[Callable[..., Any], ...]) -> Reader:
    def use(path: Path) -> None:
        wire, data = make_wire(_axes()), path.read_bytes() if path.is_file() else b""
        (wire.decode_feedback if path.stem == "feedback" else wire.decode_command)(data)

    return Reader(
        name=f"packets_{name}", use=use, makes=_packets(make_wire), covers=covers, share=4, errors=(PacketError,)
    )


READERS = (
    Reader(name="plan", use=read_plan, makes=(_plan,), covers=(read_plan,), share=15),
    Reader(
        name="law_table", use=read_table, makes=(_law_table(".csv"), _law_table(".bin")), covers=(read_table,), share=15
    ),
    Reader(name="trial", use=read_trial_plan, makes=(_trial,), covers=(read_trial_plan,), share=10),
    Reader(
        name="controller", use=_read_controller, makes=(_controller,), covers=(read_controller, read_servo), share=15
    ),
    _packet_reader("egm", EgmWire, (EgmWire.decode_feedback, EgmWire.decode_command)),
    _packet_reader("rsi", RsiWire, (RsiWire.decode_feedback, RsiWire.decode_command)),
    _packet_reader("rtde", RtdeWire, (RtdeWire.decode_feedback, RtdeWire.decode_command)),
    _packet_reader("ros2", Ros2Wire, (Ros2Wire.decode_feedback, Ros2Wire.decode_command)),
)
