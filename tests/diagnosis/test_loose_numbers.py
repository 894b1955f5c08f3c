"""Causes and none, where the numbers of a machine are known to 5 % only."""

import pytest

from ffgym.diagnosis import diagnose
from scripts.exam.independent.question import draw_task


def test_breakaway_and_coulomb_torque_that_are_off_against_each_other_are_no_cause():
    """Breakaway torque 15 % up and Coulomb torque 10 % down: 3 and 2 standard deviations of numbers known to 5 %."""
    task = draw_task("clean", 29, seed=44)
    assert diagnose(task.robot, task.log, prior=task.prior).verdict == "none"


@pytest.mark.slow
def test_a_cause_is_found_though_numbers_that_are_fitted_alone_take_up_half_of_it():
    """A quarter of the friction behind the spring: fitted alone, masses and spring leave the shape of no effect."""
    task = draw_task("arm", 13, seed=41)
    found = diagnose(task.robot, task.log, prior=task.prior)
    assert found.verdict == "named"
    assert [(cause.effect, cause.joint) for cause in found.causes] == [("arm_friction", "a1")]
    low, high = found.causes[0].parameters[0].interval
    assert low - 0.01 < 0.2525 < high + 0.01
