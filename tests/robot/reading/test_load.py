"""The built-in descriptions: every number has unit, origin and source, and published numbers are the published ones."""

import tomllib
from importlib import resources

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.robot import builtin_robots, load_robot, parse_robot
from ffgym.robot.reading.quantity import ORIGINS
from ffgym.robot.reading.rules import REQUIRED, RULES

ROBOTS = ("ball_screw", "irb4600_60_205", "kuka_kr300_r2500", "one_axis", "two_link")
THESIS_ROBOTS = ("irb4600_60_205", "one_axis")


def text_of(name):
    return (resources.files("ffgym.robot") / "data" / f"{name}.toml").read_text(encoding="utf-8")


def test_the_package_holds_these_robots():
    assert builtin_robots() == ROBOTS
    for name in ROBOTS:
        assert load_robot(name).name == name


@pytest.mark.parametrize("name", ROBOTS)
def test_a_copy_of_a_built_in_file_is_the_same_robot(name, tmp_path):
    copy = tmp_path / "mine.toml"
    copy.write_text(text_of(name), encoding="utf-8")
    built_in, read = load_robot(name), load_robot(copy)
    assert read.quantities.keys() == built_in.quantities.keys()
    for path, quantity in read.quantities.items():
        np.testing.assert_array_equal(quantity.value, built_in.quantities[path].value)
    assert read.geoms == built_in.geoms


@pytest.mark.parametrize("name", ROBOTS)
def test_every_number_has_unit_origin_and_source(name):
    robot = load_robot(name)
    wanted = set(REQUIRED)
    assert wanted <= robot.quantities.keys()
    for path, quantity in robot.quantities.items():
        assert quantity.unit
        assert len(quantity.source) > 5
        assert len(quantity.origin) in (1, robot.n_joints)
        assert set(quantity.origin) <= set(ORIGINS)
        assert not quantity.value.flags.writeable, path


@pytest.mark.parametrize("name", ROBOTS)
def test_every_table_of_the_file_arrives_in_the_quantities(name):
    tree = tomllib.loads(text_of(name))
    values = {}
    for group, entries in tree.items():
        if group in ("robot", "look", "logs"):
            continue
        for entry, table in entries.items():
            inner = {f"{group}.{entry}.{k}": v for k, v in table.items() if k != "bodies"}
            values |= inner if entry == "positions" or group == "springs" else {f"{group}.{entry}": table}
    quantities = load_robot(name).quantities
    assert values.keys() == quantities.keys()
    for path, table in values.items():
        factor = np.pi / 180 if table["unit"].startswith("deg") else 1.0
        if table.get("side") != quantities[path].side:  # from the link side to the motor side
            factor *= load_robot(name).drive.gear_ratio ** float(RULES[path].gear_power)
        np.testing.assert_allclose(quantities[path].value, np.array(table["value"]) * factor, rtol=1e-15)


@pytest.mark.parametrize("name", THESIS_ROBOTS)
@pytest.mark.parametrize(
    ("parameter", "published"),
    [
        ("coulomb", 0.5367),
        ("static", 0.5634),
        ("viscous", 0.0437),
        ("stribeck_velocity", 0.15),
        ("bristle_stiffness", 69.9787),
        ("bristle_damping", 0.6753),
    ],
)
def test_friction_of_joint_1_is_that_of_the_thesis(name, parameter, published):
    robot = load_robot(name)
    assert getattr(robot.friction, parameter)[0] == published
    assert robot.quantities[f"friction.{parameter}"].origin[0] == "sourced"


def test_sourced_numbers_of_the_manipulator_are_the_published_ones(irb4600):
    kinematics = irb4600.kinematics
    assert irb4600.servo.control_dt == 0.004
    assert irb4600.sensors.tracker_noise == 20e-6
    assert irb4600.sensors.tracker_period == 0.001
    np.testing.assert_allclose(np.degrees(kinematics.max_speed), [175, 175, 175, 250, 250, 360], rtol=1e-14)
    np.testing.assert_allclose(np.degrees(kinematics.range[1]), [-90, 150], rtol=1e-14)
    x, z = kinematics.position[:, 0], kinematics.position[:, 2]
    assert x[1] + z[2] + np.hypot(x[4], z[3]) == pytest.approx(2.051, abs=5e-4)  # published reach
    assert z[:4].sum() + 0 == pytest.approx(1.57)


def test_fitted_numbers_keep_what_they_replaced_and_others_have_no_prior(irb4600):
    fitted = {path for path, q in irb4600.quantities.items() if "fitted" in q.origin}
    assert fitted == {path for path, q in irb4600.quantities.items() if q.prior is not None}
    assert {"servo.position_gain", "servo.velocity_gain", "servo.integral_gain", "drive.joint_stiffness"} <= fitted
    for path in fitted:
        quantity = irb4600.quantities[path]
        unfitted = np.array([origin != "fitted" for origin in quantity.origin])
        np.testing.assert_array_equal(quantity.value[unfitted], quantity.prior[unfitted])
        assert np.all(quantity.value[~unfitted] != quantity.prior[~unfitted])
        assert np.all(np.abs(np.log(quantity.value / quantity.prior)) < np.log(20))


def test_infinite_stiffness_is_a_rigid_joint(one_axis):
    assert one_axis.drive.is_rigid.tolist() == [True]
    assert not load_robot("irb4600_60_205").drive.is_rigid.any()


def test_what_may_be_left_out_is_left_out(one_axis):
    assert one_axis.tool is None
    assert one_axis.work_area is None
    assert one_axis.sensors.tracker_period == 0.0


@pytest.mark.parametrize("name", ["irb", "", "irb4600_60_205.tom", "../one_axis"])
def test_an_unknown_robot_is_refused_with_those_there_are(name):
    with pytest.raises(FFGymError, match=f"Unknown robot .* Available: {', '.join(ROBOTS)}"):
        load_robot(name)


def test_an_unknown_robot_is_refused_with_the_sets_of_numbers_there_are():
    with pytest.raises(
        FFGymError, match="other numbers: irb4600_60_205_arm_drives, irb4600_60_205_arm_losses, irb4600"
    ):
        load_robot("irb4600_60_205_arm_loss")


def test_a_file_that_cannot_be_read_is_refused_by_name(tmp_path):
    with pytest.raises(FFGymError, match=r"Robot description .*absent\.toml.*Built-in robots"):
        load_robot(tmp_path / "absent.toml")
    (tmp_path / "folder.toml").mkdir()
    with pytest.raises(FFGymError, match=r"folder\.toml"):
        load_robot(tmp_path / "folder.toml")
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe[robot]")
    with pytest.raises(FFGymError, match=r"bytes\.toml"):
        load_robot(tmp_path / "bytes.toml")


def test_a_file_may_begin_with_a_byte_order_mark(tmp_path):
    """As editors on Windows write it."""
    text = "\ufeff" + text_of("one_axis")
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    assert load_robot(tmp_path / "mine.toml").name == "one_axis"


@pytest.mark.parametrize("name", ["arm.xml", "folder/arm.urdf"])
def test_an_arm_file_is_no_robot_and_the_command_that_makes_one_is_named(name):
    with pytest.raises(FFGymError, match=f"{name} is an arm file.* ffgym robot new {name}$"):
        load_robot(name)


def test_parsing_names_the_text_it_was_given():
    with pytest.raises(FFGymError, match=r"^my robot is not valid TOML: "):
        parse_robot("[robot", where="my robot")
