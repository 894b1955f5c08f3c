"""Numbers of a machine that are corrected within their calibration."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.diagnosis.fit.written import with_numbers
from ffgym.diagnosis.nuisance import NuisanceParameter
from ffgym.diagnosis.sensitivity import Sensitivity
from ffgym.effects import EFFECTS
from ffgym.robot import load_robot
from ffgym.simulation.plant import Machine


def doubt(name, parameter, joint, sigma=0.05):
    kind = EFFECTS[name]
    column = Sensitivity(effect=kind, joint=joint, parameter=parameter, parts={})
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
