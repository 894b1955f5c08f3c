"""Record the logs that `ffgym diagnose` takes if it is given none: a workcell with two faults that its model lacks.

python -m scripts.example_logs
"""

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path

import numpy as np
import tyro

from ffgym.core.files import write_bytes
from ffgym.diagnosis.nominal import EXAMPLE_ROBOT
from ffgym.effects.drive.offset import TorqueOffset
from ffgym.effects.measurement.tool_frame import ToolFrame
from ffgym.recordings import Recording
from ffgym.recordings.npz import HEADER_KEY
from ffgym.robot import RigidArm, load_robot
from ffgym.simulation.plant import Climate
from ffgym.simulation.protocols import plan_session, record
from ffgym.simulation.protocols.mixtures import DiagnosisMotions
from ffgym.workcell import SealedMachine, Workcell, workcell
from ffgym.workcell.equations import GearLosses, TorqueRipple
from scripts.exam.draw import TOOL_OFFSET, TORQUE_OFFSET, miscalibrate

SAMPLE_TIME = 0.004
"""Sample time of the logs [s]: that of the thesis' robot."""

KEPT = ("motor.position", "motor.effort", "reference.position", "feedback.effort", "tcp.position", "temperature")
"""Families of columns that stay; a diagnosis needs no others."""

STEPS = {"motor.effort": 2.0**-10, "feedback.effort": 2.0**-12, "tcp.position": 2.0**-20, "temperature": 2.0**-5}
"""Steps to which numbers are rounded, in SI units and degC: a twentieth of the sensor's noise or less. Powers of two,
which single precision holds exactly and which compress well. What is left alone is rounded to single precision, for
motor angles a tenth of the resolver's step."""


@dataclass(frozen=True)
class Config:
    """Example logs."""

    out: Path = Path("ffgym/diagnosis/data")
    """Folder of the package in which they lie."""
    seed: int = 7
    """Seed of the errors of calibration, and of the sensors' noise."""


def example_cell(seed: int) -> Workcell:
    """A machine that was identified with care, but whose shoulder gear loses torque and whose fifth motor ripples.

    Neither is in an equation of `ffgym.effects`: losses differ by direction of power, ripple has a second harmonic.
    """
    robot, rng = load_robot(EXAMPLE_ROBOT), np.random.default_rng(seed)
    machine = SealedMachine(
        label="example",
        robot=miscalibrate(robot, rng),
        effects=(
            TorqueOffset.on(robot, offset=TORQUE_OFFSET * robot.friction.coulomb * rng.standard_normal(robot.n_joints)),
            ToolFrame.on(robot, offset=TOOL_OFFSET * rng.standard_normal(3)),
            GearLosses.on(robot, "j2", driving=0.03, driven=0.04),
            TorqueRipple.on(robot, "j5", share=0.04, cycles=6.0, phase=0.9),
        ),
        climate=Climate(ambient=22.0, rise=np.full(robot.n_joints, 14.0), time_constant=1500.0, running_since=7200.0),
    )
    title = "a machine that its model describes but for two faults"
    sensors = workcell("thesis").sensors
    return Workcell(
        name="example", title=title, controller=robot.name, arm=RigidArm(robot), machine=machine, sensors=sensors
    )


def recordings(seed: int, only: Collection[int] | None = None) -> Iterator[Recording]:
    """Logs of the first recording of a machine, or some of them, as they are kept."""
    cell = example_cell(seed)
    motions = plan_session(cell.arm, [DiagnosisMotions()])
    for recording in record(motions, cell, seed=seed, record_dt=SAMPLE_TIME, only=only):
        # columns that stay, in steps where there are any, as single precision holds them
        columns = {"timestamp": recording.t}
        for family in KEPT:
            for name in (name for name in recording.columns if name.startswith(f"{family}.")):
                values, step = recording[name], STEPS.get(family)
                rounded = values if step is None else np.round(values / step) * step
                columns[name] = rounded.astype(np.float32).astype(np.float64)
        yield Recording(columns, replace(recording.header, provenance={"simulated": True}))


def encode(recording: Recording) -> bytes:
    """Bytes of a compressed NPZ file in single precision; the clock stays in double."""
    columns = {n: v if n == "timestamp" else v.astype(np.float32) for n, v in recording.columns.items()}
    buffer = BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **{HEADER_KEY: np.array(recording.header.to_json())}, **columns)
    return buffer.getvalue()


def main(config: Config) -> list[Path]:
    """Record and write."""
    places = []
    for recording in recordings(config.seed):
        place = config.out / f"{recording.header.segment.split('.')[-1]}.npz"
        write_bytes(place, encode(recording))
        places.append(place)
    return places


if __name__ == "__main__":
    main(tyro.cli(Config))
