"""The correction is the least-squares solution, where no torque can be improved."""

import numpy as np
import pytest
from scipy.signal import fftconvolve

from ffgym.agents.torque_response import NormOptimalStep, TorqueResponse
from ffgym.core.errors import FFGymError
from ffgym.robot import RigidArm

SAMPLES, REST = 60, 12_000
"""Length of the error, and of the rest after it, in which the slowest consequence of a torque dies away."""


def slope(response, error, torque, tolerance, scale):
    """Derivative of half the cost by each torque, and its part from the torques alone, (T, N) each."""
    left = error - response.along(torque)
    from_error = np.zeros_like(torque)
    for j in range(torque.shape[1]):
        impulse = np.zeros_like(torque)
        impulse[0, j] = 1.0
        answer = response.along(impulse)
        for i in range(error.shape[1]):  # correlation: what a torque does to all errors after it
            from_error[:, j] -= fftconvolve(left[::-1, i], answer[:, i])[: len(left)][::-1] / tolerance**2
    from_torque = torque / scale**2
    return from_error + from_torque, from_torque


@pytest.mark.parametrize(("target", "tolerance"), [("motor", 4e-3), ("tcp", 2e-5), ("tcp", 1e-4)])
def test_the_correction_is_the_least_squares_solution(arm, corners, target, tolerance):
    response = TorqueResponse.of(arm, corners["p1"], target)
    scale = arm.robot.friction.coulomb
    error = np.zeros((SAMPLES + REST, len(response.output)))
    bumps = np.random.default_rng(1).normal(size=error.shape[1])
    error[:SAMPLES] = 5 * tolerance * np.sin(np.linspace(0, np.pi, SAMPLES))[:, None] * bumps
    found = NormOptimalStep.of(response, tolerance, scale).correction(error)
    assert not found[0].any()
    total, from_torque = slope(response, error, found, tolerance, scale)
    inner = slice(1, 3 * SAMPLES)
    assert np.abs(total[inner]).max() < 1e-3 * np.abs(from_torque[inner]).max()


def test_a_smaller_tolerance_leaves_less_error_and_asks_for_more_torque(arm, corners):
    response = TorqueResponse.of(arm, corners["p3"], "tcp")
    error = 1e-4 * np.sin(np.arange(150) * 0.1)[:, None] * np.ones(3)
    left, asked = [], []
    for tolerance in (1e-4, 3e-5, 1e-5):
        torque = NormOptimalStep.of(response, tolerance, arm.robot.friction.coulomb).correction(error)
        left.append(np.linalg.norm(error - response.along(torque)))
        asked.append(np.linalg.norm(torque))
    assert left == sorted(left, reverse=True)
    assert asked == sorted(asked)


def test_no_error_needs_no_correction(arm, corners):
    response = TorqueResponse.of(arm, corners["p1"], "tcp")
    step = NormOptimalStep.of(response, 1e-5, arm.robot.friction.coulomb)
    assert not step.correction(np.zeros((30, 3))).any()


def test_a_tolerance_of_zero_and_a_servo_that_holds_nothing_are_refused(arm, irb4600, corners, without_servo):
    response = TorqueResponse.of(arm, corners["p1"], "tcp")
    with pytest.raises(FFGymError, match=r"tolerance = 0\.0 rad or m is out of range"):
        NormOptimalStep.of(response, 0.0, irb4600.friction.coulomb)
    loose = TorqueResponse.of(RigidArm(without_servo(irb4600)), corners["p1"], "tcp")
    with pytest.raises(FFGymError, match="The servo must hold every motor"):
        NormOptimalStep.of(loose, 1e-5, irb4600.friction.coulomb)
