"""Exported models, set-points at every physics step, and references as tables."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, get_args

import mujoco
import numpy as np

from ffgym.control import Setpoints
from ffgym.core.errors import check_choice
from ffgym.core.files import write_bytes, write_text
from ffgym.core.types import Array
from ffgym.core.version import __version__
from ffgym.effects import ModelEffect, NativeEffect
from ffgym.paths import Reference
from ffgym.robot import ModelOptions, RobotDescription, mjcf_text, model_bytes
from ffgym.simulation.plant import Machine, Plant
from ffgym.simulation.run import Progress

_CHUNK = 256
"""Control steps in one block: chosen, so that a block takes a few MB at most and progress is seen."""


def control_row(plant: Plant, setpoints: Setpoints, k: int) -> Array:
    """Return controls at sample `k`, shape (3 N,)."""
    controls = np.empty(plant.model.nu)
    samples = (setpoints.position, setpoints.velocity, setpoints.torque)
    for part, values in zip(plant.split_controls(controls), samples, strict=True):
        part[:] = values[0, k]
    return controls


def control_blocks(plant: Plant, setpoints: Setpoints, progress: Progress) -> Iterator[Array]:
    """Yield controls of one motion at every physics step and at its last sample, in blocks of shape (rows, 3 N)."""
    steps = setpoints.position.shape[1] - 1
    fractions = np.arange(plant.n_substeps) / plant.n_substeps
    for start in range(0, steps, _CHUNK):
        stop = min(start + _CHUNK, steps)
        controls = np.empty((1, stop - start, plant.n_substeps, plant.model.nu))
        setpoints.between(np.zeros(1, dtype=int), start, stop, fractions, out=plant.split_controls(controls))
        yield controls.reshape(-1, plant.model.nu)
        progress(stop * setpoints.dt, steps * setpoints.dt)
    yield control_row(plant, setpoints, steps)[None]


Sides = Literal["both", "motor", "link"]
Angles = Literal["rad", "deg", "turn"]

_PER_RADIAN = {"rad": 1.0, "deg": 180 / np.pi, "turn": 0.5 / np.pi}
"""Units of angle in a radian."""


@dataclass(frozen=True, kw_only=True)
class ReferenceForm:
    """Form of a table of references, as a drive reads it."""

    sides: Sides = "both"
    """Side of the gearbox: motor, link (joint), or both."""
    angles: Angles = "rad"
    """Unit of angles; those of speed and acceleration follow. A sliding joint has m on the link side in any case."""

    def __post_init__(self) -> None:
        check_choice("sides", self.sides, get_args(Sides))
        check_choice("angles", self.angles, get_args(Angles))


def reference_table(reference: Reference, u_ff: Array, u_lff: Array, form: ReferenceForm) -> dict[str, Array]:
    """Tabulate a reference: columns by name, each of shape (T,); the name ends with the unit.

    Args:
        reference: the motion.
        u_ff: rigid feed-forward torque at its samples, motor side [N m], shape (T, N).
        u_lff: added feed-forward torque, likewise.
        form: sides and units.
    """
    robot, columns = reference.robot, {"t [s]": reference.t}
    torques = {"u_ff": u_ff, "u_lff": u_lff, "u_total": u_ff + u_lff}
    for side in ("link", "motor") if form.sides == "both" else (form.sides,):
        motor = side == "motor"
        lengths = ["rad"] * robot.n_joints if motor else robot.kinematics.units
        motion = {
            ("position", ""): reference.motor_q if motor else reference.q,
            ("velocity", "/s"): reference.motor_dq if motor else reference.dq,
            ("acceleration", "/s^2"): reference.motor_ddq if motor else reference.ddq,
        }
        for (name, per_time), values in motion.items():
            for joint, length, value in zip(robot.joints, lengths, values.T, strict=True):
                unit, factor = ("m", 1.0) if length == "m" else (form.angles, _PER_RADIAN[form.angles])
                columns[f"{side}.{name}.{joint} [{unit}{per_time}]"] = value * factor
        for name, torque in torques.items():
            values = torque if motor else robot.drive.joint_torque(torque)
            for joint, length, value in zip(robot.joints, lengths, values.T, strict=True):
                columns[f"{side}.{name}.{joint} [{'N' if length == 'm' else 'N m'}]"] = value
    return columns


def in_engine(machine: Machine) -> Machine:
    """Return the machine with what MuJoCo has itself: some effects, no delays of drives, no reading of resolvers."""
    inside = [effect for effect in machine.effects if isinstance(effect, NativeEffect | ModelEffect)]
    robot = machine.robot
    if _beside_engine(robot):
        robot = replace(robot, drive=replace(robot.drive, torque_delay=None, resolver_period=0.0))
    return replace(machine, robot=robot, effects=tuple(inside))


def plant_of(machine: Machine, options: ModelOptions | None) -> Plant:
    """Build the plant that is exported; without looks, as in simulations, which change no numbers."""
    return Plant(in_engine(machine), 1, options=replace(options or ModelOptions(), looks=False))


def spec_with_home(plant: Plant, machine: Machine, options: ModelOptions | None) -> mujoco.MjSpec:
    """Build the model with a keyframe 'home': at rest in the home pose, or next to q = 0 where that is out of reach."""
    robot = plant.robot
    spec = in_engine(machine).spec(options or ModelOptions())
    spec.comment = f"{robot.title}. Written by ffgym {__version__}; all numbers have all their digits."
    if missing := missing_text(machine):
        spec.comment += f" {missing}"
    area, limits = robot.work_area, robot.kinematics.range
    home = np.clip(np.zeros(robot.n_joints), limits[:, 0], limits[:, 1]) if area is None else area.home
    controls = np.zeros(plant.model.nu)
    plant.split_controls(controls)[0][:] = robot.drive.motor_angle(home)
    add_rest(spec, plant, "home", home, None, controls)
    return spec


def missing_text(machine: Machine) -> str:
    """Name the effects that a model in a file lacks, in one sentence; empty if it has all."""
    inside = in_engine(machine).effects
    effects = [
        f"{effect.name} ({', '.join(f'{name} = {value.tolist()}' for name, value in effect.values().items())})"
        for effect in machine.effects
        if not effect.is_null and effect not in inside
    ]
    lacking = [*effects, *_beside_engine(machine.robot)]
    return f"Not in it, as MuJoCo has no such effects: {'; '.join(lacking)}." if lacking else ""


def _beside_engine(robot: RobotDescription) -> list[str]:
    """Numbers of the drives that MuJoCo lacks."""
    delay, period = robot.drive.torque_delay, robot.drive.resolver_period
    found = [] if delay is None else [f"drive.torque_delay = {delay.tolist()} s"]
    return found if period == 0 else [*found, f"drive.resolver_period = {period} s"]


def add_rest(spec: mujoco.MjSpec, plant: Plant, name: str, q: Array, dq: Array | None, controls: Array) -> None:
    """Add a keyframe in equilibrium at joint positions `q` (N,), moving at `dq`, with these controls (3 N,)."""
    plant.rest(q[None], None if dq is None else dq[None])
    state = plant.batch
    spec.add_key(name=name, qpos=state.qpos[0], qvel=state.qvel[0], act=state.act[0], ctrl=controls)


def write_model(folder: Path, spec: mujoco.MjSpec, *, binary: bool) -> None:
    """Write `model.xml`, and `model.mjb` if asked for."""
    write_text(folder / "model.xml", mjcf_text(spec))
    if binary:
        write_bytes(folder / "model.mjb", model_bytes(spec.compile()))
