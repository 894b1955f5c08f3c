"""With shorter steps the plant approaches the continuous equations of motion, at first order, with every effect.

The truth is the solution of the equations by a Runge-Kutta method of order 8 at a tolerance of 1e-9, with memories of
effects as differential equations and torques as functions of time.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import scipy

from ffgym.effects import EFFECTS, ResolverEffect
from ffgym.robot import ModelOptions, builtin_robots, load_robot
from ffgym.simulation.plant import Machine, Plant
from scripts.engine.second.steps import Reader, Stepper
from scripts.engine.trajectories import coordinates
from scripts.tables.physics import free_of_servo
from tests.oracle.equations import own_machine
from tests.oracle.following import set_random_state
from tests.oracle.test_steps_by_own_equations import ACTING, machine_with, pairs
from tests.simulation.plant.driving import controls

STEPS = (1 / 16000, 1 / 32000, 1 / 64000)
"""Physics steps [s]; at longer ones light links with friction get more inertia than they have (docs/physics.md)."""
INSTANTS = np.linspace(0.001, 0.006, 6)
"""Instants at which motions are compared [s]."""
NAMES = ("p", "s", "dp", "ds", "z", "za", "integral", "loop")

REMEMBERING = (
    "dwell_stiction", "torsional_hysteresis", "flexible_load", "arm_load_friction", "torque_delay", "cable_pull",
    "arm_friction", "base_flexibility", "link_flexibility",
)  # fmt: skip
"""Effects with states of their own; others are functions of a state, which every step is compared with."""


class Pushes:
    """Set-points and torques as functions of time: sines that begin where motors are, within their limits."""

    def __init__(self, robot, theta, omega) -> None:
        self.robot, self.theta, self.omega = robot, theta, omega

    def __call__(self, t):
        """Set-points of angles and speeds of motors, and torque, (3, N)."""
        wave, peak, servo = np.sin(2 * np.pi * 60 * t), self.robot.drive.peak_torque, self.robot.servo
        gain = np.maximum(servo.position_gain, 1e-3)
        return np.array([self.theta + self.omega * t + 0.1 * peak / gain * wave, self.omega, 0.3 * peak * (0.5 + wave)])


def motion_of_plant(machine, h, seed=0):
    """Coordinates at rest, at the start, and at the instants, and the pushes."""
    plant = Plant(machine, 1, options=ModelOptions(physics_dt=h, looks=False))
    robot = machine.physical
    home = np.zeros(robot.n_joints) if robot.work_area is None else robot.work_area.home
    plant.rest(home[None])
    rest = coordinates(plant, *(x[0].copy() for x in (plant._qpos, plant._qvel, plant._act)))
    set_random_state(plant, np.random.default_rng(seed), 0.3 * robot.kinematics.max_speed[None])
    first = coordinates(plant, *(x[0].copy() for x in (plant._qpos, plant._qvel, plant._act)))
    state = plant.state()
    pushes = Pushes(robot, state.motor_position[0], state.motor_velocity[0])
    rows = np.array([pushes(k * h) for k in range(round(INSTANTS[-1] / h))])
    later = plant.advance(controls(plant, *rows.swapaxes(0, 1)[:, None]))
    at = np.round(INSTANTS / h).astype(int) - 1
    return rest, first, coordinates(plant, *(x[0, at] for x in later)), pushes


def true_motion(machine, rest, first, pushes):
    """Coordinates at the instants by the continuous equations."""
    own = own_machine(machine)
    n = own.n
    before = Stepper(own, Reader(machine.physical, 1.0), 1e-12, rest, first).x
    held = before.held
    n.command_at = lambda t: np.clip(pushes(t)[2], -n.peak, n.peak) if t >= 0 else held
    loops = (n.lag > 0) | np.isfinite(n.rate)
    memories = [effect.start(before) for effect in own.effects]  # as at rest, where the motion begins
    sizes = np.cumsum([first[name].size for name in NAMES] + [memory.size for memory in memories])[:-1]

    def slope(t, y):
        parts = np.split(y, sizes)
        state = dict(zip(NAMES, parts, strict=False))
        x = own.situation(t, state, pushes(t))
        torque = np.where(loops, state["loop"], x.command)
        now = [part.reshape(memory.shape) for part, memory in zip(parts[len(NAMES) :], memories, strict=True)]
        acceleration = own.accelerations(x, torque, now)
        change = np.clip((x.command - state["loop"]) / np.where(loops, n.lag, 1.0), -n.rate, n.rate)
        rates = [
            x.dp,
            x.ds,
            acceleration[: n.size],
            acceleration[n.size :],
            x.dz * (x.share < 1),
            x.dza * (x.share > 0),
        ]
        rates += [x.lag, np.where(loops, change, 0.0)]
        rates += [effect.rate(x, memory).ravel() for effect, memory in zip(own.effects, now, strict=True)]
        return np.concatenate(rates)

    y = np.concatenate([first[name] for name in NAMES] + [memory.ravel() for memory in memories])
    solved = scipy.integrate.solve_ivp(slope, (0, INSTANTS[-1]), y, "DOP853", INSTANTS, rtol=1e-9, atol=1e-13)
    return dict(zip(NAMES, np.split(solved.y.T, sizes, axis=1), strict=False))


def errors(machine, steps=STEPS):
    """RMS errors at all steps, and of extrapolations from two neighbouring steps, as shares of the ways."""
    runs = [motion_of_plant(machine, h) for h in steps]
    rest, first, _, pushes = runs[0]
    known = true_motion(machine, rest, first, pushes)
    found = [np.concatenate([run[2][name] for name in NAMES[:6]], axis=1) for run in runs]
    truth = np.concatenate([known[name] for name in NAMES[:6]], axis=1)
    ways = np.abs(truth - np.concatenate([first[name] for name in NAMES[:6]])).max(axis=0)
    moving = ways > 0

    def error(values):
        return np.sqrt(np.mean(((values - truth) / np.where(moving, ways, 1.0))[:, moving] ** 2))

    better = [2 * finer - coarser for coarser, finer in pairwise(found)]
    return np.array([error(values) for values in found]), np.array([error(values) for values in better])


def check_converges(machine, *, smooth=True, **steps):
    """Errors halve with the step; what is left by extrapolation is quartered, if torques are `smooth` along motions."""
    plain, better = errors(machine, **steps)
    np.testing.assert_allclose(np.log2(plain[:-1] / plain[1:]), 1.0, atol=0.2)
    if smooth:
        np.testing.assert_allclose(np.log2(better[0] / better[1]), 2.0, atol=0.3)


@pytest.mark.parametrize("name", builtin_robots())
def test_errors_of_every_robot_halve_with_the_step_and_extrapolation_quarters_them(name):
    check_converges(Machine(robot=load_robot(name)))


@pytest.mark.parametrize("name", ["irb4600_60_205_arm_drives", "one_axis_drives"])
def test_errors_with_torque_loops_halve_with_the_step_and_extrapolation_quarters_them(name):
    robot = load_robot(name)  # without samples, and delays of what a servo does: these are no differential equations
    check_converges(Machine(robot=replace(robot, drive=replace(robot.drive, resolver_period=0.0, torque_delay=None))))


@pytest.mark.parametrize("effect", REMEMBERING)
def test_errors_with_every_effect_that_remembers_halve_with_the_step(effect, two_link):
    check_effect(two_link, effect)


def check_effect(robot, effect):
    if effect == "torque_delay":  # of torques that are known at all times; it remembers no more steps than 38
        check_converges(machine_with(ACTING[effect], free_of_servo(robot)), steps=[2 * h for h in STEPS])
    else:
        check_converges(machine_with(ACTING[effect], robot), smooth=effect != "backlash")  # its damper jumps


@pytest.mark.slow
@pytest.mark.parametrize(("name", "effect"), pairs(["two_link", "irb4600_60_205", "kuka_kr300_r2500"]))
def test_errors_with_every_effect_halve_with_the_step(name, effect):
    if not issubclass(EFFECTS[effect], ResolverEffect):
        check_effect(load_robot(name), effect)
