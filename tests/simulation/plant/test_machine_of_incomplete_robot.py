"""Machine files of robots whose descriptions lack entries: what a diagnosis that fits the rest writes and reads."""

import tomllib
from dataclasses import replace
from importlib import resources

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.robot import load_draft, load_robot
from ffgym.simulation.plant import Machine, load_machine, save_machine
from ffgym.simulation.plant.machine_file import parse_machine

FITTED = ("links.", "friction.", "drive.rotor_inertia]")
SERVO = ("servo.",)


def description(folder, *lacking):
    """A user's description of the two-link arm without some of its tables."""
    text = (resources.files("ffgym.robot") / "data" / "two_link.toml").read_text(encoding="utf-8")
    path = folder / "mine.toml"
    kept = [part for part in text.split("\n[") if not part.startswith(lacking)]
    path.write_text("\n[".join(kept).replace('name = "two_link"', 'name = "mine"'), encoding="utf-8")
    return path


def fitted(path):
    """The robot of a description, with the numbers that it lacks as they are in the complete one."""
    whole, part = load_robot("two_link"), load_draft(path).description_for("identification")
    drive = replace(part.drive, rotor_inertia=whole.drive.rotor_inertia)
    return replace(part, bodies=whole.bodies, friction=whole.friction, drive=drive)


def test_numbers_of_a_machine_file_complete_a_description(tmp_path):
    path = description(tmp_path, *FITTED)
    saved = save_machine(Machine(robot=fitted(path)), tmp_path / "m.toml", title="fit", source="logs", robot=path)
    robot = load_machine(saved).robot
    whole = load_robot("two_link")
    np.testing.assert_array_equal(robot.bodies.mass, whole.bodies.mass)
    np.testing.assert_array_equal(robot.friction.viscous, whole.friction.viscous)
    np.testing.assert_array_equal(robot.servo.position_gain, whole.servo.position_gain)


def test_what_lacks_a_servo_is_compared_with_logs_and_not_simulated(tmp_path):
    path = description(tmp_path, *FITTED, *SERVO)
    saved = save_machine(Machine(robot=fitted(path)), tmp_path / "m.toml", title="fit", source="logs", robot=path)
    robot = load_machine(saved, partial=True).robot
    np.testing.assert_array_equal(robot.friction.coulomb, load_robot("two_link").friction.coulomb)
    with pytest.raises(FFGymError, match=r"m.toml: .*Missing entries: servo.control_dt, servo.integral_gain"):
        load_machine(saved)
    with pytest.raises(FFGymError, match=r"machine: .*Missing entries: servo"):
        parse_machine(tomllib.loads(saved.read_text(encoding="utf-8")), folder=tmp_path)


def test_a_number_that_happens_to_be_that_of_a_stand_in_is_written(tmp_path):
    path = description(tmp_path, *FITTED)
    robot = fitted(path)
    stand_in = load_draft(path).description_for("identification").drive.rotor_inertia
    robot = replace(robot, drive=replace(robot.drive, rotor_inertia=stand_in))
    saved = save_machine(Machine(robot=robot), tmp_path / "m.toml", title="fit", source="logs", robot=path)
    np.testing.assert_array_equal(load_machine(saved).robot.drive.rotor_inertia, stand_in)
