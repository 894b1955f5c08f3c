"""The README.txt of an exported folder."""

import os
from collections.abc import Iterable, Sequence
from dataclasses import replace
from importlib import resources
from pathlib import Path

import mujoco
import numpy as np

from ffgym.control import Setpoints
from ffgym.core.files import csv_rows, new_folder, write_text
from ffgym.core.types import Array
from ffgym.core.version import __version__
from ffgym.recordings import Recording, write_recording
from ffgym.robot import ModelOptions, RigidArm, RobotDescription
from ffgym.simulation import RECORD_DT, Run, simulate
from ffgym.simulation.export.model import (
    ReferenceForm,
    add_rest,
    control_blocks,
    control_row,
    in_engine,
    missing_text,
    plant_of,
    reference_table,
    spec_with_home,
    write_model,
)
from ffgym.simulation.plant import Machine
from ffgym.simulation.run import Progress

_MODEL = """\
model.xml      The robot in MuJoCo's MJCF: arm, elastic joints, friction, servos. All numbers have all their digits,
               so that it compiles to the simulated model bit for bit. Keyframe `home` rests in the home pose.
"""

_BINARY = """\
model.mjb      The same, compiled; loads faster, in MuJoCo {mujoco} only.
"""

_MOTION = """\
controls.csv   What goes into data.ctrl, one row per physics step of {physics_dt:g} s and one for the end; motor side.
               Start from the keyframe `start` of the model.
reference.csv  The motion every {control_dt:g} s for a drive: positions, speeds, accelerations, torques (u_ff of the
               rigid arm, u_lff added by the law, u_total their sum). Names of columns have side and unit.
recording.csv  What the simulated robot did, every {record_dt:g} s. Comment lines on top hold a header in JSON.
play.py        Plays controls.csv in plain MuJoCo and compares every row of recording.csv: python play.py
"""


def readme_text(machine: Machine, recording: Recording | None = None, *, binary: bool) -> str:
    """Describe each file of the folder; without a recording that is the model alone."""
    robot = machine.robot
    lines = [
        robot.title,
        f"Exported by ffgym {__version__}; needs MuJoCo {mujoco.__version__} and numpy, not ffgym.",
        "",
    ]
    parts = [_MODEL]
    if binary:
        parts.append(_BINARY.format(mujoco=mujoco.__version__))
    if recording is not None:
        header = recording.header
        lines[1:1] = [f"Motion: {header.segment}. Feed-forward: {header.meta['feedforward_law']}."]
        parts.append(
            _MOTION.format(
                physics_dt=header.provenance["physics_dt"],
                control_dt=robot.servo.control_dt,
                record_dt=recording.dt,
            )
        )
    if missing := missing_text(machine):
        lines[-1:-1] = [missing]
    return "\n".join(lines) + "\n" + "".join(parts)


def export_model(
    path: str | os.PathLike[str],
    robot: RobotDescription | Machine,
    *,
    options: ModelOptions | None = None,
    binary: bool = False,
) -> None:
    """Write the folder `path` with the robot's model, which rests in its home pose in keyframe `home`.

    Args:
        path: a folder that is empty or does not exist.
        robot: the robot, or a machine; what MuJoCo does not have of it is listed in the comment of the model.
        options: what to leave out of the model.
        binary: also write `model.mjb`, which loads faster, in this version of MuJoCo only.

    Raises:
        FFGymError: if the folder cannot be written, or the robot finds no equilibrium.
    """
    machine = Machine.of(robot)
    with new_folder(path) as folder:
        write_model(folder, spec_with_home(plant_of(machine, options), machine, options), binary=binary)
        write_text(folder / "README.txt", readme_text(machine, binary=binary))


def export_run(
    path: str | os.PathLike[str],
    run: Run,
    *,
    arm: RigidArm | None = None,
    machine: Machine | None = None,
    options: ModelOptions | None = None,
    form: ReferenceForm | None = None,
    binary: bool = False,
    record_dt: float = RECORD_DT,
    n_threads: int = 0,
    progress: Progress | None = None,
) -> Recording:
    """Simulate a run and write the folder `path` with all that repeats it in plain MuJoCo; returns the recording.

    Args:
        path: a folder that is empty or does not exist.
        run: the motion and its feed-forward law.
        arm: the robot's rigid dynamics, if the caller has them already.
        machine: what runs, with those of its effects that MuJoCo has; None is the robot of the reference.
        options: what to leave out of the model, or another physics step.
        form: units and sides of `reference.csv`; None is SI units on both sides.
        binary: also write `model.mjb`, which loads faster, in this version of MuJoCo only.
        record_dt: sample time of the recording [s], as in `simulate`.
        n_threads: threads of the engine, 0 for all cores; the files are the same at any number.
        progress: called now and then with the seconds of the motion that are simulated and written, and their total.

    Raises:
        FFGymError: if the folder cannot be written, or the run cannot be simulated.
    """
    physics, machine = replace(options or ModelOptions(), looks=False), machine or Machine.of(run.reference.robot)
    reference, robot = run.reference, run.reference.robot

    def report(done: float) -> None:
        if progress is not None:  # simulating and writing count the whole motion once each
            progress(done, 2 * reference.duration)

    with new_folder(path) as folder:
        (recording,) = simulate(
            [run],
            arm=arm,
            machine=in_engine(machine),
            options=physics,
            record_dt=record_dt,
            n_threads=n_threads,
            progress=lambda done, _: report(done),
        )
        # recording, and the reference with its feedforward at the control rate
        write_recording(recording, folder / "recording.csv")
        samples = slice(None, None, round(robot.servo.control_dt / recording.dt))
        u_ff, u_lff = (recording.joint_array(f"{name}.effort")[samples] for name in ("feedforward", "compensation"))
        table = reference_table(reference, u_ff, u_lff, form or ReferenceForm())
        _write_table(folder / "reference.csv", list(table), [np.stack([*table.values()], axis=1)])
        # controls of each physics step, as the servo interpolates its setpoints
        plant = plant_of(machine, options)
        setpoints = Setpoints(
            position=reference.motor_q[None],
            velocity=reference.motor_dq[None],
            torque=(u_ff + u_lff)[None],
            dt=robot.servo.control_dt,
        )
        units = {"position": "rad", "velocity": "rad/s", "torque": "N m"}
        names = [f"motor.{name}.{joint} [{unit}]" for joint in robot.joints for name, unit in units.items()]
        blocks = control_blocks(plant, setpoints, lambda done, _: report(reference.duration + done))
        _write_table(folder / "controls.csv", names, blocks)
        # model that begins at rest under its load, and a program that plays the controls
        spec = spec_with_home(plant, machine, options)
        add_rest(spec, plant, "start", reference.q[0], reference.dq[0], control_row(plant, setpoints, 0))
        write_model(folder, spec, binary=binary)
        player = resources.files("ffgym.simulation.export") / "play.py"
        write_text(folder / "play.py", player.read_text(encoding="utf-8"))
        write_text(folder / "README.txt", readme_text(machine, recording, binary=binary))
    return recording


def _write_table(path: Path, names: Sequence[str], blocks: Iterable[Array]) -> None:
    """Write a CSV file with a line of names, and blocks (rows, columns) below."""
    with path.open("w", encoding="utf-8", newline="\n") as file:
        file.write(",".join(names) + "\n")
        for block in blocks:
            file.write(csv_rows(block))
