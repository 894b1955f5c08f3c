"""A robot's model with states to start from, as MJCF and as MuJoCo's binary."""

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np

from ffgym.files import write_bytes, write_text
from ffgym.plant import Plant
from ffgym.robot import ModelOptions, RobotDescription, build_spec, mjcf_text, model_bytes
from ffgym.types import Array
from ffgym.version import __version__


def plant_of(robot: RobotDescription, options: ModelOptions | None) -> Plant:
    """The robot that is exported; looks are left out, as in simulations, and change nothing."""
    return Plant(robot, 1, options=replace(options or ModelOptions(), looks=False))


def spec_with_home(plant: Plant, options: ModelOptions | None) -> mujoco.MjSpec:
    """The model with a keyframe 'home': at rest in the home pose, or next to q = 0 where that is out of reach."""
    robot = plant.robot
    spec = build_spec(robot, options)
    spec.comment = f"{robot.title}. Written by ffgym {__version__}; all numbers have all their digits."
    area, limits = robot.work_area, robot.kinematics.range
    home = np.clip(np.zeros(robot.n_joints), limits[:, 0], limits[:, 1]) if area is None else area.home
    controls = np.zeros(plant.model.nu)
    plant.split_controls(controls)[0][:] = robot.drive.motor_angle(home)
    add_rest(spec, plant, "home", home, None, controls)
    return spec


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
