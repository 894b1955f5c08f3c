"""Gain margins of a checked robot against the simulation itself, with drives that are not ideal."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.robot import load_robot
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Plant
from ffgym.studies import circle_references
from ffgym.studies.robot_check.loads import servo_loop
from tests.simulation.plant.test_torque_delay import swings_out
from tests.simulation.plant.test_torque_loop import DT, with_loop


@pytest.mark.parametrize(
    ("numbers", "period"),
    [
        ({"torque_delay": 1e-3}, 0.0),
        ({"torque_delay": 4.3e-4, "torque_lag": 2e-4}, 2 * DT),
        ({"torque_delay": 2e-3, "torque_lag": 5e-4}, 6 * DT),
    ],
)
def test_the_gain_margin_is_that_of_the_simulation(numbers, period):
    joint = with_loop(load_robot("one_axis"), **numbers)
    fine = replace(joint.sensors, encoder_bits=48)  # linear theory knows no rounding
    joint = replace(joint, drive=replace(joint.drive, resolver_period=period), sensors=fine)
    margin = servo_loop(joint, "zero", np.zeros(1)).gain_margin
    assert not swings_out(joint, 0.99 * margin)
    assert swings_out(joint, 1.01 * margin)


def test_each_part_of_a_drive_takes_gain_margin(irb4600):
    def margin(robot):
        return servo_loop(robot, "home", irb4600.work_area.home).gain_margin

    delayed = with_loop(irb4600, torque_delay=5e-4)
    read = replace(delayed, drive=replace(delayed.drive, resolver_period=4 * DT))
    assert margin(read) < 0.8 * margin(delayed) < 0.4 * margin(irb4600)


def test_joints_with_other_delays_have_their_own_poles(irb4600):
    delays = np.array([0.0, 3.4, 1.0, 0.0, 7.0, 2.5]) * DT
    mixed = replace(irb4600, drive=replace(irb4600.drive, torque_delay=delays))
    home = irb4600.work_area.home
    worst, least = (with_loop(irb4600, torque_delay=value) for value in (delays.max(), delays[delays > 0].min()))
    margins = [servo_loop(robot, "home", home).gain_margin for robot in (worst, mixed, least)]
    assert margins[0] * 0.999 <= margins[1] <= margins[2]


def test_the_built_in_drives_are_the_nominal_robot_but_for_their_numbers(irb4600, arm):
    real = load_robot("irb4600_60_205_servo_drives")
    numbers = {"torque_lag", "torque_delay", "torque_rate", "resolver_period"}
    assert {path for path in real.quantities if path not in irb4600.quantities} == {f"drive.{name}" for name in numbers}
    margin = servo_loop(real, "home", irb4600.work_area.home)
    assert margin.stable
    assert 3.0 < margin.gain_margin < 6.0
    ideal = replace(
        real, drive=replace(real.drive, resolver_period=0.0, **dict.fromkeys(numbers - {"resolver_period"}))
    )
    assert Plant(ideal, 1).fingerprint() == Plant(irb4600, 1).fingerprint()


def test_gains_that_ideal_drives_bear_shake_the_built_in_ones(arm, irb4600):
    reference = circle_references(arm, ["p1"], [0.04], [0.001])["p1", 0.04]
    names = ("position_gain", "velocity_gain", "integral_gain")
    servo = replace(irb4600.servo, **{name: 8 * getattr(irb4600.servo, name) for name in names})
    stiff = replace(irb4600, servo=servo)
    moved = replace(reference, robot=stiff)
    real = load_robot("irb4600_60_205_servo_drives")
    ripple = [
        np.std(np.diff(simulate([Run(reference=moved)], machine=robot)[0].joint_array("motor.effort"), axis=0))
        for robot in (stiff, replace(real, servo=servo))
    ]
    assert ripple[1] > 20 * ripple[0]
