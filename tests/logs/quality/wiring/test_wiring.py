"""Wrongly wired columns are named as what they are, and mended; machines that differ from their description are not."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ffgym.effects import EFFECTS
from ffgym.logs import read_logs
from ffgym.logs.quality.wiring import Wiring, find_wiring
from ffgym.recordings import Recording
from ffgym.robot import load_robot
from tests.logs.quality.wiring.wiring_samples import Made, bare, clean, hidden, mistakes, recorded

FAST, SIX = "two_link", "irb4600_60_205"


def is_named(made: Made, found: Wiring, robot) -> bool:
    """Whether it is the one mistake that was found, with its joints."""
    if [mistake.kind for mistake in found.mistakes] != [made.kind]:
        return False
    (mistake,) = found.mistakes
    return set(mistake.joints) == {robot.joints[j] for j in made.joints} and set(mistake.families) == set(made.families)


def is_mended(made: Made, found: Wiring, logs: tuple[Recording, ...]) -> bool:
    """Whether the columns are those of the right logs, but for torque constants, which are estimates."""
    tolerance = 0.05 if made.kind == "current" else 1e-9
    for right, wrong in zip(logs, made.to(logs), strict=True):
        mended = found.rewiring.apply(wrong)
        rows = np.clip(np.searchsorted(right.t, mended.t - 1e-6), 0, len(right) - 1)
        for name, values in mended.columns.items():
            given = right[name][rows]
            size = max(float(np.nanmax(np.abs(given))) if np.isfinite(given).any() else 0.0, 1e-12)
            if not np.allclose(values, given, rtol=0, atol=tolerance * size, equal_nan=True):
                return False
    return True


@pytest.mark.parametrize("name", mistakes(load_robot(FAST)))
def test_a_mistake_is_named_and_mended(name):
    robot = load_robot(FAST)
    made = mistakes(robot)[name]
    found = find_wiring(made.to(clean(FAST)), robot)
    assert is_named(made, found, robot), [mistake.message for mistake in found.mistakes]
    assert is_mended(made, found, clean(FAST))


@pytest.mark.slow
def test_mistakes_with_a_robot_of_six_axes_are_named_and_mended():
    robot, unknown, unmended = load_robot(SIX), [], []
    for name, made in mistakes(robot).items():
        found = find_wiring(made.to(clean(SIX)), robot)
        if not is_named(made, found, robot):
            unknown.append((name, [mistake.message for mistake in found.mistakes]))
        elif made.kind != "delay" and not is_mended(made, found, clean(SIX)):
            unmended.append(name)
    assert len(mistakes(robot)) == 43
    assert len(unknown) <= 5, unknown
    assert not unmended


def test_two_mistakes_are_two_entries():
    robot = load_robot(FAST)
    one, other = mistakes(robot)["sign of torques, one"], mistakes(robot)["degrees for radians, position, all"]
    logs = [other.change.apply(log) for log in one.to(clean(FAST))]
    found = find_wiring(logs, robot)
    assert {mistake.kind for mistake in found.mistakes} == {"sign", "unit"}
    assert find_wiring([found.rewiring.apply(log) for log in logs], robot).mistakes == ()


@pytest.mark.parametrize("robot", [FAST, "one_axis", SIX])
def test_right_logs_are_wired_rightly(robot):
    assert find_wiring(clean(robot), load_robot(robot)).mistakes == ()
    assert find_wiring(bare(clean(robot)), load_robot(robot)).mistakes == ()


def differing(robot, seed):
    """A description whose masses are 30 % off, and whose friction is off by a factor of three."""
    rng = np.random.default_rng(seed)
    masses, losses = (np.exp(rng.uniform(-1, 1, robot.n_joints) * np.log(size)) for size in (1.3, 3.0))
    friction, bodies = robot.friction, robot.bodies
    return replace(
        robot,
        bodies=replace(bodies, mass=bodies.mass * masses, inertia=bodies.inertia * masses[:, None]),
        friction=replace(
            friction,
            coulomb=friction.coulomb * losses,
            static=friction.static * losses,
            viscous=friction.viscous * losses,
        ),
    )


@pytest.mark.parametrize("robot", [FAST, SIX])
@pytest.mark.parametrize("seed", range(3))
def test_wrong_masses_and_friction_are_no_mistake_in_wiring(robot, seed):
    nominal = differing(load_robot(robot), seed)
    assert find_wiring(clean(robot), nominal).mistakes == ()
    assert find_wiring(bare(clean(robot)), nominal).mistakes == ()


def test_a_counterbalance_that_is_not_described_is_no_mistake_in_wiring():
    robot = load_robot("kuka_kr300_r2500")
    logs = recorded(robot)
    assert find_wiring(logs, replace(robot, springs=())).mistakes == ()
    assert find_wiring(bare(logs), replace(robot, springs=())).mistakes == ()


@pytest.mark.slow
@pytest.mark.parametrize("mass", [20.0, 60.0, 100.0])
def test_a_payload_that_nobody_told_of_is_no_mistake_in_wiring(mass):
    robot = load_robot(SIX)
    logs = recorded(robot, EFFECTS["payload"].on(robot, mass=mass))
    assert find_wiring(logs, robot).mistakes == ()
    assert find_wiring(bare(logs), robot).mistakes == ()


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_physical_effects_are_no_mistakes_in_wiring(seed):
    robot = load_robot(SIX)
    for name, effect in hidden(robot, seed):
        logs = recorded(robot, effect)
        assert find_wiring(logs, robot).mistakes == (), name
        assert find_wiring(bare(logs), robot).mistakes == (), name


@pytest.mark.parametrize("name", ["backlash", "asymmetry", "load_friction", "stribeck_peak", "torque_clock"])
def test_an_effect_is_no_mistake_in_wiring(name):
    robot = load_robot(FAST)
    (effect,) = [one for _, one in hidden(robot, 5) if one.name == name]
    logs = recorded(robot, effect)
    assert find_wiring(logs, robot).mistakes == ()
    assert find_wiring(bare(logs), robot).mistakes == ()


@pytest.mark.skipif(not os.environ.get("FFGYM_DATA"), reason="set FFGYM_DATA to the folder with published recordings")
@pytest.mark.parametrize("name", ["emps", "kuka_kr300_2020", "kuka_kr300_2021_10hz"])
def test_published_recordings_are_wired_rightly(name):
    files = sorted(Path(os.environ["FFGYM_DATA"], name).glob("*.npz"))
    logs = [recording for file in files for recording in read_logs(file, name)]
    assert logs
    assert find_wiring(logs, load_robot(logs[0].header.robot)).mistakes == ()


def test_logs_of_another_robot_and_logs_that_differ_in_meaning_say_nothing():
    assert find_wiring(clean(FAST), load_robot("one_axis")) == Wiring()
    one, *others = clean(FAST)
    linked = Recording(one.columns, replace(one.header, position_side="link"))
    assert find_wiring([linked, *others], load_robot(FAST)) == Wiring()
    assert find_wiring([], load_robot(FAST)) == Wiring()
