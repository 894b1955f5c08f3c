"""A plant in motion from random states, followed step by step by the equations of a machine."""

from dataclasses import dataclass

import numpy as np

from ffgym.robot import ModelOptions
from ffgym.simulation.plant import Machine, Plant
from scripts.engine.second.steps import Reader, Stepper
from scripts.engine.trajectories import coordinates
from tests.oracle.equations import own_machine
from tests.simulation.plant.driving import controls

STEP = 1 / 32000
"""Physics step [s] at which no light link of a robot that ships needs more inertia than it has (docs/physics.md)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Motion:
    """States of one simulation at T + 1 instants, and the set-points of the T steps between."""

    step: float
    controls: np.ndarray
    """Set-points of angles and speeds of motors, and torque, (T, 3, N)."""
    at: dict[str, np.ndarray]
    """Coordinates, see `State`, (T + 1, ...) each."""
    rest: dict[str, np.ndarray]
    """The same at rest, before the motion."""


def random_motions(machine, seed, *, steps=24, h=STEP):
    """Motions of a machine that starts bent, with bent bristles, fast or as slow as motors stick, by random torques."""
    count = 2
    machine = Machine.of(machine)
    plant = Plant(machine, count, options=ModelOptions(physics_dt=h, looks=False))
    robot, rng = machine.physical, np.random.default_rng(seed)
    n = robot.n_joints
    home = np.zeros(n) if robot.work_area is None else robot.work_area.home
    plant.rest(np.tile(home, (count, 1)))
    rest = [coordinates(plant, *(x[i] for x in (plant._qpos, plant._qvel, plant._act))) for i in range(count)]
    slow = 2 * robot.friction.stribeck_velocity / robot.drive.gear_ratio
    set_random_state(plant, rng, np.stack([np.ones(n), slow]))
    first = [x.copy() for x in (plant._qpos, plant._qvel, plant._act)]
    # set-points so near that most torques are within their limits
    near = plant.state()
    away = 0.3 * robot.drive.peak_torque / robot.servo.position_gain
    position = near.motor_position[:, None] + away * rng.uniform(-1, 1, (count, steps, n))
    speed = near.motor_velocity[:, None] + rng.uniform(-1, 1, (count, steps, n))
    torque = 0.3 * robot.drive.peak_torque * rng.uniform(-1, 1, (count, steps, n))
    rows = controls(plant, position, speed, torque)
    later = plant.advance(rows)
    split = np.stack(plant.split_controls(rows), axis=2)
    return [
        Motion(
            step=h,
            controls=split[i],
            at=coordinates(plant, *(np.vstack([a[i : i + 1], b[i]]) for a, b in zip(first, later, strict=True))),
            rest=rest[i],
        )
        for i in range(count)
    ]


def set_random_state(plant, rng, speeds):
    """Put the simulations of a plant at rest to a random state, with speeds of gearboxes up to `speeds` (B, N)."""
    at, robot, (count, n) = plant.addresses, plant.robots[0], speeds.shape
    home = np.zeros(n) if robot.work_area is None else robot.work_area.home
    soft = np.append(at.deflection_qpos, at.extra_qpos).astype(int)
    low, high = robot.kinematics.range.T  # limits push back
    plant._qpos[:, at.motor_qpos] = np.clip(home + rng.uniform(-0.2, 0.2, (count, n)), low + 0.02, high - 0.02)
    plant._qpos[:, soft] += rng.uniform(-1e-3, 1e-3, (count, len(soft)))
    plant._qvel[:, at.motor_qpos] = rng.uniform(-1, 1, (count, n)) * speeds
    plant._qvel[:, soft] = rng.uniform(-0.02, 0.02, (count, len(soft)))
    # bristles of both sides
    length = robot.friction.coulomb / robot.friction.bristle_stiffness
    for places, have in ((at.bristle, at.has_bristle), (at.arm_bristle, at.has_arm_bristle)):
        plant._act[:, places[have]] = (rng.uniform(-0.9, 0.9, (count, n)) * length)[:, have]


def follow(machine, motions):
    """Largest difference of each part of the steps of motions from the equations of a machine, as a share; by name.

    Forces on each coordinate are shares of all that accelerates it.
    """
    ripples = [effect.values() for effect in machine.effects if effect.name == "resolver_ripple"]
    found = []
    for motion in motions:
        reader = Reader(machine.physical, motion.step, ripples)
        rows = [{name: values[k] for name, values in motion.at.items()} for k in range(len(motion.controls) + 1)]
        stepper = Stepper(own_machine(machine), reader, motion.step, motion.rest, rows[0])
        steps = [
            _differences(stepper, now, later, wanted)
            for now, later, wanted in zip(rows[:-1], rows[1:], motion.controls, strict=True)
        ]
        found += steps[1:]  # the load before the first step is not told
    return {name: max(step[name] for step in found) for name in found[0]}


def _differences(stepper, now, later, wanted):
    """Differences of a step of the plant, as shares by name."""
    step, n = stepper.step(now, wanted), stepper.own.n
    given = np.append(later["dp"] - now["dp"], later["ds"] - now["ds"]) / stepper.h
    stepper.observe(step, later)
    most = np.divide(n.peak, n.ki, out=np.zeros(n.size), where=n.ki > 0)
    wrong = {name: later[name] - step.later[name] for name in ("p", "s", "z", "za", "integral", "loop")}
    return {
        "force": share(step.implicit @ given - step.force, np.abs(step.mass) @ np.abs(given)),
        "positions": share(later["p"] - now["p"] - stepper.h * later["dp"], 1.0),
        "soft positions": share(later["s"] - now["s"] - stepper.h * later["ds"], 1.0),
        "torque of loops": share(wrong["loop"], n.peak),
        "integral": share(wrong["integral"][n.ki > 0], most[n.ki > 0]),
        "bristles": share(wrong["z"], n.fc / n.s0),
        "bristles of links": share(wrong["za"], n.fc / n.s0),
    }


def share(difference, whole):
    return np.abs(difference / whole).max(initial=0.0)
