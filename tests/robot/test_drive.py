"""Both sides of the gearbox: angles and torques go over and back, and power is the same on either."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ffgym.core.errors import FFGymError
from ffgym.robot import compile_model, parse_robot
from ffgym.robot.drive import Drive
from ffgym.robot.reading.quantity import parse_quantity
from ffgym.robot.reading.rules import RULES

RATIOS = st.floats(20, 200) | st.floats(-200, -20)


def drive(ratio, coupling=None):
    n = len(ratio)
    one = np.ones(n)
    return Drive(
        gear_ratio=np.array(ratio),
        rotor_inertia=one,
        joint_stiffness=one,
        joint_damping=one,
        peak_torque=one,
        coupling=None if coupling is None else np.array(coupling),
    )


@st.composite
def drives(draw):
    """Drives with couplings that are smaller than the gear ratios, as in every wrist."""
    ratio = draw(st.lists(RATIOS, min_size=3, max_size=3))
    coupling = draw(arrays(np.float64, (3, 3), elements=st.floats(-9, 9))) * (1 - np.eye(3))
    return drive(ratio, coupling if draw(st.booleans()) else None)


@given(drives(), arrays(np.float64, (5, 3), elements=st.floats(-3, 3)), st.integers(0, 99))
def test_angles_and_torques_go_over_the_gearbox_and_back(one, q, seed):
    np.testing.assert_allclose(one.joint_angle(one.motor_angle(q)), q, atol=1e-12)
    np.testing.assert_allclose(one.motor_torque(one.joint_torque(q)), q, atol=1e-12)
    np.testing.assert_allclose(one.motor_angle(q), q @ one.matrix.T, atol=1e-11)
    torque = np.random.default_rng(seed).normal(size=q.shape)
    motor_power = np.sum(torque * one.motor_angle(q), axis=1)
    np.testing.assert_allclose(motor_power, np.sum(one.joint_torque(torque) * q, axis=1), atol=1e-9)


@given(drives(), arrays(np.float64, (4, 3), elements=st.floats(-3, 3)))
def test_a_row_does_not_depend_on_the_others(one, q):
    for convert in (one.motor_angle, one.joint_angle, one.motor_torque, one.joint_torque):
        together = convert(q)
        for k, row in enumerate(q):
            np.testing.assert_array_equal(convert(row), together[k])


def test_a_coupling_of_zeros_is_none():
    assert drive([50.0, 60.0], np.zeros((2, 2))).coupling is None


@pytest.mark.parametrize(
    ("coupling", "message"),
    [
        ([[1.0, 0], [0, 0]], "on its diagonal, must be 0"),
        ([[0.0, 50], [50, 0]], "leaves joint motions that turn no motor"),
        ([[0.0, 1, 2], [0, 0, 0]], "drive.coupling has shape"),
    ],
)
def test_a_coupling_that_is_none_is_refused(coupling, message):
    with pytest.raises(FFGymError, match=message):
        drive([50.0, 50.0], coupling)


def quantity(path, value, unit, side):
    table = {"value": value, "unit": unit, "origin": "chosen", "source": "test"}
    return parse_quantity(
        path, table | ({"side": side} if side else {}), RULES[path], ("hinge", "slide"), np.array([-100.0, 2000.0])
    ).value


@pytest.mark.parametrize(
    ("path", "link", "units", "motor"),
    [
        ("friction.coulomb", [50.0, 40.0], ["N m", "N"], [0.5, 0.02]),
        ("friction.viscous", [200.0, 400.0], ["N m s/rad", "N s/m"], [0.02, 1e-4]),
        ("friction.stribeck_velocity", [0.01, 0.005], ["rad/s", "m/s"], [1.0, 10.0]),
        ("drive.rotor_inertia", [10.0, 40.0], ["kg m^2", "kg"], [1e-3, 1e-5]),
    ],
)
def test_numbers_of_the_motor_may_be_given_on_the_link_side(path, link, units, motor):
    np.testing.assert_allclose(quantity(path, link, units, "link"), motor)
    np.testing.assert_allclose(quantity(path, motor, RULES[path].unit, "motor"), motor)


def test_numbers_of_the_link_may_be_given_on_the_motor_side():
    stiffness = quantity("drive.joint_stiffness", [10.0, 1e-3], "N m/rad", "motor")
    np.testing.assert_allclose(stiffness, [1e5, 4e3])


def test_each_joint_may_have_its_own_unit():
    np.testing.assert_allclose(
        quantity("kinematics.range", [[-180.0, 90.0], [0.0, 250.0]], ["deg", "mm"], "link"),
        [[-np.pi, np.pi / 2], [0.0, 0.25]],
    )
    with pytest.raises(FFGymError, match=r"unit is 'rad', must be one per joint, \['rad', 'm'\]"):
        quantity("kinematics.range", [[-1.0, 1.0], [0.0, 1.0]], "rad", "link")


def test_a_mixed_robot_keeps_its_units(irb4600):
    assert set(irb4600.kinematics.units) == {"rad"}
    mixed = replace(irb4600.kinematics, types=("slide", *["hinge"] * 5))
    assert mixed.units == ("m", *["rad"] * 5)
    with pytest.raises(FFGymError, match="joint type 'ball'"):
        replace(irb4600.kinematics, types=("ball",) * 6)


def test_springs_of_a_description_join_two_of_its_bodies(one_axis_text):
    spring = """
[springs.balance]
bodies = ["base", "BODY"]
start = { value = [0.1, 0.0, 0.0], unit = "m", origin = "chosen", source = "test" }
end = { value = [0.0, 100.0, 0.0], unit = "mm", origin = "chosen", source = "test" }
length = { value = 0.05, unit = "m", origin = "chosen", source = "test" }
stiffness = { value = 2000.0, unit = "N/m", origin = "chosen", source = "test" }
"""
    robot = parse_robot(one_axis_text + spring.replace("BODY", "load"))
    (balance,) = robot.springs
    assert balance.stiffness == (2000.0, 0.0, 0.0)
    np.testing.assert_allclose(balance.end, [0.0, 0.1, 0.0])
    assert robot.quantities["springs.balance.length"].source == "test"
    for body, message in (("base", "to itself"), ("elbow", "body of springs.balance"), ("tool", "body of springs")):
        with pytest.raises(FFGymError, match=message):
            parse_robot(one_axis_text + spring.replace("BODY", body))
    with pytest.raises(FFGymError, match="must have two bodies and"):
        parse_robot(one_axis_text + spring.replace("stiffness", "softness"))


def test_looks_of_a_tool_that_is_not_there_are_not_drawn(irb4600):
    bare = compile_model(replace(irb4600, tool=None, work_area=None))
    assert bare.ngeom < compile_model(irb4600).ngeom


def test_logs_say_on_which_side_they_are(one_axis_text):
    robot = parse_robot(one_axis_text + '\n[logs]\ntorque = "link_side"\nposition = "link"\n')
    assert (robot.logs.torque, robot.logs.position) == ("link_side", "link")
    with pytest.raises(FFGymError, match=r"logs.torque 'volts'"):
        parse_robot(one_axis_text + '\n[logs]\ntorque = "volts"\n')
    with pytest.raises(FFGymError, match=r"\[logs\] may have torque and position"):
        parse_robot(one_axis_text + '\n[logs]\nspeed = "link"\n')
