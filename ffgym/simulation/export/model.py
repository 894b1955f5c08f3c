"""A robot's model with states to start from, as MJCF and as MuJoCo's binary."""

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np

from ffgym.core.files import write_bytes, write_text
from ffgym.core.types import Array
from ffgym.core.version import __version__
from ffgym.effects import Effect, ModelEffect, NativeEffect
from ffgym.robot import ModelOptions, mjcf_text, model_bytes
from ffgym.simulation.plant import Machine, Plant


def in_engine(machine: Machine) -> Machine:
    """The machine with those of its effects that MuJoCo has itself."""
    inside = [effect for effect in machine.effects if isinstance(effect, NativeEffect | ModelEffect)]
    return replace(machine, effects=tuple(inside))


def left_out(machine: Machine) -> tuple[Effect, ...]:
    """Effects that MuJoCo does not have, so that a model in a file cannot have them."""
    inside = in_engine(machine).effects
    return tuple(effect for effect in machine.effects if not effect.is_null and effect not in inside)


def plant_of(machine: Machine, options: ModelOptions | None) -> Plant:
    """The machine that is exported; looks are left out, as in simulations, and change nothing."""
    return Plant(in_engine(machine), 1, options=replace(options or ModelOptions(), looks=False))


def spec_with_home(plant: Plant, machine: Machine, options: ModelOptions | None) -> mujoco.MjSpec:
    """The model with a keyframe 'home': at rest in the home pose, or next to q = 0 where that is out of reach."""
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
    """What a model in a file lacks of a machine, in one sentence; empty if nothing."""
    effects = [
        f"{effect.name} ({', '.join(f'{name} = {value.tolist()}' for name, value in effect.values().items())})"
        for effect in left_out(machine)
    ]
    return f"Not in it, as MuJoCo has no such effects: {'; '.join(effects)}." if effects else ""


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
