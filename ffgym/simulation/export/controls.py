"""What goes into `data.ctrl` at every physics step of a motion."""

from collections.abc import Iterator

import numpy as np

from ffgym.control import Setpoints
from ffgym.core.types import Array
from ffgym.paths import Reference
from ffgym.robot import RobotDescription
from ffgym.simulation.plant import Plant
from ffgym.simulation.run import Progress

_CHUNK = 256
"""Control steps in one block: chosen, so that a block takes a few MB at most and progress is seen."""


def setpoints_of(reference: Reference, torque: Array) -> Setpoints:
    """Samples that the drives get: the reference, and the sum of all feed-forward torques, motor side [N m], (T, N)."""
    return Setpoints(
        position=reference.motor_q[None],
        velocity=reference.motor_dq[None],
        torque=torque[None],
        dt=reference.robot.servo.control_dt,
    )


def control_names(robot: RobotDescription) -> list[str]:
    """Names of the controls in the order of `data.ctrl`; all are motor side."""
    parts = {"position": "rad", "velocity": "rad/s", "torque": "N m"}
    return [f"motor.{name}.{joint} [{unit}]" for joint in robot.joints for name, unit in parts.items()]


def control_row(plant: Plant, setpoints: Setpoints, k: int) -> Array:
    """Controls at sample `k`, shape (3 N,)."""
    controls = np.empty(plant.model.nu)
    samples = (setpoints.position, setpoints.velocity, setpoints.torque)
    for part, values in zip(plant.split_controls(controls), samples, strict=True):
        part[:] = values[0, k]
    return controls


def control_blocks(plant: Plant, setpoints: Setpoints, progress: Progress) -> Iterator[Array]:
    """Controls of one motion at every physics step and at its last sample, in blocks of shape (rows, 3 N)."""
    steps = setpoints.position.shape[1] - 1
    fractions = np.arange(plant.n_substeps) / plant.n_substeps
    for start in range(0, steps, _CHUNK):
        stop = min(start + _CHUNK, steps)
        controls = np.empty((1, stop - start, plant.n_substeps, plant.model.nu))
        setpoints.between(np.zeros(1, dtype=int), start, stop, fractions, out=plant.split_controls(controls))
        yield controls.reshape(-1, plant.model.nu)
        progress(stop * setpoints.dt, steps * setpoints.dt)
    yield control_row(plant, setpoints, steps)[None]
