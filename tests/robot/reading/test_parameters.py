"""Parameter files replace some numbers of a description and nothing else."""

from dataclasses import fields, replace
from importlib import resources

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.robot import compile_model, physics_fingerprint, with_parameters
from ffgym.robot.reading.load import builtin_parameters, builtin_robots, load_draft, load_robot

FRICTION = """
[parameters]
robot = "one_axis"
title = "cell 3"

[friction.coulomb]
value = [0.4]
unit = "N m"
side = "motor"
origin = "fitted"
source = "speed ladder"
prior = [0.5367]
prior_source = "thesis (6.9)"

[drive.rotor_inertia]
value = [4.0e-3]
unit = "kg m^2"
side = "motor"
origin = "chosen"
source = "test"
"""


def written(tmp_path, text):
    path = tmp_path / "parameters.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_parameter_file_replaces_its_numbers_and_no_others(one_axis, tmp_path):
    changed = with_parameters(one_axis, written(tmp_path, FRICTION))
    assert changed.friction.coulomb == [0.4]
    assert changed.drive.rotor_inertia == [4e-3]
    assert changed.quantities["friction.coulomb"].prior == [0.5367]
    for field in fields(one_axis.friction):
        if field.name != "coulomb":
            np.testing.assert_array_equal(getattr(changed.friction, field.name), getattr(one_axis.friction, field.name))
    assert changed.bodies is one_axis.bodies
    assert one_axis.friction.coulomb == [0.5367]
    assert physics_fingerprint(compile_model(changed)) != physics_fingerprint(compile_model(one_axis))


def test_what_was_changed_in_the_program_stays(one_axis, tmp_path):
    softer = replace(one_axis, friction=one_axis.friction.scale(viscous=0.5))
    changed = with_parameters(softer, written(tmp_path, FRICTION))
    np.testing.assert_array_equal(changed.friction.viscous, softer.friction.viscous)


@pytest.mark.parametrize("robot", builtin_robots())
def test_a_robot_description_without_its_other_parts_is_a_parameter_file(robot, tmp_path):
    """The tables have the form of the description: those of a built-in robot, copied out, change nothing."""
    whole = load_robot(robot)
    blocks = []
    for path, quantity in whole.quantities.items():
        if path.startswith(("friction.", "links.")):
            fitted = quantity.prior is not None
            blocks.append(
                f"[{path}]\nvalue = {quantity.value.tolist()}\nunit = '{quantity.unit}'\nside = '{quantity.side}'\n"
                f"origin = '{'derived' if fitted else quantity.origin[0]}'\nsource = 'copied'\n"
            )
    same = with_parameters(whole, written(tmp_path, "\n".join(blocks)))
    assert physics_fingerprint(compile_model(same)) == physics_fingerprint(compile_model(whole))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('robot = "one_axis"', 'robot = "other"', "are for robot 'other', not for 'one_axis'"),
        ("title", "titel", r"\[parameters\] may have robot, title"),
        ("[friction.coulomb]", "[friction.coulumb]", "Unknown entries .*coulumb"),
        ("[drive.rotor_inertia]", "[servo.control_dt]", "Unknown entries .*servo.control_dt"),
        ("value = [0.4]", "value = [0.4, 0.5]", "friction.coulomb"),
        ("value = [0.4]", "value = [nan]", "friction.coulomb must be finite"),
        ("value = [0.4]", "value = [0.9]", "static = .* must be >= coulomb"),
        ('unit = "N m"\n', 'unit = "Nm"\n', "unit is 'Nm', must be 'N m'"),
        ('[parameters]\nrobot = "one_axis"\ntitle = "cell 3"\n', "links = 3\n", "Unknown entries .*links"),
        ("value = [0.4]", "value = [0.4", "Cannot read parameter file"),
    ],
)
def test_a_wrong_parameter_file_is_one_clear_error(one_axis, tmp_path, old, new, message):
    path = written(tmp_path, FRICTION.replace(old, new, 1))
    with pytest.raises(FFGymError, match=message) as caught:
        with_parameters(one_axis, path)
    assert str(path) in str(caught.value)


def test_an_empty_or_missing_file_and_a_tool_without_tool_are_refused(one_axis, tmp_path):
    with pytest.raises(FFGymError, match="no parameters"):
        with_parameters(one_axis, written(tmp_path, ""))
    with pytest.raises(FFGymError, match="Cannot read"):
        with_parameters(one_axis, tmp_path / "missing.toml")
    tool = "[tool.mass]\nvalue = 3.0\nunit = 'kg'\norigin = 'chosen'\nsource = 'test'\n"
    with pytest.raises(FFGymError, match="has no tool"):
        with_parameters(one_axis, written(tmp_path, tool))


def test_a_parameter_file_that_names_its_robot_stands_for_it(one_axis, tmp_path):
    path = written(tmp_path, FRICTION)
    whole = load_robot(path)
    expected = with_parameters(one_axis, path)
    assert whole.name == "one_axis"
    assert physics_fingerprint(compile_model(whole)) == physics_fingerprint(compile_model(expected))
    with pytest.raises(FFGymError, match="robot of parameter file"):
        load_robot(written(tmp_path, FRICTION.replace("one_axis", "other")))
    with pytest.raises(FFGymError, match=r"\[robot\]|robot"):
        load_robot(written(tmp_path, FRICTION.replace('robot = "one_axis"\n', "")))


def test_gains_of_the_servo_can_be_replaced_and_its_sample_time_stays(one_axis, tmp_path):
    gains = (
        "[servo.velocity_gain]\nvalue = [0.7]\nunit = 'N m s/rad'\nside = 'motor'\norigin = 'chosen'\nsource = 'test'\n"
    )
    robot = with_parameters(one_axis, written(tmp_path, gains))
    assert robot.servo.velocity_gain == 0.7
    assert robot.servo.control_dt == one_axis.servo.control_dt
    np.testing.assert_array_equal(robot.servo.position_gain, one_axis.servo.position_gain)


@pytest.mark.parametrize("name", builtin_parameters())
def test_built_in_parameters_are_a_robot_by_their_name(name):
    robot = load_robot(name)
    assert robot.name in builtin_robots()
    assert not load_draft(name).missing
    nominal = load_robot(robot.name)
    assert physics_fingerprint(compile_model(robot)) != physics_fingerprint(compile_model(nominal))
    assert robot.servo is not None
    for field in fields(robot.servo):  # gains that no fit has changed are those of the robot
        entry = f"servo.{field.name}"
        if robot.quantities[entry].source == nominal.quantities[entry].source:
            np.testing.assert_array_equal(getattr(robot.servo, field.name), getattr(nominal.servo, field.name))
        else:
            assert "fitted" in robot.quantities[entry].origin
    assert robot.servo.control_dt == nominal.servo.control_dt


def test_a_parameter_file_takes_numbers_of_other_files(tmp_path):
    both = load_robot("irb4600_60_205_arm_drives")
    arm, drives = load_robot("irb4600_60_205_arm_losses"), load_robot("irb4600_60_205_servo_drives")
    np.testing.assert_array_equal(both.friction.arm_share, arm.friction.arm_share)
    np.testing.assert_array_equal(both.servo.velocity_gain, arm.servo.velocity_gain)
    np.testing.assert_array_equal(both.drive.torque_delay, drives.drive.torque_delay)
    assert both.quantities["drive.torque_lag"].source == drives.quantities["drive.torque_lag"].source
    # numbers of the file itself come before those that it takes
    head = '[parameters]\nrobot = "irb4600_60_205"\nwith = ["irb4600_60_205_servo_drives"]\n'
    own = "[drive.resolver_period]\nvalue = 1e-3\nunit = 's'\norigin = 'chosen'\nsource = 'test'\n"
    for robot in (load_robot(path := written(tmp_path, head + own)), with_parameters(arm, path)):
        assert robot.drive.resolver_period == 1e-3
        np.testing.assert_array_equal(robot.drive.torque_delay, drives.drive.torque_delay)
    # no file leads back to itself
    for names, problem in (("['irb4600_60_205_arm_drives']", "of numbers"), ("'x'", "a list"), ("['x']", "with in")):
        with pytest.raises(FFGymError, match=problem):
            load_robot(written(tmp_path, head.replace('["irb4600_60_205_servo_drives"]', names)))


def own_description(tmp_path, *without):
    """A user's description of the one-axis robot under another name, maybe without some entries."""
    text = (resources.files("ffgym.robot") / "data" / "one_axis.toml").read_text(encoding="utf-8")
    tables = [part for part in text.split("\n[") if not part.startswith(without)] if without else text.split("\n[")
    path = tmp_path / "my_axis.toml"
    path.write_text("\n[".join(tables).replace('name = "one_axis"', 'name = "my_axis"'), encoding="utf-8")
    return path


def beside(tmp_path, description, text=FRICTION):
    """A parameter file in a folder of its own for a user's description."""
    (tmp_path / "fits").mkdir(exist_ok=True)
    head = text.replace('robot = "one_axis"', f'robot = "my_axis"\ndescription = "{description}"')
    return written(tmp_path / "fits", head)


def test_a_parameter_file_finds_the_description_of_its_robot(tmp_path):
    own_description(tmp_path)
    path = beside(tmp_path, "../my_axis.toml")
    for robot in (load_robot(path), load_draft(path).complete()):
        assert robot.name == "my_axis"
        assert robot.friction.coulomb == [0.4]
        assert robot.friction.static == [0.5634]


def test_a_parameter_file_completes_a_description_that_lacks_its_entries(tmp_path):
    own_description(tmp_path, "friction.coulomb]", "drive.rotor_inertia]")
    assert load_draft(tmp_path / "my_axis.toml").missing == ("drive.rotor_inertia", "friction.coulomb")
    path = beside(tmp_path, "../my_axis.toml")
    assert load_draft(path).missing == ()
    assert load_robot(path).drive.rotor_inertia == [4e-3]


def test_a_parameter_file_of_a_parameter_file_has_the_numbers_of_both(tmp_path):
    own_description(tmp_path)
    beside(tmp_path, "../my_axis.toml")
    viscous = (
        FRICTION.replace("friction.coulomb", "friction.viscous").split("[drive")[0].replace('"N m"', '"N m s/rad"')
    )
    last = tmp_path / "last.toml"
    last.write_text(viscous.replace('robot = "one_axis"', 'robot = "my_axis"\ndescription = "fits/parameters.toml"'))
    robot = load_robot(last)
    assert (robot.friction.coulomb, robot.friction.viscous) == ([0.4], [0.4])


@pytest.mark.parametrize(
    ("description", "message"),
    [
        ("../my_axis.toml", "are for robot 'your_axis', not for 'my_axis'"),
        ("parameters.toml", "leads back to a parameter file"),
        ("nowhere.toml", "nowhere.toml"),
        ("arm.urdf", "must be the path of the robot's description, .toml"),
    ],
)
def test_a_description_that_does_not_fit_is_one_error(description, message, tmp_path):
    own_description(tmp_path)
    text = FRICTION.replace('robot = "one_axis"', 'robot = "your_axis"\ndescription = "' + description + '"')
    (tmp_path / "fits").mkdir()
    with pytest.raises(FFGymError, match=message):
        load_robot(written(tmp_path / "fits", text))
