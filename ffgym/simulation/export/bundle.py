"""What an exported folder holds, and that it appears whole or not at all."""

import os
from collections.abc import Iterable, Sequence
from dataclasses import replace
from importlib import resources
from pathlib import Path

import numpy as np

from ffgym.core.files import csv_rows, new_folder, write_text
from ffgym.core.types import Array
from ffgym.paths import Reference
from ffgym.recordings import Recording, write_recording
from ffgym.robot import ModelOptions, RigidArm, RobotDescription
from ffgym.simulation import RECORD_DT, Run, simulate
from ffgym.simulation.export.controls import control_blocks, control_names, control_row, setpoints_of
from ffgym.simulation.export.model import add_rest, in_engine, plant_of, spec_with_home, write_model
from ffgym.simulation.export.readme import readme_text
from ffgym.simulation.export.reference_tables import ReferenceForm, reference_table
from ffgym.simulation.plant import Machine
from ffgym.simulation.run import Progress


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
    with new_folder(path) as folder:
        simulating, writing = _halves(progress, run.reference.duration)
        (recording,) = simulate(
            [run],
            arm=arm,
            machine=in_engine(machine),
            options=physics,
            record_dt=record_dt,
            n_threads=n_threads,
            progress=simulating,
        )
        write_recording(recording, folder / "recording.csv")
        torque = _write_reference(folder, run.reference, recording, form or ReferenceForm())
        plant, setpoints = plant_of(machine, options), setpoints_of(run.reference, torque)
        _write_table(folder / "controls.csv", control_names(plant.robot), control_blocks(plant, setpoints, writing))
        spec = spec_with_home(plant, machine, options)
        add_rest(spec, plant, "start", run.reference.q[0], run.reference.dq[0], control_row(plant, setpoints, 0))
        write_model(folder, spec, binary=binary)
        player = resources.files("ffgym.simulation.export") / "play.py"
        write_text(folder / "play.py", player.read_text(encoding="utf-8"))
        write_text(folder / "README.txt", readme_text(machine, recording, binary=binary))
    return recording


def _write_reference(folder: Path, reference: Reference, recording: Recording, form: ReferenceForm) -> Array:
    """Write `reference.csv`; returns the sum of all feed-forward torques at its samples, motor side [N m], (T, N)."""
    samples = slice(None, None, round(reference.robot.servo.control_dt / recording.dt))
    u_ff, u_lff = (recording.joint_array(f"{name}.effort")[samples] for name in ("feedforward", "compensation"))
    table = reference_table(reference, u_ff, u_lff, form)
    _write_table(folder / "reference.csv", list(table), [np.stack([*table.values()], axis=1)])
    return u_ff + u_lff


def _halves(progress: Progress | None, duration: float) -> tuple[Progress, Progress]:
    """Progress of simulating and of writing, where each counts the whole motion once."""

    def report(done: float) -> None:
        if progress is not None:
            progress(done, 2 * duration)

    return lambda done, _: report(done), lambda done, _: report(duration + done)


def _write_table(path: Path, names: Sequence[str], blocks: Iterable[Array]) -> None:
    """Write a CSV file with one line of names and blocks (rows, columns) below each other."""
    with path.open("w", encoding="utf-8", newline="\n") as file:
        file.write(",".join(names) + "\n")
        for block in blocks:
            file.write(csv_rows(block))
