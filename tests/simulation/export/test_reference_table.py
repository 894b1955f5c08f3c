"""Columns of the reference table: sides, units, torques."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.paths import joint_reference, joint_sine
from ffgym.simulation.export import ReferenceForm, reference_table
from tests.robot.robot_samples import unusual


@pytest.fixture(scope="module")
def reference(irb4600):
    robot = unusual(irb4600)
    path = joint_sine(np.full(6, 0.05), 1.0, 0.4, centre=robot.work_area.home, dt=robot.servo.control_dt)
    return joint_reference(robot, path)


@pytest.fixture(scope="module")
def torques(reference):
    rng = np.random.default_rng(0)
    return rng.normal(size=(2, *reference.q.shape))


def stacked(table, start, unit):
    """Columns of a quantity, shape (T, N), where `unit` may differ for the first joint."""
    columns = [values for name, values in table.items() if name.startswith(start)]
    assert [name.split("[")[1] for name in table if name.startswith(start)] == [f"{u}]" for u in unit]
    return np.stack(columns, axis=1)


def test_it_begins_with_time_and_has_six_quantities_on_both_sides(reference, torques):
    table = reference_table(reference, *torques, ReferenceForm())
    assert len(table) == 1 + 2 * 6 * 6
    assert next(iter(table)) == "t [s]"
    np.testing.assert_array_equal(table["t [s]"], reference.t)


def test_motor_quantities_are_those_of_the_drive(reference, torques):
    table = reference_table(reference, *torques, ReferenceForm(sides="motor"))
    assert not any(name.startswith("link") for name in table)
    for name, unit, values in (
        ("position", "rad", reference.motor_q),
        ("velocity", "rad/s", reference.motor_dq),
        ("acceleration", "rad/s^2", reference.motor_ddq),
        ("u_ff", "N m", torques[0]),
        ("u_lff", "N m", torques[1]),
        ("u_total", "N m", torques[0] + torques[1]),
    ):
        np.testing.assert_array_equal(stacked(table, f"motor.{name}.", [unit] * 6), values)


def test_link_quantities_are_behind_the_gearbox_and_slides_have_metres(reference, torques):
    table = reference_table(reference, *torques, ReferenceForm(sides="link"))
    drive = reference.robot.drive
    for name, slide, hinge, values in (
        ("position", "m", "rad", reference.q),
        ("velocity", "m/s", "rad/s", reference.dq),
        ("acceleration", "m/s^2", "rad/s^2", reference.ddq),
        ("u_ff", "N", "N m", drive.joint_torque(torques[0])),
        ("u_total", "N", "N m", drive.joint_torque(torques[0] + torques[1])),
    ):
        np.testing.assert_array_equal(stacked(table, f"link.{name}.", [slide] + [hinge] * 5), values)


@pytest.mark.parametrize(("angles", "turn"), [("rad", 2 * np.pi), ("deg", 360.0), ("turn", 1.0)])
def test_the_power_of_the_feed_forward_is_the_same_on_both_sides_in_every_unit(reference, torques, angles, turn):
    table = reference_table(reference, *torques, ReferenceForm(angles=angles))
    per_radian = turn / (2 * np.pi)
    speed = stacked(table, "motor.velocity.", [f"{angles}/s"] * 6) / per_radian
    motor = np.sum(speed * stacked(table, "motor.u_total.", ["N m"] * 6), axis=1)
    speed = stacked(table, "link.velocity.", ["m/s"] + [f"{angles}/s"] * 5)
    speed[:, 1:] /= per_radian
    link = np.sum(speed * stacked(table, "link.u_total.", ["N"] + ["N m"] * 5), axis=1)
    np.testing.assert_allclose(motor, link, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("form", [{"sides": "tool"}, {"angles": "grad"}])
def test_another_form_is_refused(form):
    with pytest.raises(FFGymError, match="Available"):
        ReferenceForm(**form)
    assert replace(ReferenceForm(), sides="link").angles == "rad"
