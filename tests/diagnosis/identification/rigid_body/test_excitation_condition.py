"""What a motion will tell is known before it is run: better motions give narrower intervals."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.diagnosis.identification.rigid_body import (
    RigidBodyOptions,
    excitation_condition,
    identify_rigid_body,
)
from ffgym.paths import joint_reference, joint_sine
from ffgym.robot import load_robot
from tests.diagnosis.identification.rigid_body.recorded_arms import recorded, rigid, swing

WEAK = RigidBodyOptions(spread=10.0, resamples=2)
"""The data alone."""


@pytest.fixture(scope="module")
def robot():
    return rigid(load_robot("two_link"))


def test_a_joint_that_stands_still_tells_nothing(robot):
    path = swing(robot, 0)
    still = np.array([1.0, 0.0])
    poor = replace(path, q=path.q * still, dq=path.dq * still, ddq=path.ddq * still)
    assert excitation_condition(joint_reference(robot, poor)) == np.inf
    assert excitation_condition(joint_reference(robot, path)) < 200


def test_the_best_of_several_motions_tells_more_than_joints_that_sway_together(robot):
    """One sine, the same on both joints, beside sums of sines with random phases."""
    sway = joint_sine([0.4, 0.4], 0.25, 12.0, dt=robot.servo.control_dt)
    paths = [sway, *(swing(robot, seed, duration=12.0) for seed in range(4))]
    references = [joint_reference(robot, path) for path in paths]
    conditions = [excitation_condition(reference) for reference in references]
    best = int(np.argmin(conditions))
    assert conditions[best] < 0.3 * conditions[0]
    assert worst_error(robot, paths[best]) < 0.5 * worst_error(robot, sway)


def worst_error(robot, path):
    """RMS error over two seeds of the noise of the combination that is told worst, in units of the torque it makes."""
    errors = []
    for seed in range(2):
        fit = identify_rigid_body(robot, [recorded(robot, path, noise=0.05, seed=seed)], WEAK)
        errors.append(fit.base.values(fit.estimate - fit.described))
    columns = fit.equations([recorded(robot, path)]).columns[:, fit.base.own]
    action = np.sqrt(np.mean(columns**2, axis=0)).max(axis=1)
    return np.max(np.sqrt(np.mean(np.square(errors), axis=0)) * action)
