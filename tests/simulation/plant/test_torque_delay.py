"""Delay of torques as a number of the description: exact, one with the effect, and the price of gains."""

from dataclasses import replace

import numpy as np
import pytest
import scipy

from ffgym.control import NoCompensation
from ffgym.effects import EFFECTS
from ffgym.robot import ModelOptions, RigidArm, load_robot
from ffgym.simulation import Run, simulate
from ffgym.simulation.export import export_run
from ffgym.simulation.export.play import main as play
from ffgym.simulation.plant import Machine, Plant
from ffgym.studies import circle_references
from tests.simulation.plant.driving import controls
from tests.simulation.plant.test_torque_loop import DT, LAG, RATE, with_loop, without_servo


def torques(machine, commands):
    """Torques on the motors for commanded torques (T, N), (T, N): each over its physics step."""
    plant, robot = Plant(machine, 1), Machine.of(machine).robot
    plant.rest(np.zeros((1, robot.n_joints)))
    applied, force = plant.batch.bind("qfrc_applied"), plant.batch.bind("actuator_force")
    found = []
    for row in controls(plant, torque=commands):
        plant.drive(row[None, None])
        added = robot.drive.motor_torque(applied[0, plant.addresses.motor_qpos])
        found.append(force[0, : robot.n_joints] + added)
    return np.array(found)


@pytest.fixture(scope="module")
def joint():
    return without_servo(load_robot("one_axis"))


@pytest.fixture(scope="module")
def circle(arm):
    return Run(reference=circle_references(arm, ["p1"], [0.1], [0.001])["p1", 0.1], law=NoCompensation())


def test_a_torque_step_comes_after_the_delay_and_not_before(joint):
    given = torques(with_loop(joint, torque_delay=6 * DT), np.ones((20, 1)))[:, 0]
    np.testing.assert_allclose(given, np.where(np.arange(20) < 6, 0.0, 1.0), atol=1e-12)


def test_a_ramp_comes_late_by_the_delay_between_two_steps_too(joint):
    t = np.arange(60) * DT
    given = torques(with_loop(joint, torque_delay=2.4 * DT), (10 * t)[:, None])[:, 0]
    np.testing.assert_allclose(given[5:], 10 * (t[5:] - 2.4 * DT), rtol=1e-9)


def test_the_torque_loop_answers_a_delayed_command(joint):
    given = torques(with_loop(joint, torque_delay=4 * DT, torque_lag=LAG), np.ones((40, 1)))[:, 0]
    t = (np.arange(40) + 1 - 4) * DT
    np.testing.assert_allclose(given, np.where(t > 0, 1 - np.exp(-t / LAG), 0.0), atol=1e-12)
    rate = torques(with_loop(joint, torque_delay=4 * DT, torque_rate=RATE), np.ones((40, 1)))[:, 0]
    np.testing.assert_allclose(rate, np.clip(RATE * t, 0.0, 1.0), atol=1e-9)


def test_the_number_and_the_effect_are_one_delay(irb4600, circle):
    effect = EFFECTS["torque_delay"].on(irb4600, delay=5e-4, lag=0.0)
    machines = [with_loop(irb4600, torque_delay=5e-4), Machine(robot=irb4600, effects=(effect,))]
    one, other = (simulate([circle], machine=machine)[0].joint_array("motor.position") for machine in machines)
    np.testing.assert_array_equal(one, other)
    assert Machine.of(machines[0]).physics(ModelOptions()) == machines[1].physics(ModelOptions())
    assert Machine.of(machines[0]).physics(ModelOptions()) != Machine.of(irb4600).physics(ModelOptions())


def test_delays_of_number_and_effect_add_up(joint):
    robot = with_loop(joint, torque_delay=2 * DT)
    more = EFFECTS["torque_delay"].on(robot, delay=3 * DT, lag=0.0)
    given = torques(Machine(robot=robot, effects=(more,)), np.ones((20, 1)))[:, 0]
    np.testing.assert_allclose(given, np.where(np.arange(20) < 5, 0.0, 1.0), atol=1e-12)


def test_mujocos_lag_is_that_of_the_effect(irb4600, circle):
    effect = EFFECTS["torque_delay"].on(irb4600, delay=5e-4, lag=LAG)
    machines = [with_loop(irb4600, torque_delay=5e-4, torque_lag=LAG), Machine(robot=irb4600, effects=(effect,))]
    one, other = (simulate([circle], machine=machine)[0].joint_array("motor.position") for machine in machines)
    assert np.abs(one - other).max() < 1e-9


def test_a_robot_without_delay_keeps_its_bits_beside_one_that_has_it(irb4600, circle):
    together = simulate([circle, circle], machine=[irb4600, with_loop(irb4600, torque_delay=5e-4)])
    alone = simulate([circle], machine=irb4600)[0]
    np.testing.assert_array_equal(together[0].joint_array("motor.position"), alone.joint_array("motor.position"))
    assert np.abs(together[1].joint_array("motor.position") - alone.joint_array("motor.position")).max() > 1e-6


def test_a_delayed_drive_still_tells_its_friction(irb4600, circle):
    assert simulate([circle], machine=with_loop(irb4600, torque_delay=5e-4))[0].has("friction.effort")


def test_an_export_names_the_delay_that_it_lacks(irb4600, tmp_path):
    robot = with_loop(irb4600, torque_delay=5e-4, torque_lag=LAG)
    reference = circle_references(RigidArm(robot), ["p1"], [0.1], [0.001])["p1", 0.1]
    export_run(tmp_path / "out", Run(reference=reference, law=NoCompensation()))
    assert "drive.torque_delay = [0.0005" in (tmp_path / "out" / "README.txt").read_text(encoding="utf-8")
    assert play(tmp_path / "out") == 0


def predicted_margin(joint, delay, lag):
    """Gain margin of linear theory: PID on one inertia, behind lag, delay and half a step of the hold.

    A lag gives over a step what it has at its end, half a step early, which takes the hold back.
    """
    servo = joint.servo
    inertia = float(joint.drive.rotor_inertia[0] + joint.bodies.inertia[0, 2] / joint.drive.gear_ratio[0] ** 2)

    hold = 0.0 if lag > 0 else DT / 2

    def loop(omega):
        s = 1j * omega
        gains = servo.position_gain[0] + servo.velocity_gain[0] * s + servo.integral_gain[0] / s
        return gains / (inertia * s**2) * np.exp(-s * (delay + hold)) / (1 + lag * s)

    grid = np.geomspace(5.0, 1e4, 20000)
    values = loop(grid)
    turns = np.flatnonzero((np.diff(np.sign(values.imag)) != 0) & (values.real[1:] < 0))
    crossings = [scipy.optimize.brentq(lambda w: loop(w).imag, *grid[k : k + 2]) for k in turns]
    factors = np.array([1 / abs(loop(omega)) for omega in crossings])
    return factors[factors > 1].min()


def swings_out(joint, factor):
    """True if the servo with `factor` times its gains leaves rest by itself, friction left out."""
    gains = {name: factor * getattr(joint.servo, name) for name in ("position_gain", "velocity_gain", "integral_gain")}
    plant = Plant(replace(joint, servo=replace(joint.servo, **gains)), 1, options=ModelOptions(friction=False))
    plant.rest(np.zeros((1, 1)))
    plant.drive(controls(plant, position=np.full((1, 20, 1), 1e-9)))
    early, _, late = (
        np.abs(plant.advance(controls(plant, position=np.zeros((1, steps, 1))))[0]).max() for steps in (40, 4000, 400)
    )
    return late > early


@pytest.mark.parametrize(("delay", "lag"), [(1e-3, 0.0), (5e-4, 1e-3), (1e-3, 3e-4), (2e-3, 5e-4)])
def test_the_gain_margin_falls_as_linear_theory_says(delay, lag):
    joint = with_loop(load_robot("one_axis"), torque_delay=delay, torque_lag=lag)
    margin = predicted_margin(joint, delay, lag)
    assert not swings_out(joint, 0.97 * margin)
    assert swings_out(joint, 1.03 * margin)
    ideal = with_loop(joint, torque_delay=0.0, torque_lag=0.0)
    assert not swings_out(ideal, 1.03 * margin), "an ideal drive bears the gain"
