"""The same questions to every measurement protocol on every robot; new ones of either are picked up by themselves."""

from dataclasses import fields

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.robot import motor_torque
from ffgym.simulation.protocols import PROTOCOLS
from ffgym.simulation.protocols.stage import FASTEST
from tests.simulation.protocols.protocol_samples import CASES, ROBOTS, arm_of, described, protocol_for, schedule_of

CANNOT = {("circles", robot) for robot in ROBOTS if described(robot).work_area is None}
"""Protocols that a robot has no means for: circles need a work area."""

every_case = pytest.mark.parametrize(
    ("robot", "name"), [(robot, name) for robot, name in CASES if (name, robot) not in CANNOT]
)


@pytest.mark.parametrize(("name", "robot"), sorted(CANNOT))
def test_a_protocol_that_a_robot_cannot_run_says_why_in_one_line(robot, name):
    with pytest.raises(FFGymError, match=rf"^Protocol {name} on '{robot}': it has no work area[^\n]*$"):
        schedule_of(robot, name)


@every_case
def test_every_motion_is_within_ranges_speeds_and_torques(robot, name):
    arm = arm_of(robot)
    kinematics, peak = arm.robot.kinematics, arm.robot.drive.peak_torque
    for motion in schedule_of(robot, name):
        reference = motion.reference
        assert not kinematics.beyond_limits(reference.q).any()
        assert np.all(np.abs(reference.dq) <= FASTEST * kinematics.max_speed * (1 + 1e-9))
        torque = motor_torque(arm, reference.q[::7], reference.dq[::7], reference.ddq[::7]).total
        assert np.all(np.abs(torque) < peak)


@every_case
def test_every_motion_begins_and_ends_at_rest_and_moves_as_it_says(robot, name):
    for motion in schedule_of(robot, name):
        reference = motion.reference
        np.testing.assert_allclose(reference.dq[[0, -1]], 0, atol=1e-12)
        dt = reference.t[1]
        step = np.diff(reference.q, axis=0)  # Hermite's rule is exact to the fourth order of the step
        by_speed = dt / 2 * (reference.dq[1:] + reference.dq[:-1])
        by_change = dt**2 / 12 * (reference.ddq[:-1] - reference.ddq[1:])
        way = np.abs(reference.dq).max(axis=0) * dt + 1e-12
        assert np.all(np.abs(step - by_speed - by_change) <= 2e-2 * way)


@every_case
def test_motions_have_names_of_their_own_that_begin_with_the_protocol(robot, name):
    names = [motion.reference.name for motion in schedule_of(robot, name)]
    assert len({*names}) == len(names)
    assert all(text.startswith(f"{name}.") for text in names)
    assert all(motion.reference.phases for motion in schedule_of(robot, name))


@pytest.mark.parametrize("name", PROTOCOLS)
def test_a_protocol_made_again_is_the_same_to_the_bit(name):
    robot = "two_link"
    for one, other in zip(schedule_of(robot, name), protocol_for(robot, name).schedule(arm_of(robot)), strict=True):
        assert (one.pause, one.reference.name) == (other.pause, other.reference.name)
        np.testing.assert_array_equal(one.reference.q, other.reference.q)


@pytest.mark.parametrize("protocol", PROTOCOLS.values(), ids=list(PROTOCOLS))
def test_every_protocol_says_what_it_serves_and_what_its_settings_mean(protocol):
    assert protocol.purpose
    assert protocol.__doc__
    for setting in fields(protocol):
        assert setting.metadata["meaning"], setting.name
