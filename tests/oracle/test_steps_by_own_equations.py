"""Every step of the plant from random states obeys equations of motion that are written anew, with every effect."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.effects import EFFECTS, ClockEffect, TrackerEffect
from ffgym.robot import builtin_parameters, builtin_robots, load_robot
from ffgym.simulation.plant import Climate, Machine
from tests.oracle.equations import EQUATIONS, NATIVE, STRUCTURE
from tests.oracle.following import STEP, follow, random_motions

LEFT = 1e-8
"""Largest difference of forces, as a share of all that accelerates the same coordinate.

It is the weight of bodies of 1e-9 kg that the engine wants between motors and springs: 3e-9 in the wrist of the
six-axis robot, below 1e-13 in rigid joints.
"""

STATES = 1e-11
"""Largest difference of bristles, integrals and torque loops, whose motors the engine gives 1e12 Ohm; else 1e-15."""

SEEN = 1e-6
"""Difference that equations without an effect make at least, on the robots on which effects are tried."""

ROBOTS = (*builtin_robots(), *builtin_parameters())
ACTING = {name: kind for name, kind in EFFECTS.items() if not issubclass(kind, TrackerEffect | ClockEffect)}
"""Effects that act on machines; trackers and clocks act on recordings, and leave motions to the bit."""
DAY = Climate(ambient=15.0, rise=np.array([20.0]), time_constant=900.0, running_since=600.0)


def machine_with(kind, robot, seed=1):
    """Machine with an effect of random plausible values."""
    rng = np.random.default_rng(seed)
    values = {name: rng.uniform(p.low, p.high, p.shape(robot.n_joints)) for name, p in kind.parameters().items()}
    if "pair" in {p.per for p in kind.parameters().values()}:
        values = {name: value - np.diag(np.diag(value)) for name, value in values.items()}
    return Machine(robot=robot, effects=(kind(**values),), climate=DAY)


def pairs(names):
    """Names of robots and of the effects that they can have: one in springs needs some, one at the tool a tool."""
    found = []
    for name in names:
        robot = load_robot(name)
        rigid, bare = robot.drive.is_rigid.any(), robot.tool is None
        for effect, kind in ACTING.items():
            needs_tool = kind.needs_tool or effect == "link_flexibility"
            needs_others = effect == "wrist_coupling"
            if not (
                (rigid and kind.needs_elasticity) or (bare and needs_tool) or (robot.n_joints == 1 and needs_others)
            ):
                found.append((name, effect))
    return found


def check_obeys(machine, seed=0, **steps):
    found = follow(machine, random_motions(machine, seed, **steps))
    assert found.pop("force") < LEFT
    assert max(found.values()) < STATES, found


@pytest.mark.parametrize("name", ROBOTS)
def test_every_robot_that_ships_moves_by_its_equations(name):
    check_obeys(Machine(robot=load_robot(name)))


def test_motors_that_other_axes_turn_too_move_by_the_same_equations(irb4600):
    coupling = np.zeros((6, 6))
    coupling[4, 3], coupling[5, 3], coupling[5, 4] = -3.0, 2.0, 15.0
    check_obeys(Machine(robot=replace(irb4600, drive=replace(irb4600.drive, coupling=coupling))))


@pytest.mark.parametrize(("name", "effect"), pairs(["irb4600_60_205", "one_axis"]))
def test_every_effect_that_acts_on_machines_moves_them_by_its_equation(name, effect):
    machine = machine_with(ACTING[effect], load_robot(name))
    motions = random_motions(machine, 0)
    found = follow(machine, motions)
    assert found["force"] < LEFT
    # the same motion is seen not to be that of a machine without the effect
    if effect not in STRUCTURE:
        without = follow(replace(machine, effects=()), motions)
        assert max(without.values()) > SEEN
    assert max(value for part, value in found.items() if part != "force") < STATES, found


@pytest.mark.slow
@pytest.mark.parametrize(("name", "effect"), pairs(ROBOTS))
def test_every_effect_moves_every_robot_by_its_equation(name, effect):
    robot, kind = load_robot(name), ACTING[effect]
    # links with most of the friction want a shorter step; delays are remembered for 38 steps
    finer = 1 / 2 if effect == "torque_delay" else 2 if np.any(robot.drive.delay) else 4
    for seed in range(3):
        check_obeys(machine_with(kind, robot, seed), seed, h=STEP / finer, steps=40)


def test_every_effect_that_acts_on_machines_has_an_equation_of_its_own():
    written = {*NATIVE, *STRUCTURE, *EQUATIONS, "resolver_ripple"}  # the last in `Reader`
    assert set(ACTING) == written


@pytest.mark.parametrize("effect", [name for name in EFFECTS if name not in ACTING])
def test_what_acts_on_recordings_leaves_motions_to_the_bit(effect, irb4600):
    machines = Machine(robot=irb4600), machine_with(EFFECTS[effect], irb4600)
    for plain, measured in zip(*(random_motions(machine, 0) for machine in machines), strict=True):
        for name, values in plain.at.items():
            np.testing.assert_array_equal(measured.at[name], values)
