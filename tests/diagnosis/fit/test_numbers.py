"""Numbers of a machine that are corrected within their calibration."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.diagnosis.fit.written import possible_numbers, with_numbers
from ffgym.diagnosis.nuisance import NuisanceParameter
from ffgym.diagnosis.sensitivity import Sensitivity
from ffgym.effects import EFFECTS
from ffgym.robot import load_robot
from ffgym.simulation.plant import Machine


def doubt(name, parameter, joint="", sigma=0.05, part=None):
    kind = EFFECTS[name]
    column = Sensitivity(effect=kind, joint=joint, parameter=parameter, part=part, parts={})
    return NuisanceParameter(column=column, sigma=sigma)


@pytest.fixture
def machine():
    """Breakaway torques are 4 % above Coulomb torques."""
    robot = load_robot("two_link")
    friction = replace(robot.friction, static=1.04 * robot.friction.coulomb)
    return Machine.of(replace(robot, friction=friction))


def test_a_breakaway_torque_comes_down_to_the_coulomb_torque_and_no_other_number_stays_behind(machine):
    """A peak of one joint that no machine has would else leave all joints without their own."""
    one, other = machine.robot.joints
    doubts = [
        doubt("stribeck_peak", "level", one),
        doubt("stribeck_peak", "level", other),
        doubt("stribeck_peak", "velocity", one),
        doubt("viscous_level", "change", other),
    ]
    found = with_numbers(machine, doubts, np.array([-2.0, 1.0, 1.0, 2.0])).physical.friction
    plain = machine.physical.friction
    np.testing.assert_allclose(found.static / found.coulomb, [1.0, 1.09], rtol=1e-9)
    assert np.all(found.static >= found.coulomb)
    np.testing.assert_allclose(found.stribeck_velocity / plain.stribeck_velocity, [1.05, 1.0])
    np.testing.assert_allclose(found.viscous / plain.viscous, [1.0, 1.1])


def test_numbers_go_into_the_description_where_it_has_them_and_stand_beside_it_where_it_has_not(machine):
    before = EFFECTS["torque_offset"](offset=np.array([0.3, 0.0]))
    begun = replace(machine, effects=(before,))
    one = machine.robot.joints[0]
    doubts = [
        doubt("coulomb_level", "change", one),
        doubt("tool_frame", "offset", sigma=1e-3, part=1),
        doubt("tool_frame", "offset", sigma=1e-3, part=2),
        doubt("torque_clock", "latency", sigma=2e-4),
        doubt("viscous_level", "change", one),
    ]
    found = with_numbers(begun, doubts, np.array([2.0, -1.5, 0.5, 3.0, 0.0]))
    assert found.effects[0] is before
    frame, clock = found.effects[1:]
    np.testing.assert_allclose(frame.offset, [0.0, -1.5e-3, 0.5e-3])
    assert float(clock.latency) == pytest.approx(6e-4)
    np.testing.assert_allclose(found.robot.friction.coulomb / machine.robot.friction.coulomb, [1.1, 1.0])
    np.testing.assert_array_equal(found.robot.friction.viscous, machine.robot.friction.viscous)


def test_each_doubt_has_a_size(machine):
    with pytest.raises(ValueError, match="longer"):
        with_numbers(machine, [doubt("torque_clock", "latency")], np.zeros(2))


def test_where_numbers_are_none_that_a_machine_can_have_there_is_no_machine(machine):
    one = machine.robot.joints[0]
    setting = SimpleNamespace(nominal=machine, nuisances=[doubt("coulomb_level", "change", one)])
    assert possible_numbers(setting, np.array([2.0])) is not None
    assert possible_numbers(setting, np.array([-30.0])) is None  # friction that drives
