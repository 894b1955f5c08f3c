"""The motions that learning families are trained on."""

from dataclasses import replace

import pytest

from ffgym.agents.trials import every_speed, friction_motions, thesis_motions, training_motions
from ffgym.core.errors import FFGymError
from ffgym.robot import RigidArm


def test_the_thesis_learns_at_p1_at_10_mm_s_and_on_the_sine_of_1_hz(arm, one_axis):
    assert [motion.name for motion in thesis_motions(arm)] == ["p1, 10 mm/s"]
    assert [motion.name for motion in thesis_motions(RigidArm(one_axis))] == ["sine 1 Hz"]


def test_every_speed_of_the_tests_can_be_shown(arm, one_axis):
    assert [motion.name for motion in every_speed(arm)] == ["p1, 10 mm/s", "p1, 40 mm/s", "p1, 100 mm/s"]
    assert [motion.name for motion in every_speed(RigidArm(one_axis))] == ["sine 1 Hz", "sine 3 Hz"]


def test_friction_is_learned_where_it_is_most_of_the_feedback(arm, one_axis):
    assert [motion.name for motion in friction_motions(arm)] == ["p1, 10 mm/s", "p1, 40 mm/s"]
    assert [motion.name for motion in friction_motions(RigidArm(one_axis))] == ["sine 1 Hz", "sine 3 Hz"]


def test_positions_and_speeds_can_be_chosen(arm):
    names = [motion.name for motion in training_motions(arm, ["p2", "p3"], [0.1])]
    assert names == ["p2, 100 mm/s", "p3, 100 mm/s"]


def test_a_robot_without_test_motion_is_refused(irb4600):
    arm = RigidArm(replace(irb4600, work_area=None))
    with pytest.raises(FFGymError, match="no test motion to learn on; give"):
        thesis_motions(arm)
