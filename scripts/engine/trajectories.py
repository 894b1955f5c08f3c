"""Short trajectories of every robot and every environment that ship, as they are recorded and made again."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import gymnasium as gym
import numpy as np

from ffgym.core.registration import ENVIRONMENTS, find_spec
from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.robot import ModelOptions, RobotDescription, builtin_parameters, builtin_robots, load_robot
from ffgym.simulation.plant import Plant
from scripts.engine.second.machine import State
from scripts.engine.second.steps import second_engine

STEP = 1 / 32000
"""Physics step of robots [s]: so short that light links bear friction behind springs as they are (docs/physics.md)."""
DURATION = 0.05
"""Length of a robot's trajectory [s]."""
EVERY = 64
"""Steps between rows of it: 2 ms."""
FREQUENCIES = (20.0, 31.0)
"""Frequencies of set-points and of added torque [Hz]; chosen: joints turn round several times."""
SWING = 0.5
"""Largest speed of set-points as a share of each joint's; the servos have to work for it."""
PUSH = 0.1
"""Added torque as a share of the peak torque."""
ACTIONS = 30
"""Control steps of an environment, with random actions."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Trajectory:
    """Coordinates at T instants."""

    time: Array
    """[s], shape (T,)."""
    values: Array
    """Angles of gearboxes, deflections and bristles of a robot, or MuJoCo's `qpos` of an environment, (T, C)."""


def recorded_things() -> dict[str, Callable[[], Trajectory]]:
    """Functions that make the trajectories of all robots and environments, by name."""
    robots = {name: partial(move_robot, name) for name in (*builtin_robots(), *builtin_parameters())}
    return {**robots, **{name: partial(act_in, name) for name in sorted(ENVIRONMENTS)}}


def move_robot(name: str) -> Trajectory:
    """Let a robot follow fast sines from rest, pushed by its motors."""
    robot = load_robot(name)
    plant = Plant(robot, 1, options=ModelOptions(physics_dt=STEP, looks=False), n_threads=1)
    plant.rest(_home(robot)[None])
    wanted = _set_points(robot)
    rows = np.zeros((1, len(wanted), plant.model.nu))
    for column, values in zip(plant.split_controls(rows), wanted.swapaxes(0, 1), strict=True):
        column[0] = values
    arrays = plant.advance(rows)
    kept = slice(EVERY - 1, None, EVERY)
    later = coordinates(plant, *(values[0, kept] for values in arrays))
    return _trajectory(later)


def move_by_second_engine(name: str) -> Trajectory:
    """Do the same by the second engine, which has nothing of the first but the description."""
    robot, kept = load_robot(name), []
    stepper, state = second_engine(robot, STEP, _home(robot))
    for k, row in enumerate(_set_points(robot)):
        step = stepper.step(state, row)
        stepper.observe(step, step.later)
        state = step.later
        if (k + 1) % EVERY == 0:
            kept.append(state)
    return _trajectory({key: np.stack([row[key] for row in kept]) for key in state})


def act_in(identity: str) -> Trajectory:
    """Act by chance in an environment; its arguments are the defaults."""
    env = gym.make(find_spec(identity)).unwrapped
    env.reset(seed=0)
    core, rows = env.core, []  # type: ignore[attr-defined]
    qpos = core.plant.batch.bind("qpos")
    for action in np.random.default_rng(0).uniform(-1, 1, (ACTIONS, core.robot.n_joints)):
        env.step(action)
        rows.append(qpos[0].copy())
    env.close()
    return Trajectory(time=core.robot.servo.control_dt * np.arange(1.0, ACTIONS + 1), values=np.array(rows))


def robot_in(identity: str) -> str | None:
    """Name of the robot that an environment has by default; None for one that is drawn, or of a workcell."""
    given = ENVIRONMENTS[identity].defaults.get("robot")
    return given if isinstance(given, str) else None


def coordinates(plant: Plant, qpos: Array, qvel: Array, act: Array) -> dict[str, Array]:
    """Coordinates of the second engine from MuJoCo's arrays of any leading shape."""
    at, n = plant.addresses, plant.robot.n_joints
    soft = np.append(at.deflection_qpos, at.extra_qpos).astype(int)
    found = {"p": qpos[..., at.motor_qpos], "dp": qvel[..., at.motor_qpos], "s": qpos[..., soft], "ds": qvel[..., soft]}
    activations: Mapping[str, tuple[IntArray, BoolArray]] = {
        "z": (at.bristle, at.has_bristle),
        "za": (at.arm_bristle, at.has_arm_bristle),
        "integral": (at.integral, at.has_integral),
        "loop": (at.torque, at.has_torque),
    }
    for name, (places, have) in activations.items():
        found[name] = np.zeros((*act.shape[:-1], n))
        found[name][..., have] = act[..., places[have]]
    return found


def _home(robot: RobotDescription) -> Array:
    return robot.kinematics.range.mean(axis=1) if robot.work_area is None else robot.work_area.home


def _set_points(robot: RobotDescription) -> Array:
    """Angles and speeds of motors, and torque, in each step, shape (S, 3, N)."""
    t = STEP * np.arange(round(DURATION / STEP))[:, None]
    rate, other = (2 * np.pi * f for f in FREQUENCIES)
    speed = SWING * robot.kinematics.max_speed * np.sin(rate * t)
    position = _home(robot) + SWING * robot.kinematics.max_speed * (1 - np.cos(rate * t)) / rate
    torque = PUSH * robot.drive.peak_torque * np.sin(other * t)
    return np.stack([robot.drive.motor_angle(position), robot.drive.motor_angle(speed), torque], axis=1)


def _trajectory(states: State) -> Trajectory:
    values = np.concatenate([states["p"], states["s"], states["z"]], axis=1)
    return Trajectory(time=STEP * EVERY * np.arange(1.0, len(values) + 1), values=values)
