"""First weights from a constant friction: estimated from a trial, without parameters of the machine."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.agents.bspline import ExtendedBSN
from ffgym.agents.coulomb_prior import STEEPNESS, CoulombPrior
from ffgym.agents.trials import SimulatedTrial, thesis_motions
from ffgym.core.errors import FFGymError
from ffgym.robot import RigidArm
from tests.agents.lesson_samples import lesson


@pytest.fixture(scope="module")
def sine(one_axis):
    return thesis_motions(RigidArm(one_axis))[0]


def friction(speed, coulomb, viscous=0.0):
    return coulomb * np.tanh(STEEPNESS * speed) + viscous * speed


def test_known_friction_is_found_whatever_constant_torque_stands_beside_it(sine):
    speeds = [np.column_stack([s * np.sin(np.linspace(0, 9, 400)), s * np.cos(np.linspace(0, 9, 400))]) for s in (2, 5)]
    coulomb, viscous = np.array([0.5, 1.2]), np.array([0.03, 0.2])
    lessons = [
        lesson(sine, friction(v, coulomb, viscous) + gravity, motor_dq=v, motor_ddq=v)
        for v, gravity in zip(speeds, ([7.0, -3.0], [-1.0, 4.0]), strict=True)
    ]
    found = CoulombPrior.from_lessons(lessons, viscous=True)
    np.testing.assert_allclose(found.coulomb, coulomb, rtol=1e-9)
    np.testing.assert_allclose(found.viscous, viscous, rtol=1e-9)


def test_what_a_law_already_added_counts_as_friction_too(sine):
    speed = np.sin(np.linspace(0, 9, 400))[:, None]
    known = lesson(sine, friction(speed, 0.2), motor_dq=speed, motor_ddq=speed)
    found = CoulombPrior.from_lessons([replace(known, added=friction(speed, 0.3))])
    np.testing.assert_allclose(found.coulomb, 0.5, rtol=1e-9)


def test_standstill_does_not_count(sine):
    speed = np.sin(np.linspace(0, 9, 400))[:, None]
    torque = friction(speed, 0.5)
    torque[:100] = 50.0
    known = lesson(sine, torque, motor_dq=speed, motor_ddq=speed, moving=np.arange(400) >= 100)
    np.testing.assert_allclose(CoulombPrior.from_lessons([known]).coulomb, 0.5, rtol=1e-9)


def test_torque_against_the_motion_is_no_friction(sine):
    speed = np.sin(np.linspace(0, 9, 400))[:, None]
    found = CoulombPrior.from_lessons(
        [lesson(sine, friction(speed, -0.5, -0.1), motor_dq=speed, motor_ddq=speed)], True
    )
    assert (found.coulomb, found.viscous) == (0, 0)


def test_a_joint_that_never_moves_has_no_prior(sine):
    speed = np.column_stack([np.sin(np.linspace(0, 9, 400)), np.zeros(400)])
    found = CoulombPrior.from_lessons([lesson(sine, friction(speed, 0.5) + 1.0, motor_dq=speed, motor_ddq=speed)])
    np.testing.assert_allclose(found.coulomb, [0.5, 0], atol=1e-9)


def test_one_slow_trial_on_the_robot_gives_the_true_coulomb_torque_of_motors_that_slide(arm):
    """Joints 1 to 4 within 5 %; 5 and 6 hardly leave presliding at p1 at 10 mm/s, where no method could tell."""
    found = CoulombPrior.from_trial(thesis_motions(arm), SimulatedTrial(arm=arm))
    share = found.coulomb / arm.robot.friction.coulomb
    np.testing.assert_allclose(share[:4], 1, atol=0.05)
    assert np.all((share[4:] > 0.5) & (share[4:] < 1.1))


def test_a_network_follows_its_prior():
    prior = CoulombPrior(coulomb=np.array([0.5, 1.0]), viscous=np.array([0.0, 0.1]))
    network = ExtendedBSN.zero(2).with_curve(prior.torque_at)
    speeds = np.array([[-20.0, 20.0], [0.05, -3.0], [0.0, 0.0]])
    np.testing.assert_allclose(network.torque_at(speeds, -speeds), prior.torque_at(speeds), rtol=0, atol=1e-12)


@pytest.mark.parametrize("wrong", [{"coulomb": [-1.0]}, {"coulomb": [1.0], "viscous": [-0.1]}, {"coulomb": 1.0}])
def test_friction_below_zero_or_of_no_joints_is_refused(wrong):
    with pytest.raises(FFGymError, match=r"coulomb|viscous"):
        CoulombPrior(**wrong)


def test_an_estimate_needs_a_lesson():
    with pytest.raises(FFGymError, match="no lesson"):
        CoulombPrior.from_lessons([])
